//! Floats rounded to bf16, two in the bits of one float: the first in the upper half.

use crate::lengths::{at_least, exactly};
use crate::simd::{Simd, at_level};

/// Returns the nearest bf16 (even among equals) in the upper half of its bits, garbage below; NaN stays NaN.
#[inline(always)]
fn rounded(value: f32) -> u32 {
    let bits = value.to_bits();
    let up = bits.wrapping_add(0x7fff + ((bits >> 16) & 1));
    if value.is_nan() { bits | 0x0040_0000 } else { up }
}

/// Returns two values as one pair.
#[inline(always)]
pub(super) fn pair(first: f32, second: f32) -> f32 {
    f32::from_bits((rounded(first) & 0xffff_0000) | (rounded(second) >> 16))
}

at_level! {
    /// Makes pairs of neighbours in rows of `len` values that start `pitch` apart: rows of `len / 2` pairs, rounded up, the
    /// last with 0 where `len` is odd.
    pub(crate) fn pair_columns_of_rows(len: usize, pitch: usize, x: &[f32], pairs: &mut [f32]) = columns_at
}

/// Computes [`pair_columns_of_rows`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn columns_at<S: Simd>(len: usize, pitch: usize, x: &[f32], pairs: &mut [f32]) {
    let width = len.div_ceil(2);
    for (row, pairs) in pairs.chunks_exact_mut(width).enumerate() {
        let x = &x[row * pitch..][..len];
        let (whole, rest) = x.as_chunks::<2>();
        for (to, &[first, second]) in pairs.iter_mut().zip(whole) {
            *to = pair(first, second);
        }
        if let [last] = rest {
            pairs[width - 1] = pair(*last, 0.0);
        }
    }
}

at_level! {
    /// Makes pairs of rows, `len` values each that start `pitch` apart: `rows / 2` rows of pairs, rounded up, the last with
    /// 0 where `rows` is odd.
    pub(crate) fn pair_rows(rows: usize, len: usize, pitch: usize, x: &[f32], pairs: &mut [f32]) = rows_at
}

/// Computes [`pair_rows`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn rows_at<S: Simd>(rows: usize, len: usize, pitch: usize, x: &[f32], pairs: &mut [f32]) {
    at_least("pairs of rows", pairs.len(), rows.div_ceil(2) * len);
    for (number, pairs) in pairs.chunks_exact_mut(len.max(1)).take(rows.div_ceil(2)).enumerate() {
        let first = &x[2 * number * pitch..][..len];
        if 2 * number + 1 < rows {
            let second = &x[(2 * number + 1) * pitch..][..len];
            for ((to, &first), &second) in pairs.iter_mut().zip(first).zip(second) {
                *to = pair(first, second);
            }
        } else {
            pairs.iter_mut().zip(first).for_each(|(to, &first)| *to = pair(first, 0.0));
        }
    }
}

at_level! {
    /// Makes a pair of every value and the one `later` places after it; 0 where there is none.
    pub(crate) fn pair_with_later(later: usize, x: &[f32], pairs: &mut [f32]) = later_at
}

/// Computes [`pair_with_later`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn later_at<S: Simd>(later: usize, x: &[f32], pairs: &mut [f32]) {
    exactly("pairs of values", pairs.len(), x.len());
    let both = x.len().saturating_sub(later);
    let second = &x[x.len() - both..];
    for ((to, &first), &second) in pairs[..both].iter_mut().zip(&x[..both]).zip(second) {
        *to = pair(first, second);
    }
    for (to, &first) in pairs[both..].iter_mut().zip(&x[both..]) {
        *to = pair(first, 0.0);
    }
}
