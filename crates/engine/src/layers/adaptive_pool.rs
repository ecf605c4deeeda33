//! Mean over a given number of windows per axis.

use taxel_kernels::adaptive_pool::AdaptivePool;

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

pub(super) struct AdaptiveAveragePool {
    pub pool: AdaptivePool,
}

impl Layer for AdaptiveAveragePool {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        self.pool.forward(view.seen(self.pool.channels, x, &mut scratch.x), y);
    }

    fn backward(&self, _: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            if !add {
                dx.fill(0.0);
            }
            self.pool.backward(dy, dx);
        }
    }

    fn scratch_len(&self) -> usize {
        self.pool.input.iter().product::<usize>() * self.pool.channels
    }
}
