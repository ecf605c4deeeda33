//! How the streams of a network with several sensors come in: standardised, and dark ones switched off.

use taxel_kernels::pointwise;

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

/// `(x − mean) / std` per channel, divided rather than multiplied: constant channels must stay constant.
pub(super) struct Standardize {
    pub channels: usize,
    /// Values of one sample.
    pub len: usize,
}

impl Layer for Standardize {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        let x = view.seen(self.channels, x, &mut scratch.x);
        let (mean, std) = inputs.packed.split_at(self.channels);
        for (x, y) in x.chunks_exact(self.channels).zip(y.chunks_exact_mut(self.channels)) {
            for c in 0..self.channels {
                y[c] = (x[c] - mean[c]) / std[c];
            }
        }
    }

    fn backward(&self, pass: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        let Some((dx, add)) = outputs.get(0) else { return };
        let (_, std) = pass.inputs.packed.split_at(self.channels);
        for (dy, dx) in dy.chunks_exact(self.channels).zip(dx.chunks_exact_mut(self.channels)) {
            for c in 0..self.channels {
                let gradient = dy[c] / std[c];
                dx[c] = if add { dx[c] + gradient } else { gradient };
            }
        }
    }

    fn scratch_len(&self) -> usize {
        self.len
    }

    fn keep(&self, buffers: &[f32], packed: &mut Vec<f32>) {
        packed.clear();
        packed.extend_from_slice(buffers);
    }
}

/// The first input, or zeros where every channel of the second is constant.
pub(super) struct SwitchScale {
    pub channels: usize,
    /// Values of one sample.
    pub len: usize,
    /// Channels and values of the stream that is looked at.
    pub stream: [usize; 2],
}

impl Layer for SwitchScale {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], saved: &mut [f32], scratch: &mut Scratch) {
        let (stream, view) = inputs.get(1);
        let stream = view.seen(self.stream[0], stream, &mut scratch.x);
        let (first, rest) = stream.split_at(self.stream[0]);
        let constant =
            first.iter().all(|v| !v.is_nan()) && rest.chunks_exact(self.stream[0]).all(|row| row == first);
        saved[0] = if constant { 0.0 } else { 1.0 };
        let (x, view) = inputs.get(0);
        pointwise::scale(saved[0], view.seen(self.channels, x, &mut scratch.x), y, false);
    }

    fn backward(&self, pass: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            pointwise::scale(pass.saved[0], dy, dx, add);
        }
        if let Some((stream, false)) = outputs.get(1) {
            stream.fill(0.0);
        }
    }

    fn saved_len(&self) -> usize {
        1
    }

    fn scratch_len(&self) -> usize {
        self.len.max(self.stream[1])
    }
}
