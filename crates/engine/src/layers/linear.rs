//! Fully connected layer: matrix products over the whole batch, cut in fixed pieces.

use taxel_kernels::matmul::{Matrix, matmul};
use taxel_kernels::reduce;

use super::{BatchBackward, BatchLayer};
use crate::threads::Threads;

/// Pieces that a product is cut into, whatever the number of threads.
const PIECES: usize = 4;

pub(super) struct Linear {
    pub inputs: usize,
    pub outputs: usize,
    pub bias: bool,
}

impl Linear {
    fn weight<'a>(&self, params: &'a [f32]) -> Matrix<'a> {
        Matrix::new(&params[..self.inputs * self.outputs], self.outputs, self.inputs)
    }
}

impl BatchLayer for Linear {
    /// `y = x Wᵀ + b` over `n` rows.
    fn forward(&mut self, threads: &Threads, n: usize, params: &[f32], x: &[f32], y: &mut [f32]) {
        let bias = &params[self.inputs * self.outputs..];
        let rows = n.div_ceil(PIECES);
        let layer = &*self;
        threads.each(y, rows * layer.outputs, |piece, y| {
            if layer.bias {
                y.chunks_exact_mut(layer.outputs).for_each(|row| row.copy_from_slice(bias));
            }
            let count = y.len() / layer.outputs;
            let x =
                Matrix::new(&x[piece * rows * layer.inputs..][..count * layer.inputs], count, layer.inputs);
            matmul(y, layer.outputs, x, layer.weight(params).t(), layer.bias);
        });
    }

    fn backward(&mut self, pass: BatchBackward, dparams: &mut [f32], dx: Option<&mut [f32]>) {
        let BatchBackward { threads, n, params, x, dy } = pass;
        let layer = &*self;
        if !dparams.is_empty() {
            let (dweight, dbias) = dparams.split_at_mut(layer.inputs * layer.outputs);
            if layer.bias {
                dbias.fill(0.0);
                reduce::add_columns(layer.outputs, dy, dbias);
            }
            let x = Matrix::new(x, n, layer.inputs);
            let columns = layer.outputs.div_ceil(PIECES);
            threads.each(dweight, columns * layer.inputs, |piece, dweight| {
                let count = dweight.len() / layer.inputs;
                let dy = Matrix::strided(&dy[piece * columns..], n, count, layer.outputs);
                matmul(dweight, layer.inputs, dy.t(), x, false);
            });
        }
        if let Some(dx) = dx {
            let rows = n.div_ceil(PIECES);
            threads.each(dx, rows * layer.inputs, |piece, dx| {
                let count = dx.len() / layer.inputs;
                let dy = &dy[piece * rows * layer.outputs..][..count * layer.outputs];
                matmul(dx, layer.inputs, Matrix::new(dy, count, layer.outputs), layer.weight(params), false);
            });
        }
    }
}
