//! Matrix products: a safe face over `gemm`, and one for few rows.

use std::ops::Range;

use gemm::{Parallelism, gemm};

use crate::lengths::{at_least, exactly, reach};
use crate::tile::{ColumnBlock, Start, Tile, columns, even, wide_rows};
use crate::view::Rectifier;

/// A matrix seen in a slice: element (r, c) is `data[r * row_stride + c * column_stride]`.
#[derive(Debug, Clone, Copy)]
pub struct Matrix<'a> {
    pub(crate) data: &'a [f32],
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) row_stride: usize,
    pub(crate) column_stride: usize,
}

impl<'a> Matrix<'a> {
    /// Makes a matrix whose rows lie one after the other.
    pub fn new(data: &'a [f32], rows: usize, columns: usize) -> Self {
        Self::strided(data, rows, columns, columns)
    }

    /// Makes a matrix whose rows start `row_stride` apart.
    pub fn strided(data: &'a [f32], rows: usize, columns: usize, row_stride: usize) -> Self {
        let matrix = Matrix { data, rows, columns, row_stride, column_stride: 1 };
        at_least("a matrix", data.len(), reach(rows, row_stride, columns));
        matrix
    }

    /// Exchanges rows and columns.
    pub fn t(self) -> Self {
        Matrix {
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
            ..self
        }
    }
}

/// Returns the sizes (rows, columns, depth) of `a · b`, which is asserted to fit `out`.
pub(crate) fn sizes(out: &[f32], row_stride: usize, a: &Matrix, b: &Matrix) -> [usize; 3] {
    exactly("rows of the second matrix for columns of the first", b.rows, a.columns);
    let (m, n) = (a.rows, b.columns);
    at_least("distance of the rows of a product", row_stride, if m > 1 { n } else { 0 });
    at_least("a product", out.len(), reach(m, row_stride, n));
    [m, n, a.columns]
}

/// Computes `out = a · b`, or `out += a · b` when `accumulate`; rows of `out` start `row_stride` apart.
///
/// One thread; the same inputs give the same bits.
pub fn matmul(out: &mut [f32], row_stride: usize, a: Matrix, b: Matrix, accumulate: bool) {
    let [m, n, k] = sizes(out, row_stride, &a, &b);
    if m == 0 || n == 0 {
        return;
    }
    // SAFETY: every index that gemm forms is at most (rows - 1) * row_stride + (columns - 1) *
    // column_stride. For `a` and `b` that lies inside the slice, as `Matrix::strided` has asserted (`t`
    // exchanges the two terms); for `out` `sizes` has asserted it. `out` is borrowed exclusively, so it
    // overlaps neither input.
    unsafe {
        gemm(
            m,
            n,
            k,
            out.as_mut_ptr(),
            1,
            row_stride as isize,
            accumulate,
            a.data.as_ptr(),
            a.column_stride as isize,
            a.row_stride as isize,
            b.data.as_ptr(),
            b.column_stride as isize,
            b.row_stride as isize,
            1.0,
            1.0,
            false,
            false,
            false,
            Parallelism::None,
        );
    }
}

/// Values of a matrix that stay in a core's cache while they are used again and again.
const CACHED: usize = 1 << 18;

/// Rows of a larger second matrix that are read side by side, few enough for the CPU to read ahead in all.
const STREAMS: usize = 32;

