//! Floats rounded to bf16 (nearest, even), two in the bits of one float: the first in the upper half.
//!
//! The processor's own instructions round: NaN stays NaN, subnormal numbers become zero. All functions panic where
//! [`supported`](super::supported) is an error.

use super::support::assert_supported;
use crate::lengths::{at_least, exactly, reach};

/// Makes pairs of neighbours in rows of `len` values that start `pitch` apart: rows of `len / 2` pairs, rounded up, the
/// last with 0 where `len` is odd.
pub(crate) fn pair_columns_of_rows(len: usize, pitch: usize, x: &[f32], pairs: &mut [f32]) {
    assert_supported();
    let width = len.div_ceil(2);
    if width == 0 {
        return;
    }
    let rows = pairs.len() / width;
    at_least("values to be rounded", x.len(), reach(rows, pitch, len));
    if pitch == len && len.is_multiple_of(2) {
        // All rows are one.
        return neighbours(&x[..rows * len], &mut pairs[..rows * width]);
    }
    for (row, pairs) in pairs.chunks_exact_mut(width).enumerate() {
        neighbours(&x[row * pitch..][..len], pairs);
    }
}

/// Makes pairs of rows, `len` values each that start `pitch` apart: `rows / 2` rows of pairs, rounded up, the last with
/// 0 where `rows` is odd.
pub(crate) fn pair_rows(rows: usize, len: usize, pitch: usize, x: &[f32], pairs: &mut [f32]) {
    assert_supported();
    at_least("pairs of rows", pairs.len(), rows.div_ceil(2) * len);
    if len == 0 {
        return;
    }
    for (number, pairs) in pairs.chunks_exact_mut(len).take(rows.div_ceil(2)).enumerate() {
        let first = &x[2 * number * pitch..][..len];
        let second = if 2 * number + 1 < rows { &x[(2 * number + 1) * pitch..][..len] } else { &[] };
        beside(first, second, pairs);
    }
}

/// Makes a pair of every value and the one `later` places after it; 0 where there is none.
pub(crate) fn pair_with_later(later: usize, x: &[f32], pairs: &mut [f32]) {
    assert_supported();
    exactly("pairs of values", pairs.len(), x.len());
    let (both, alone) = x.split_at(x.len().saturating_sub(later));
    beside(both, &x[x.len() - both.len()..], &mut pairs[..both.len()]);
    beside(alone, &[], &mut pairs[both.len()..]);
}

/// Makes pairs of neighbours; the last with 0 where there is an odd number of values.
fn neighbours(x: &[f32], pairs: &mut [f32]) {
    exactly("pairs of neighbours", pairs.len(), x.len().div_ceil(2));
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: the callers have asserted the features, the line above the lengths.
        unsafe { neighbours_at(x, pairs) };
    }
}

/// Makes pairs of values that lie at the same place of both; with 0 where the second is empty.
fn beside(first: &[f32], second: &[f32], pairs: &mut [f32]) {
    exactly("pairs of two rows", pairs.len(), first.len());
    assert!(second.is_empty() || second.len() == first.len(), "rows of one length are needed");
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: the callers have asserted the features, the lines above the lengths.
        unsafe { beside_at(first, second, pairs) };
    }
}

/// Computes [`neighbours`].
///
/// # Safety
/// The CPU has AVX512-BF16 and AVX512-BW; `pairs` holds half as many values as `x`, rounded up.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
unsafe fn neighbours_at(x: &[f32], pairs: &mut [f32]) {
    use crate::simd::{Avx512, Simd};
    use std::arch::x86_64::{
        __m512, __m512bh, __m512i, _mm512_castsi512_ps, _mm512_cvtne2ps_pbh, _mm512_rol_epi32,
    };
    const STEP: usize = 2 * Avx512::LANES;
    // SAFETY: whole steps lie inside both slices, by their lengths; of the rest, only the lanes that are there are touched.
    unsafe {
        let (from, to) = (x.as_ptr(), pairs.as_mut_ptr());
        let rounded = |low: __m512, high: __m512| {
            let both = std::mem::transmute::<__m512bh, __m512i>(_mm512_cvtne2ps_pbh(high, low));
            // The instruction leaves the first of two neighbours in the lower half.
            _mm512_castsi512_ps(_mm512_rol_epi32::<16>(both))
        };
        let rest = x.len() % STEP;
        for at in (0..x.len() - rest).step_by(STEP) {
            let (low, high) = (Avx512::load(from.add(at)), Avx512::load(from.add(at + Avx512::LANES)));
            Avx512::store(to.add(at / 2), rounded(low, high));
        }
        if rest > 0 {
            let at = x.len() - rest;
            let low = Avx512::load_first(from.add(at), rest.min(Avx512::LANES));
            let high = match rest.checked_sub(Avx512::LANES) {
                Some(more) => Avx512::load_first(from.add(at + Avx512::LANES), more),
                None => Avx512::splat(0.0),
            };
            Avx512::store_first(to.add(at / 2), rounded(low, high), rest.div_ceil(2));
        }
    }
}

/// Computes [`beside`].
///
/// # Safety
/// The CPU has AVX512-BF16 and AVX512-BW; the three are of one length, or `second` is empty.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
unsafe fn beside_at(first: &[f32], second: &[f32], pairs: &mut [f32]) {
    use crate::simd::{Avx512, Simd};
    use std::arch::x86_64::{
        __m512, __m512bh, __m512i, _mm512_castsi512_ps, _mm512_cvtne2ps_pbh, _mm512_permutexvar_epi16,
    };
    /// Lane 2i + 1 is value i of the first row, lane 2i of the second, which lies 16 lanes behind.
    const ORDER: [u16; 32] = {
        let mut order = [0; 32];
        let mut lane = 0;
        while lane < 32 {
            order[lane] = (lane / 2 + 16 * (1 - lane % 2)) as u16;
            lane += 1;
        }
        order
    };
    // SAFETY: whole vectors lie inside the slices, by their lengths; of the rest, only the lanes that are there are touched.
    unsafe {
        let order = std::mem::transmute::<[u16; 32], __m512i>(ORDER);
        let pair = |first: __m512, second: __m512| {
            let both = std::mem::transmute::<__m512bh, __m512i>(_mm512_cvtne2ps_pbh(second, first));
            _mm512_castsi512_ps(_mm512_permutexvar_epi16(order, both))
        };
        let rest = first.len() % Avx512::LANES;
        let (a, b, to) = (first.as_ptr(), second.as_ptr(), pairs.as_mut_ptr());
        let zero = Avx512::splat(0.0);
        for at in (0..first.len() - rest).step_by(Avx512::LANES) {
            let second = if second.is_empty() { zero } else { Avx512::load(b.add(at)) };
            Avx512::store(to.add(at), pair(Avx512::load(a.add(at)), second));
        }
        if rest > 0 {
            let at = first.len() - rest;
            let second = if second.is_empty() { zero } else { Avx512::load_first(b.add(at), rest) };
            Avx512::store_first(to.add(at), pair(Avx512::load_first(a.add(at), rest), second), rest);
        }
    }
}
