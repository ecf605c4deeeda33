//! Fully connected layer: one matrix product per pass, cut by rows.

use taxel_kernels::batch_norm;
use taxel_kernels::matmul::{Matrix, matmul};

use super::{Layer, Pass};
use crate::threads::Parts;

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

impl Layer for Linear {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], params: &[f32], _: &mut [f32], y: &mut [f32]) {
        let bias = &params[self.inputs * self.outputs..];
        let parts = Parts::of(pass.n, 4);
        pass.threads.each(y, parts.each * self.outputs, |part, y| {
            let rows = parts.range(part, pass.n);
            if self.bias {
                for row in y.chunks_exact_mut(self.outputs) {
                    row.copy_from_slice(bias);
                }
            }
            let x = &xs[0][rows.start * self.inputs..rows.end * self.inputs];
            let x = Matrix::new(x, rows.len(), self.inputs);
            matmul(y, self.outputs, x, self.weight(params).t(), self.bias);
        });
    }

    fn backward_params(&mut self, pass: &Pass, xs: &[&[f32]], dy: &[f32], _: &[f32], dparams: &mut [f32]) {
        let (dweight, dbias) = dparams.split_at_mut(self.inputs * self.outputs);
        if self.bias {
            let mut sums = vec![0.0; self.outputs];
            batch_norm::sum(self.outputs, dy, &mut sums);
            for (dbias, sum) in dbias.iter_mut().zip(sums) {
                *dbias = sum as f32;
            }
        }
        let parts = Parts::of(self.outputs, 4);
        let x = Matrix::new(xs[0], pass.n, self.inputs);
        pass.threads.each(dweight, parts.each * self.inputs, |part, dweight| {
            let rows = parts.range(part, self.outputs);
            let dy = Matrix::strided(&dy[rows.start..], pass.n, rows.len(), self.outputs);
            matmul(dweight, self.inputs, dy.t(), x, false);
        });
    }

    fn backward_input(
        &mut self,
        pass: &Pass,
        _: usize,
        _: &[&[f32]],
        _: &[f32],
        dy: &[f32],
        params: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        let parts = Parts::of(pass.n, 4);
        pass.threads.each(dx, parts.each * self.inputs, |part, dx| {
            let rows = parts.range(part, pass.n);
            let dy = &dy[rows.start * self.outputs..rows.end * self.outputs];
            let dy = Matrix::new(dy, rows.len(), self.outputs);
            matmul(dx, self.inputs, dy, self.weight(params), accumulate);
        });
    }
}
