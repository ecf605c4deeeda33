//! Dropout: in training a mask of this step, in evaluation a copy.

use taxel_graph::DropoutMask;
use taxel_kernels::{dropout, pointwise};

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

pub(super) struct Dropout {
    pub probability: f32,
    pub channels: usize,
    pub positions: usize,
}

impl Dropout {
    /// Writes or adds to `to` what the mask leaves of `from`.
    fn apply(&self, mask: &DropoutMask, sample: usize, from: &[f32], to: &mut [f32], add: bool) {
        let scale = 1.0 / (1.0 - self.probability);
        let rows = from.chunks_exact(self.channels).zip(to.chunks_exact_mut(self.channels));
        for (position, (from, to)) in rows.enumerate() {
            // Elements of a mask count channels first.
            let keeps = |channel| mask.keeps(sample, channel * self.positions + position);
            dropout::apply(from, to, scale, keeps, add);
        }
    }
}

impl Layer for Dropout {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        match &inputs.mask {
            Some(mask) => {
                let x = view.seen(self.channels, x, &mut scratch.x);
                self.apply(mask, inputs.number, x, y, false);
            }
            None => view.apply(self.channels, x, y),
        }
    }

    fn backward(&self, pass: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        let Some((dx, add)) = outputs.get(0) else { return };
        match &pass.inputs.mask {
            Some(mask) => self.apply(mask, pass.inputs.number, dy, dx, add),
            None => pointwise::copy(dy, dx, add),
        }
    }

    fn scratch_len(&self) -> usize {
        self.channels * self.positions
    }
}
