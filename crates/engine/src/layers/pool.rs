//! Windowed and global pooling.

use taxel_kernels::{Window3, deviation, pointwise, pool};

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

pub(super) struct MaxPool(pub pool::MaxPool);

impl Layer for MaxPool {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], saved: &mut [f32], _: &mut Scratch) {
        let (x, view) = inputs.get(0);
        self.0.forward(&view, x, y, saved);
    }

    fn backward(&self, pass: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            self.0.backward(pass.saved, dy, dx, add);
        }
    }

    fn saved_len(&self) -> usize {
        self.0.output_len()
    }

    fn scratch_len(&self) -> usize {
        0
    }
}

pub(super) struct AveragePool {
    pub window: Window3,
    pub counted: [(usize, usize); 3],
    pub channels: usize,
}

impl Layer for AveragePool {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        let seen = view.seen(self.channels, x, &mut scratch.x);
        pool::average_forward(&self.window, &self.counted, self.channels, seen, y);
    }

    fn backward(&self, _: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            if !add {
                dx.fill(0.0);
            }
            pool::average_backward(&self.window, &self.counted, self.channels, dy, dx);
        }
    }

    fn scratch_len(&self) -> usize {
        self.window.input_len() * self.channels
    }
}

pub(super) struct GlobalAveragePool {
    pub channels: usize,
    /// Values of one input sample.
    pub len: usize,
}

impl Layer for GlobalAveragePool {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        pointwise::mean_positions(self.channels, &view, x, &mut scratch.x, y);
    }

    fn backward(&self, _: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            pointwise::mean_positions_backward(self.channels, dy, dx, add);
        }
    }

    fn scratch_len(&self) -> usize {
        self.len
    }
}

pub(super) struct GlobalStandardDeviation {
    pub channels: usize,
    pub eps: f32,
    /// Values of one sample of the input.
    pub len: usize,
}

impl Layer for GlobalStandardDeviation {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], saved: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        let x = view.seen(self.channels, x, &mut scratch.x);
        deviation::forward(self.channels, self.eps, x, saved, y);
    }

    fn backward(
        &self,
        pass: Backward,
        dy: &[f32],
        _: &mut [f32],
        mut outputs: Outputs,
        scratch: &mut Scratch,
    ) {
        if let Some((dx, add)) = outputs.get(0) {
            let (x, view) = pass.inputs.get(0);
            let x = view.seen(self.channels, x, &mut scratch.x);
            deviation::backward(self.channels, x, pass.saved, pass.y, dy, dx, add);
        }
    }

    fn saved_len(&self) -> usize {
        self.channels
    }

    fn scratch_len(&self) -> usize {
        self.len
    }
}
