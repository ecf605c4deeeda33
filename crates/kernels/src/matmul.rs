//! Matrix products: a safe face over `gemm`, and one for few rows.

use gemm::{Parallelism, gemm};

use crate::tile::{Start, Tile, columns, even};

/// A matrix seen in a slice: element (r, c) is `data[r * row_stride + c * column_stride]`.
#[derive(Debug, Clone, Copy)]
pub struct Matrix<'a> {
    data: &'a [f32],
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
}

impl<'a> Matrix<'a> {
    /// Rows one after the other.
    pub fn new(data: &'a [f32], rows: usize, columns: usize) -> Self {
        Self::strided(data, rows, columns, columns)
    }

    /// Rows that start `row_stride` apart.
    pub fn strided(data: &'a [f32], rows: usize, columns: usize, row_stride: usize) -> Self {
        let matrix = Matrix { data, rows, columns, row_stride, column_stride: 1 };
        assert!(matrix.reach() <= data.len(), "a {rows}×{columns} matrix needs {} values", matrix.reach());
        matrix
    }

    /// Rows and columns exchanged.
    pub fn t(self) -> Self {
        Matrix {
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
            ..self
        }
    }

    fn reach(&self) -> usize {
        if self.rows == 0 || self.columns == 0 {
            return 0;
        }
        (self.rows - 1) * self.row_stride + (self.columns - 1) * self.column_stride + 1
    }
}

/// `out = a · b`, or `out += a · b` when `accumulate`; rows of `out` start `row_stride` apart.
///
/// One thread; the same inputs give the same bits.
pub fn matmul(out: &mut [f32], row_stride: usize, a: Matrix, b: Matrix, accumulate: bool) {
    assert_eq!(a.columns, b.rows, "inner sizes of a matrix product");
    let (m, n, k) = (a.rows, b.columns, a.columns);
    if m == 0 || n == 0 {
        return;
    }
    assert!((m - 1) * row_stride + n <= out.len(), "a {m}×{n} product does not fit its output");
    // SAFETY: `Matrix` and the assertion above guarantee that every index gemm forms, which is at
    // most (rows - 1) * row_stride + (columns - 1) * column_stride, lies inside its slice; `out` is
    // borrowed exclusively, so it overlaps neither input.
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

/// The same for few rows of `a`, to which copying `b` into another order, as `gemm` does, would be half the
/// work; `b` is read where it lies, row by row.
pub fn few_rows(out: &mut [f32], row_stride: usize, a: Matrix, b: Matrix, accumulate: bool) {
    assert_eq!(a.columns, b.rows, "inner sizes of a matrix product");
    assert_eq!(b.column_stride, 1, "rows of the second matrix lie in one piece");
    let (m, n, k) = (a.rows, b.columns, a.columns);
    if m == 0 || n == 0 {
        return;
    }
    assert!((m - 1) * row_stride + n <= out.len(), "a {m}×{n} product does not fit its output");
    for columns in columns(n) {
        let most = even(m, columns.rows());
        for row in (0..m).step_by(most) {
            let rows = most.min(m - row);
            let tile = Tile {
                a: a.data[row * a.row_stride..].as_ptr(),
                a_row: a.row_stride,
                a_step: a.column_stride,
                b: b.data[columns.from..].as_ptr(),
                b_row: b.row_stride,
                c: out[row * row_stride + columns.from..].as_mut_ptr(),
                c_row: row_stride,
                segments: &[(0, 0)],
                run: k,
                start: if accumulate { Start::Add } else { Start::Zero },
                last: columns.last,
            };
            // SAFETY: `Matrix` guarantees that `rows` rows from `row` on and all `k` rows of `b` lie inside
            // their slices; the assertion above that the block lies inside `out`, which is borrowed
            // exclusively.
            unsafe { columns.kernel(rows)(&tile) };
        }
    }
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
}
