//! Matrix products of bf16.

use std::cell::RefCell;

use crate::layout;
use crate::lengths::exactly;
use crate::matmul::{Matrix, pieces, sizes};
use crate::tile::{Start, Tile, even, pair_columns};
use crate::view::Rectifier;

use super::pack::{pair_columns_of_rows, pair_rows};

/// Columns and depth of the piece of a second matrix that is packed at a time, few enough to stay in cache.
const PIECE: [usize; 2] = [512, 512];
/// Rows of the first matrix that are packed at a time.
const ROWS: usize = 56;

thread_local! {
    /// Packed first factor, packed second factor, and pairs before they are transposed.
    static SCRATCH: RefCell<[Vec<f32>; 3]> = const { RefCell::new([vec![], vec![], vec![]]) };
}

/// The second matrix of a product, rounded to bf16 and packed, for many products.
#[derive(Debug, Clone, Default)]
pub struct HalfMatrix {
    /// Pairs of rows × columns.
    pairs: Vec<f32>,
    rows: usize,
    columns: usize,
}

impl HalfMatrix {
    /// Packs `b`, in the memory of what was packed before.
    pub fn pack(&mut self, b: Matrix) {
        (self.rows, self.columns) = (b.rows, b.columns);
        SCRATCH.with_borrow_mut(|[_, _, between]| pack_second(b, &mut self.pairs, between));
    }

    /// Computes `out = a · b`, or `out += a · b` when `accumulate`; rows of `out` start `row_stride` apart.
    pub fn multiply(&self, out: &mut [f32], row_stride: usize, a: Matrix, accumulate: bool) {
        exactly("rows of the second matrix for columns of the first", self.rows, a.columns);
        let b = Matrix { rows: self.rows, ..Matrix::new(&self.pairs, self.rows.div_ceil(2), self.columns) };
        sizes(out, row_stride, &a, &b);
        SCRATCH.with_borrow_mut(|[first, _, _]| {
            blocks(out, row_stride, a, &self.pairs, self.columns, accumulate, first);
        });
    }
}

/// Computes `out = a · b` of factors rounded to bf16, or `out += a · b` when `accumulate`, as
/// [`matmul`](crate::matmul::matmul) does of floats. One thread; panics where the CPU has no products of bf16.
pub fn multiply(out: &mut [f32], row_stride: usize, a: Matrix, b: Matrix, accumulate: bool) {
    let [m, n, k] = sizes(out, row_stride, &a, &b);
    if m == 0 || n == 0 {
        return;
    }
    SCRATCH.with_borrow_mut(|[first, second, between]| {
        for columns in pieces(n, PIECE[0]) {
            for depths in pieces(k, PIECE[1]) {
                let piece = part(b, [depths.start, columns.start], [depths.len(), columns.len()]);
                pack_second(piece, second, between);
                let a = part(a, [0, depths.start], [m, depths.len()]);
                let out = &mut out[columns.start..];
                blocks(out, row_stride, a, second, columns.len(), accumulate || depths.start > 0, first);
            }
        }
    });
}

/// Returns a piece of a matrix.
fn part<'a>(whole: Matrix<'a>, [row, column]: [usize; 2], [rows, columns]: [usize; 2]) -> Matrix<'a> {
    let from = (row * whole.row_stride + column * whole.column_stride).min(whole.data.len());
    Matrix { data: &whole.data[from..], rows, columns, ..whole }
}

/// Packs a second matrix: pairs of rows × columns.
fn pack_second(b: Matrix, pairs: &mut Vec<f32>, between: &mut Vec<f32>) {
    let (half, columns) = (b.rows.div_ceil(2), b.columns);
    pairs.resize(half * columns, 0.0);
    if half * columns == 0 {
        return;
    }
    if b.column_stride == 1 {
        return pair_rows(b.rows, columns, b.row_stride, b.data, pairs);
    }
    exactly("distance of the rows of a turned matrix", b.row_stride, 1);
    between.resize(half * columns, 0.0);
    pair_columns_of_rows(b.rows, b.column_stride, b.data, between);
    layout::transpose(columns, half, between, pairs, false);
}

/// Multiplies by a packed matrix of `n` columns, block by block of rows.
fn blocks(
    out: &mut [f32],
    row_stride: usize,
    a: Matrix,
    b: &[f32],
    n: usize,
    accumulate: bool,
    packed: &mut Vec<f32>,
) {
    let half = a.columns.div_ceil(2);
    exactly("a packed matrix", b.len(), half * n);
    if n == 0 {
        return;
    }
    for rows in pieces(a.rows, ROWS) {
        let count = rows.len();
        packed.resize(count * half, 0.0);
        let a = part(a, [rows.start, 0], [count, a.columns]);
        let (a_row, a_step) = if half == 0 {
            (0, 1)
        } else if a.column_stride == 1 {
            pair_columns_of_rows(a.columns, a.row_stride, a.data, packed);
            (half, 1)
        } else {
            exactly("distance of the rows of a turned matrix", a.row_stride, 1);
            pair_rows(a.columns, count, a.column_stride, a.data, packed);
            (1, count)
        };
        for columns in pair_columns(n) {
            for few in pieces(count, even(count, columns.rows())) {
                let tile = Tile {
                    a: packed[few.start * a_row.min(packed.len())..].as_ptr(),
                    a_row,
                    a_step,
                    b: b[columns.from.min(b.len())..].as_ptr(),
                    b_row: n,
                    c: out[(rows.start + few.start) * row_stride + columns.from..].as_mut_ptr(),
                    c_row: row_stride,
                    segments: &[(0, 0)],
                    run: half,
                    start: if accumulate { Start::Add } else { Start::Zero },
                    last: columns.last,
                    addend: None,
                    rectifier: Rectifier::None,
                };
                // SAFETY: `packed` was made for `count` rows of `half` pairs, in the order that `a_row` and `a_step`
                // walk; `b` holds `half` rows of `n` pairs, as asserted; the callers' `sizes` has asserted that rows
                // and columns lie inside `out`, which is borrowed exclusively. `pair_columns` asserts the CPU's
                // features.
                unsafe { columns.kernel(few.len())(&tile) };
            }
        }
    }
}
