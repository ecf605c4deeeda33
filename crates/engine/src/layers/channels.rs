//! Layers that reorder or take channels.

use taxel_kernels::pointwise;

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

pub(super) struct ChannelShuffle {
    pub channels: usize,
    pub groups: usize,
    /// Values of one sample.
    pub len: usize,
}

impl Layer for ChannelShuffle {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        let x = view.seen(self.channels, x, &mut scratch.x);
        pointwise::shuffle_columns(x, self.channels, self.groups, y, false);
    }

    fn backward(&self, _: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            // Shuffled back: groups and channels of a group change places.
            pointwise::shuffle_columns(dy, self.channels, self.channels / self.groups, dx, add);
        }
    }

    fn scratch_len(&self) -> usize {
        self.len
    }
}

pub(super) struct Slice {
    /// Channels of the input.
    pub channels: usize,
    pub start: usize,
    pub width: usize,
    pub positions: usize,
}

impl Layer for Slice {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        let x = view.seen(self.channels, x, &mut scratch.x);
        pointwise::take_columns(x, self.channels, self.start, y, self.width, false);
    }

    fn backward(&self, _: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            if !add {
                dx.fill(0.0);
            }
            pointwise::add_to_columns(dy, self.width, dx, self.channels, self.start);
        }
    }

    fn scratch_len(&self) -> usize {
        self.channels * self.positions
    }
}
