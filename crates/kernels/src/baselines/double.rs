//! Sums of many terms in double precision over rows of floats.
//!
//! Terms are dealt to a fixed number of sums, which are then added pairwise: no CPU changes the order, and a sum does
//! not depend on what else is computed.

use std::array::from_fn;

use crate::lengths::exactly;
use crate::simd::{Simd, at_level};

/// Sums that the terms are dealt to.
const SIDE: usize = 16;
/// Rows that stay in the cache while several vectors pass by.
const ROWS: usize = 8;

/// Computes the scalar products of `x` with `rows`, each as long.
pub fn dots(rows: &[f32], x: &[f32], products: &mut [f64]) {
    exactly("rows", rows.len(), x.len() * products.len());
    run_dots(rows, x, products);
}

/// Computes [`dots`] with rows in double precision.
pub fn wide_dots(rows: &[f64], x: &[f32], products: &mut [f64]) {
    exactly("rows", rows.len(), x.len() * products.len());
    run_wide_dots(rows, x, products);
}

/// Computes the squared distances of every vector in `xs` from every one of `rows`, all of length `width`: vectors ×
/// rows. Differences are taken in double precision or, if `narrow`, rounded to floats.
pub fn squares(width: usize, rows: &[f32], xs: &[f32], narrow: bool, distances: &mut [f64]) {
    assert!(width > 0 && rows.len().is_multiple_of(width), "rows of {width}");
    assert!(xs.len().is_multiple_of(width), "vectors of {width}");
    exactly("distances", distances.len(), rows.len() / width * (xs.len() / width));
    if narrow { narrow_squares(width, rows, xs, distances) } else { wide_squares(width, rows, xs, distances) }
}

at_level! {
    fn run_dots(rows: &[f32], x: &[f32], products: &mut [f64]) = dots_at
}
at_level! {
    fn run_wide_dots(rows: &[f64], x: &[f32], products: &mut [f64]) = wide_dots_at
}
at_level! {
    fn narrow_squares(width: usize, rows: &[f32], xs: &[f32], distances: &mut [f64]) = narrow_squares_at
}
at_level! {
    fn wide_squares(width: usize, rows: &[f32], xs: &[f32], distances: &mut [f64]) = wide_squares_at
}

/// Computes [`dots`], compiled for the vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn dots_at<S: Simd>(rows: &[f32], x: &[f32], products: &mut [f64]) {
    for (product, row) in products.iter_mut().zip(rows.chunks_exact(x.len().max(1))) {
        [[*product]] = sum([x], [row], |x, row| f64::from(*x) * f64::from(*row));
    }
}

/// Computes [`wide_dots`], compiled for the vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn wide_dots_at<S: Simd>(rows: &[f64], x: &[f32], products: &mut [f64]) {
    for (product, row) in products.iter_mut().zip(rows.chunks_exact(x.len().max(1))) {
        [[*product]] = sum([x], [row], |x, row| f64::from(*x) * row);
    }
}

/// Computes [`squares`] of differences that are rounded to floats, compiled for the vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn narrow_squares_at<S: Simd>(width: usize, rows: &[f32], xs: &[f32], distances: &mut [f64]) {
    pairwise::<2, 1>(width, rows, xs, distances, |x, row| {
        let off = f64::from(x - row);
        off * off
    });
}

/// Computes [`squares`] of differences in double precision, compiled for the vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn wide_squares_at<S: Simd>(width: usize, rows: &[f32], xs: &[f32], distances: &mut [f64]) {
    let term = |x: &f32, row: &f32| {
        let off = f64::from(*x) - f64::from(*row);
        off * off
    };
    // As many sums as registers hold.
    match S::LANES {
        16 => pairwise::<2, 2>(width, rows, xs, distances, term),
        _ => pairwise::<2, 1>(width, rows, xs, distances, term),
    }
}

/// Computes the sum of `term` for every pair of a vector and a row: `N` vectors and `M` rows at a time, some rows for
/// all vectors.
#[inline(always)]
fn pairwise<const N: usize, const M: usize>(
    width: usize,
    rows: &[f32],
    xs: &[f32],
    sums: &mut [f64],
    term: impl Fn(&f32, &f32) -> f64 + Copy,
) {
    let (count, vectors) = (rows.len() / width, xs.len() / width);
    let row = |at: usize| &rows[at * width..(at + 1) * width];
    let vector = |at: usize| &xs[at * width..(at + 1) * width];
    for tile in (0..count).step_by(ROWS) {
        let end = count.min(tile + ROWS);
        for x in (0..vectors).step_by(N) {
            for first in (tile..end).step_by(M) {
                if x + N <= vectors && first + M <= end {
                    let products: [[f64; M]; N] =
                        sum(from_fn(|i| vector(x + i)), from_fn(|j| row(first + j)), term);
                    for (i, row_sums) in products.iter().enumerate() {
                        sums[(x + i) * count + first..][..M].copy_from_slice(row_sums);
                    }
                    continue;
                }
                for x in x..vectors.min(x + N) {
                    for at in first..end.min(first + M) {
                        [[sums[x * count + at]]] = sum([vector(x)], [row(at)], term);
                    }
                }
            }
        }
    }
}

