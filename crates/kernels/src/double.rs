//! Sums of many terms in double precision over rows of floats.
//!
//! Terms are dealt to a fixed number of sums, which are then added pairwise: no CPU changes the order, and a sum does
//! not depend on what else is computed.

use crate::lengths::exactly;
use crate::simd::{Simd, at_level};

/// Sums that the terms are dealt to.
const SIDE: usize = 16;
/// Rows that stay in the cache while several vectors pass by.
const ROWS: usize = 8;

/// Scalar products of `x` with `rows`, each as long.
pub fn dots(rows: &[f32], x: &[f32], products: &mut [f64]) {
    exactly("rows", rows.len(), x.len() * products.len());
    run_dots(rows, x, products);
}

/// [`dots`] with rows in double precision.
pub fn wide_dots(rows: &[f64], x: &[f32], products: &mut [f64]) {
    exactly("rows", rows.len(), x.len() * products.len());
    run_wide_dots(rows, x, products);
}

/// Squared distances of every vector in `xs` from every one of `rows`, all of length `width`: vectors × rows.
/// Differences are taken in double precision or, if `narrow`, rounded to floats.
pub fn squares(width: usize, rows: &[f32], xs: &[f32], narrow: bool, distances: &mut [f64]) {
    assert!(width > 0 && rows.len().is_multiple_of(width), "rows of {width}");
    assert!(xs.len().is_multiple_of(width), "vectors of {width}");
    exactly("distances", distances.len(), rows.len() / width * (xs.len() / width));
    match narrow {
        true => narrow_squares(width, rows, xs, distances),
        false => wide_squares(width, rows, xs, distances),
    }
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

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn dots_at<S: Simd>(rows: &[f32], x: &[f32], products: &mut [f64]) {
    for (product, row) in products.iter_mut().zip(rows.chunks_exact(x.len().max(1))) {
        *product = sum([x], row, |x, row| f64::from(*x) * f64::from(*row))[0];
    }
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn wide_dots_at<S: Simd>(rows: &[f64], x: &[f32], products: &mut [f64]) {
    for (product, row) in products.iter_mut().zip(rows.chunks_exact(x.len().max(1))) {
        *product = sum([x], row, |x, row| f64::from(*x) * row)[0];
    }
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn narrow_squares_at<S: Simd>(width: usize, rows: &[f32], xs: &[f32], distances: &mut [f64]) {
    pairwise(width, rows, xs, distances, |x, row| {
        let off = f64::from(x - row);
        off * off
    });
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn wide_squares_at<S: Simd>(width: usize, rows: &[f32], xs: &[f32], distances: &mut [f64]) {
    pairwise(width, rows, xs, distances, |x, row| {
        let off = f64::from(*x) - f64::from(*row);
        off * off
    });
}

/// The sum of `term` over every pair of a vector and a row: two vectors at a time, some rows for all of them.
#[inline(always)]
fn pairwise(
    width: usize,
    rows: &[f32],
    xs: &[f32],
    sums: &mut [f64],
    term: impl Fn(&f32, &f32) -> f64 + Copy,
) {
    let count = rows.len() / width;
    for (tile, rows) in rows.chunks(ROWS * width).enumerate() {
        let first = tile * ROWS;
        for (pair, xs) in xs.chunks(2 * width).enumerate() {
            let (x, y) = xs.split_at(width);
            for (row, values) in rows.chunks_exact(width).enumerate() {
                let at = 2 * pair * count + first + row;
                if y.is_empty() {
                    sums[at] = sum([x], values, term)[0];
                } else {
                    [sums[at], sums[at + count]] = sum([x, y], values, term);
                }
            }
        }
    }
}

/// The sum of `term` over the values of a row and of each of `N` vectors as long.
#[inline(always)]
fn sum<T, const N: usize>(xs: [&[f32]; N], row: &[T], term: impl Fn(&f32, &T) -> f64 + Copy) -> [f64; N] {
    let (blocks, rest) = row.as_chunks::<SIDE>();
    let mut sums = [[0.0f64; SIDE]; N];
    let own = xs.map(|x| &x.as_chunks::<SIDE>().0[..blocks.len()]);
    for (at, row) in blocks.iter().enumerate() {
        for (sums, x) in sums.iter_mut().zip(own) {
            for ((sum, x), row) in sums.iter_mut().zip(&x[at]).zip(row) {
                *sum += term(x, row);
            }
        }
    }
    let mut totals = [0.0; N];
    for ((total, mut sums), x) in totals.iter_mut().zip(sums).zip(xs) {
        let ends = sums.iter_mut().zip(&x[blocks.len() * SIDE..]).zip(rest);
        ends.for_each(|((sum, x), row)| *sum += term(x, row));
        let mut left = SIDE;
        while left > 1 {
            left /= 2;
            let (low, high) = sums.split_at_mut(left);
            low.iter_mut().zip(high).for_each(|(low, high)| *low += *high);
        }
        *total = sums[0];
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
        for width in [1, 7, 15, 16, 17, 33, 250] {
            for (count, vectors) in [(1, 1), (3, 2), (9, 5), (17, 1)] {
                let (rows, xs) = (values(count * width, 1), values(vectors * width, 2));
                let mut distances = vec![0.0; count * vectors];
                for narrow in [false, true] {
                    squares(width, &rows, &xs, narrow, &mut distances);
                    for (x, distances) in xs.chunks_exact(width).zip(distances.chunks_exact(count)) {
                        for (row, got) in rows.chunks_exact(width).zip(distances) {
                            let off = |(a, b): (&f32, &f32)| match narrow {
                                true => f64::from(a - b).powi(2),
                                false => (f64::from(*a) - f64::from(*b)).powi(2),
                            };
                            close(*got, x.iter().zip(row).map(off).sum());
                            // Alone, a vector gets the same bits.
                            let mut alone = [0.0];
                            squares(width, row, x, narrow, &mut alone);
                            assert_eq!(alone[0].to_bits(), got.to_bits());
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
