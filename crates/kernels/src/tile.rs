//! The one inner loop of convolution: a block of outputs held in registers.
//!
//! `c[m][n] (+)= Σ over segments s, Σ over k: a[s + m · a_row + k · a_step] · b[s' + k · b_row + n]`.
//! Forward, input gradient and weight gradient are this loop with other strides, on channels-last data
//! as they lie: nothing is copied into panels.

mod block;
mod columns;

pub(crate) use block::{Start, Tile};
pub(crate) use columns::{ColumnBlock, columns, columns_of, even, pair_columns, wide_rows};