/// Returns the sum of `term` over the values of each of `N` vectors and each of `M` rows as long. However many there
/// are, a pair's terms are added in the same order.
#[inline(always)]
fn sum<T, const N: usize, const M: usize>(
    xs: [&[f32]; N],
    rows: [&[T]; M],
    term: impl Fn(&f32, &T) -> f64 + Copy,
) -> [[f64; M]; N] {
    let length = rows[0].len() / SIDE;
    let mut sums = [[[0.0f64; SIDE]; M]; N];
    let vectors = xs.map(|x| &x.as_chunks::<SIDE>().0[..length]);
    let blocks = rows.map(|row| &row.as_chunks::<SIDE>().0[..length]);
    for at in 0..length {
        for (sums, x) in sums.iter_mut().zip(vectors) {
            for (sums, row) in sums.iter_mut().zip(blocks) {
                for ((sum, x), row) in sums.iter_mut().zip(&x[at]).zip(&row[at]) {
                    *sum += term(x, row);
                }
            }
        }
    }
    let mut totals = [[0.0; M]; N];
    for ((totals, sums), x) in totals.iter_mut().zip(sums).zip(xs) {
        for ((total, mut sums), row) in totals.iter_mut().zip(sums).zip(rows) {
            let ends = sums.iter_mut().zip(&x[length * SIDE..]).zip(&row[length * SIDE..]);
            ends.for_each(|((sum, x), row)| *sum += term(x, row));
            let mut left = SIDE;
            while left > 1 {
                left /= 2;
                let (low, high) = sums.split_at_mut(left);
                low.iter_mut().zip(high).for_each(|(low, high)| *low += *high);
            }
            *total = sums[0];
        }
    }
    totals
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(n: usize, salt: usize) -> Vec<f32> {
        (0..n).map(|i| ((i * 37 + salt * 11) % 101) as f32 * 0.37 - 18.0).collect()
    }

    fn close(got: f64, want: f64) {
        assert!((got - want).abs() <= 1e-12 * want.abs().max(1.0), "{got} and {want}");
    }

    #[test]
    fn sums_are_those_of_one_term_after_the_other() {
        let widths = [17, 1, 7, 15, 16, 33, 250];
        for width in widths.into_iter().take(if cfg!(miri) { 2 } else { 7 }) {
            for (count, vectors) in [(1, 1), (3, 2), (9, 5), (17, 1)] {
                let (rows, xs) = (values(count * width, 1), values(vectors * width, 2));
                let mut distances = vec![0.0; count * vectors];
                for narrow in [false, true] {
                    squares(width, &rows, &xs, narrow, &mut distances);
                    for (x, distances) in xs.chunks_exact(width).zip(distances.chunks_exact(count)) {
                        for (row, got) in rows.chunks_exact(width).zip(distances) {
                            let off = |(a, b): (&f32, &f32)| {
                                if narrow {
                                    f64::from(a - b).powi(2)
                                } else {
                                    (f64::from(*a) - f64::from(*b)).powi(2)
                                }
                            };
                            close(*got, x.iter().zip(row).map(off).sum());
                            // Alone, a vector gets the same bits.
                            let mut narrowest = [0.0];
                            squares(width, row, x, narrow, &mut narrowest);
                            assert_eq!(narrowest[0].to_bits(), got.to_bits());
                        }
                    }
                }
                let x = &xs[..width];
                let wide: Vec<f64> = rows.iter().map(|v| f64::from(*v)).collect();
                let (mut narrow_products, mut wide_products) = (vec![0.0; count], vec![0.0; count]);
                dots(&rows, x, &mut narrow_products);
                wide_dots(&wide, x, &mut wide_products);
                assert_eq!(narrow_products, wide_products);
                for (row, got) in rows.chunks_exact(width).zip(narrow_products) {
                    close(got, x.iter().zip(row).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum());
                }
            }
        }
    }
}