/// Computes the same as [`matmul`], for few rows of `a`. `gemm` first copies `b` into another order, which for few
/// rows would be half the work; here `b` is read where it lies, row by row.
pub fn few_rows(out: &mut [f32], row_stride: usize, a: Matrix, b: Matrix, accumulate: bool) {
    assert_eq!(b.column_stride, 1, "rows of the second matrix are needed in one piece");
    let [m, n, k] = sizes(out, row_stride, &a, &b);
    if m == 0 || n == 0 {
        return;
    }
    let mut block = |depths: Range<usize>, rows: Range<usize>, columns: &ColumnBlock| {
        let tile = Tile {
            a: a.data[rows.start * a.row_stride + depths.start * a.column_stride..].as_ptr(),
            a_row: a.row_stride,
            a_step: a.column_stride,
            b: b.data[depths.start * b.row_stride + columns.from..].as_ptr(),
            b_row: b.row_stride,
            c: out[rows.start * row_stride + columns.from..].as_mut_ptr(),
            c_row: row_stride,
            segments: &[(0, 0)],
            run: depths.len(),
            start: if accumulate || depths.start > 0 { Start::Add } else { Start::Zero },
            last: columns.last,
            addend: None,
            rectifier: Rectifier::None,
        };
        // SAFETY: `rows` end at most at `m`, `depths` at `k`, `columns` at `n`. That rows and depths up to
        // there lie inside `a` and `b` has been asserted by `Matrix::strided`, that the block lies inside
        // `out` by `sizes`; `out` is borrowed exclusively.
        unsafe { columns.kernel(rows.len())(&tile) };
    };
    if m * n > CACHED && k * n <= CACHED {
        // The output is written row by row.
        for rows in pieces(m, even(m, wide_rows())) {
            for columns in columns(n) {
                for few in pieces(rows.len(), columns.rows()) {
                    block(0..k, rows.start + few.start..rows.start + few.end, &columns);
                }
            }
        }
        return;
    }
    let depths_most = if k * n > CACHED { STREAMS } else { k.max(1) };
    for depths in pieces(k, depths_most) {
        for columns in columns(n) {
            for rows in pieces(m, even(m, columns.rows())) {
                block(depths.clone(), rows, &columns);
            }
        }
    }
}

/// Cuts `0..len` into pieces of at most `most`: one empty piece where `len` is 0.
pub(crate) fn pieces(len: usize, most: usize) -> impl Iterator<Item = Range<usize>> {
    (0..len.max(1)).step_by(most).map(move |from| from..(from + most).min(len))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposed_and_strided_products_agree_with_plain_loops() {
        let a: Vec<f32> = (0..12).map(|v| v as f32 - 5.0).collect(); // 3×4
        let b: Vec<f32> = (0..20).map(|v| 0.5 * v as f32).collect(); // 4×5
        let mut plain = [0.0; 15];
        for i in 0..3 {
            for j in 0..5 {
                plain[i * 5 + j] = (0..4).map(|k| a[i * 4 + k] * b[k * 5 + j]).sum();
            }
        }
        let mut out = vec![1.0; 3 * 7];
        matmul(&mut out, 7, Matrix::new(&a, 3, 4), Matrix::new(&b, 4, 5), true);
        for i in 0..3 {
            for j in 0..5 {
                assert_eq!(out[i * 7 + j], plain[i * 5 + j] + 1.0);
            }
            assert_eq!(out[i * 7 + 5..(i * 7 + 7).min(out.len())], [1.0, 1.0], "outside the product");
        }
        let mut few = vec![1.0; 3 * 7];
        few_rows(&mut few, 7, Matrix::new(&a, 3, 4), Matrix::new(&b, 4, 5), true);
        assert_eq!(few, out);
        let mut transposed = [f32::NAN; 15];
        matmul(&mut transposed, 3, Matrix::new(&b, 4, 5).t(), Matrix::new(&a, 3, 4).t(), false);
        for i in 0..3 {
            for j in 0..5 {
                assert_eq!(transposed[j * 3 + i], plain[i * 5 + j]);
            }
        }
    }

    /// Covers a small second matrix, an output and a second matrix that leave the cache, and no depth at all.
    #[test]
    fn few_rows_in_every_order_agree_with_gemm() {
        let value = |i: usize| ((i * 37 + 11) % 64) as f32 / 64.0 - 0.5;
        let sizes = [(5, 70, 33), (3, 0, 7), (37, 9, 8197), (29, 601, 501)];
        for (m, k, n) in sizes.into_iter().take(if cfg!(miri) { 2 } else { 4 }) {
            let a: Vec<f32> = (0..m * k).map(value).collect();
            let b: Vec<f32> = (0..k * n).map(value).collect();
            for accumulate in [false, true] {
                let (mut few, mut whole) = (vec![0.25; m * n], vec![0.25; m * n]);
                let (a, b) = (Matrix::new(&a, k, m).t(), Matrix::new(&b, k, n));
                few_rows(&mut few, n, a, b, accumulate);
                matmul(&mut whole, n, a, b, accumulate);
                let far = few.iter().zip(&whole).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
                assert!(far < 1e-4, "{m}×{k}×{n}, {accumulate}: {far}");
            }
        }
    }
}
