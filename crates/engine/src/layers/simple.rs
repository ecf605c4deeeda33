//! Layers that only move values: copy, flatten, sum and concatenation.

use taxel_kernels::{layout, pointwise};

use super::layer::{Backward, Inputs, Layer, Outputs, Scratch};

/// Stores what is seen of the input.
pub(super) struct Copy {
    pub channels: usize,
}

impl Layer for Copy {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], _: &mut Scratch) {
        let (x, view) = inputs.get(0);
        view.apply(self.channels, x, y);
    }

    fn backward(&self, _: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            pointwise::copy(dy, dx, add);
        }
    }

    fn scratch_len(&self) -> usize {
        0
    }
}

/// Features come out channels first, whatever the order inside.
pub(super) struct Flatten {
    pub channels: usize,
    pub positions: usize,
}

impl Layer for Flatten {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        let x = view.seen(self.channels, x, &mut scratch.x);
        layout::transpose(self.positions, self.channels, x, y, false);
    }

    fn backward(&self, _: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        if let Some((dx, add)) = outputs.get(0) {
            layout::transpose(self.channels, self.positions, dy, dx, add);
        }
    }

    fn scratch_len(&self) -> usize {
        self.channels * self.positions
    }
}

pub(super) struct Add {
    pub channels: usize,
    /// Values of one sample.
    pub len: usize,
}

impl Layer for Add {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        let (x, view) = inputs.get(0);
        view.apply(self.channels, x, y);
        for which in 1..inputs.count() {
            let (x, view) = inputs.get(which);
            pointwise::copy(view.seen(self.channels, x, &mut scratch.x), y, true);
        }
    }

    fn backward(&self, pass: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        for which in 0..pass.inputs.count() {
            if let Some((dx, add)) = outputs.get(which) {
                pointwise::copy(dy, dx, add);
            }
        }
    }

    fn scratch_len(&self) -> usize {
        self.len
    }
}

pub(super) struct Concat {
    /// Channels of every input.
    widths: Vec<usize>,
    width: usize,
    positions: usize,
}

impl Concat {
    pub fn new(widths: Vec<usize>, positions: usize) -> Self {
        Concat { width: widths.iter().sum(), widths, positions }
    }

    fn start(&self, which: usize) -> usize {
        self.widths[..which].iter().sum()
    }
}

impl Layer for Concat {
    fn forward(&self, inputs: Inputs, _: &[f32], y: &mut [f32], _: &mut [f32], scratch: &mut Scratch) {
        for (which, &width) in self.widths.iter().enumerate() {
            let (x, view) = inputs.get(which);
            let x = view.seen(width, x, &mut scratch.x);
            pointwise::put_columns(x, width, y, self.width, self.start(which));
        }
    }

    fn backward(&self, _: Backward, dy: &[f32], _: &mut [f32], mut outputs: Outputs, _: &mut Scratch) {
        for (which, &width) in self.widths.iter().enumerate() {
            if let Some((dx, add)) = outputs.get(which) {
                pointwise::take_columns(dy, self.width, self.start(which), dx, width, add);
            }
        }
    }

    fn scratch_len(&self) -> usize {
        self.widths.iter().max().unwrap_or(&0) * self.positions
    }
}
