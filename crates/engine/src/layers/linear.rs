//! Fully connected layer: matrix products over the whole batch, cut in fixed pieces.

use taxel_kernels::matmul::{Matrix, matmul};
use taxel_kernels::reduce;

use crate::threads::Threads;

/// Pieces that a product is cut into, whatever the number of threads.
const PIECES: usize = 4;

/// Rows of a batch, gathered from the parts: inputs, outputs and their gradients.
#[derive(Debug, Default)]
pub(crate) struct BatchState {
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub dy: Vec<f32>,
    pub dx: Vec<f32>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Linear {
    pub inputs: usize,
    pub outputs: usize,
    pub bias: bool,
}

impl Linear {
    pub fn state(&self, batch: usize) -> BatchState {
        let (inputs, outputs) = (batch * self.inputs, batch * self.outputs);
        BatchState {
            x: vec![0.0; inputs],
            y: vec![0.0; outputs],
            dy: vec![0.0; outputs],
            dx: vec![0.0; inputs],
        }
    }

    fn weight<'a>(&self, params: &'a [f32]) -> Matrix<'a> {
        Matrix::new(&params[..self.inputs * self.outputs], self.outputs, self.inputs)
    }

    /// `y = x Wᵀ + b` over `n` rows.
    pub fn forward(&self, threads: &Threads, n: usize, params: &[f32], state: &mut BatchState) {
        let bias = &params[self.inputs * self.outputs..];
        let rows = n.div_ceil(PIECES);
        let x = &state.x;
        threads.each(&mut state.y[..n * self.outputs], rows * self.outputs, |piece, y| {
            if self.bias {
                y.chunks_exact_mut(self.outputs).for_each(|row| row.copy_from_slice(bias));
            }
            let count = y.len() / self.outputs;
            let x = Matrix::new(&x[piece * rows * self.inputs..][..count * self.inputs], count, self.inputs);
            matmul(y, self.outputs, x, self.weight(params).t(), self.bias);
        });
    }

    /// Overwrites `dparams`, and `dx` where it is `wanted`.
    pub fn backward(
        &self,
        threads: &Threads,
        n: usize,
        params: &[f32],
        dparams: &mut [f32],
        state: &mut BatchState,
        wanted: bool,
    ) {
        let (dweight, dbias) = dparams.split_at_mut(self.inputs * self.outputs);
        let dy = &state.dy[..n * self.outputs];
        if self.bias {
            dbias.fill(0.0);
            reduce::add_columns(self.outputs, dy, dbias);
        }
        let x = Matrix::new(&state.x[..n * self.inputs], n, self.inputs);
        let columns = self.outputs.div_ceil(PIECES);
        threads.each(dweight, columns * self.inputs, |piece, dweight| {
            let count = dweight.len() / self.inputs;
            let dy = Matrix::strided(&dy[piece * columns..], n, count, self.outputs);
            matmul(dweight, self.inputs, dy.t(), x, false);
        });
        if wanted {
            let rows = n.div_ceil(PIECES);
            threads.each(&mut state.dx[..n * self.inputs], rows * self.inputs, |piece, dx| {
                let count = dx.len() / self.inputs;
                let dy = Matrix::new(
                    &dy[piece * rows * self.outputs..][..count * self.outputs],
                    count,
                    self.outputs,
                );
                matmul(dx, self.inputs, dy, self.weight(params), false);
            });
        }
    }
}
