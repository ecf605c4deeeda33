//! Fully connected layer: matrix products over the whole batch, cut in fixed pieces.

use taxel_kernels::matmul::{Matrix, few_rows, matmul};
use taxel_kernels::{half, layout, reduce};

use super::batch_layer::{BatchBackward, BatchLayer};
use crate::threads::Threads;

/// Pieces that a product is cut into, whatever the number of threads.
const PIECES: usize = 4;

/// Weights from which on reordering them for a product costs more than reading them where they lie.
const MANY: usize = 1 << 18;

pub(super) struct Linear {
    inputs: usize,
    outputs: usize,
    bias: bool,
    /// Whether products are of bf16.
    half: bool,
    /// Inputs × samples and outputs × samples, in the order that suits a product, where there are many weights.
    turned: [Vec<f32>; 2],
}

impl Linear {
    pub fn new(inputs: usize, outputs: usize, bias: bool, batch: usize, half: bool) -> Self {
        let batch = if inputs * outputs >= MANY { batch } else { 0 };
        let turned = [vec![0.0; inputs * batch], vec![0.0; outputs * batch]];
        Linear { inputs, outputs, bias, half, turned }
    }

    /// Returns the product for a second matrix that is read where it lies, if that is faster, or is packed.
    fn product(&self, in_place: bool) -> fn(&mut [f32], usize, Matrix, Matrix, bool) {
        match (self.half, in_place) {
            (true, _) => half::multiply,
            (false, true) => few_rows,
            (false, false) => matmul,
        }
    }

    fn has_many(&self) -> bool {
        self.inputs * self.outputs >= MANY
    }

    /// Computes `yᵀ = W xᵀ + b`: every weight is read once.
    fn forward_turned(&mut self, threads: &Threads, n: usize, params: &[f32], x: &[f32], y: &mut [f32]) {
        let (inputs, outputs, bias, product) = (self.inputs, self.outputs, self.bias, self.product(true));
        let [xt, yt] = &mut self.turned;
        let (xt, yt) = (&mut xt[..inputs * n], &mut yt[..outputs * n]);
        let each = inputs.div_ceil(PIECES);
        threads.each(xt, each * n, |piece, xt| {
            const BLOCK: usize = 64;
            for (block, xt) in xt.chunks_mut(BLOCK * n).enumerate() {
                let from = piece * each + block * BLOCK;
                for sample in 0..n {
                    let x = &x[sample * inputs + from..];
                    xt[sample..].iter_mut().step_by(n).zip(x).for_each(|(xt, x)| *xt = *x);
                }
            }
        });
        let xt = Matrix::new(xt, inputs, n);
        let each = outputs.div_ceil(PIECES);
        let (weight, shift) = params.split_at(inputs * outputs);
        threads.each(yt, each * n, |piece, yt| {
            let from = piece * each;
            let count = yt.len() / n;
            if bias {
                yt.chunks_exact_mut(n).zip(&shift[from..]).for_each(|(row, shift)| row.fill(*shift));
            }
            let weight = Matrix::new(&weight[from * inputs..(from + count) * inputs], count, inputs);
            product(yt, n, weight, xt, bias);
        });
        layout::transpose(outputs, n, yt, y, false);
    }

    /// Computes `dx = dy W`, columns after columns: every weight is read once.
    fn backward_input_in_columns(
        &mut self,
        threads: &Threads,
        n: usize,
        params: &[f32],
        dy: &[f32],
        dx: &mut [f32],
    ) {
        let (inputs, outputs, product) = (self.inputs, self.outputs, self.product(true));
        let dy = Matrix::new(&dy[..n * outputs], n, outputs);
        let most = inputs.div_ceil(PIECES);
        let columns = &mut self.turned[0][..inputs * n];
        threads.each(columns, most * n, |piece, columns| {
            let count = columns.len() / n;
            let weight = Matrix::strided(&params[piece * most..inputs * outputs], outputs, count, inputs);
            product(columns, count, dy, weight, false);
        });
        for (sample, dx) in dx.chunks_exact_mut(inputs).enumerate() {
            for (piece, dx) in dx.chunks_mut(most).enumerate() {
                dx.copy_from_slice(&columns[piece * most * n + sample * dx.len()..][..dx.len()]);
            }
        }
    }

    fn weight<'a>(&self, params: &'a [f32]) -> Matrix<'a> {
        Matrix::new(&params[..self.inputs * self.outputs], self.outputs, self.inputs)
    }
}

impl BatchLayer for Linear {
    /// Computes `y = x Wᵀ + b` over `n` rows.
    fn forward(&mut self, threads: &Threads, n: usize, params: &[f32], x: &[f32], y: &mut [f32]) {
        if self.has_many() {
            return self.forward_turned(threads, n, params, x, y);
        }
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
            layer.product(false)(y, layer.outputs, x, layer.weight(params).t(), layer.bias);
        });
    }

    fn backward(&mut self, pass: BatchBackward, dparams: &mut [f32], dx: Option<&mut [f32]>) {
        let BatchBackward { threads, n, params, x, dy } = pass;
        let layer = &*self;
        let product = layer.product(layer.has_many());
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
                product(dweight, layer.inputs, dy.t(), x, false);
            });
        }
        let Some(dx) = dx else { return };
        if self.has_many() {
            return self.backward_input_in_columns(threads, n, params, dy, dx);
        }
        let rows = n.div_ceil(PIECES);
        threads.each(dx, rows * layer.inputs, |piece, dx| {
            let count = dx.len() / layer.inputs;
            let dy = &dy[piece * rows * layer.outputs..][..count * layer.outputs];
            let dy = Matrix::new(dy, count, layer.outputs);
            layer.product(false)(dx, layer.inputs, dy, layer.weight(params), false);
        });
    }
}
