//! Layers without state: ReLU, flatten, sum and concatenation.

use taxel_kernels::{layout, pointwise};

use super::{Layer, Pass};

/// Values per task of an operation that only moves memory.
const STRETCH: usize = 1 << 15;

pub(super) struct Relu;

impl Layer for Relu {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], _: &[f32], _: &mut [f32], y: &mut [f32]) {
        pass.threads.each(y, STRETCH, |i, y| pointwise::relu(&xs[0][i * STRETCH..][..y.len()], y));
    }

    fn backward_input(
        &mut self,
        pass: &Pass,
        _: usize,
        _: &[&[f32]],
        y: &[f32],
        dy: &[f32],
        _: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        pass.threads.each(dx, STRETCH, |i, dx| {
            let range = i * STRETCH..i * STRETCH + dx.len();
            pointwise::relu_backward(&y[range.clone()], &dy[range], dx, accumulate);
        });
    }
}

/// Features come out channels first, whatever the order inside.
pub(super) struct Flatten {
    pub channels: usize,
    pub positions: usize,
}

impl Layer for Flatten {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], _: &[f32], _: &mut [f32], y: &mut [f32]) {
        let len = self.channels * self.positions;
        pass.threads.each(y, len, |i, y| {
            layout::transpose(self.positions, self.channels, &xs[0][i * len..][..len], y, false);
        });
    }

    fn backward_input(
        &mut self,
        pass: &Pass,
        _: usize,
        _: &[&[f32]],
        _: &[f32],
        dy: &[f32],
        _: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        let len = self.channels * self.positions;
        pass.threads.each(dx, len, |i, dx| {
            layout::transpose(self.channels, self.positions, &dy[i * len..][..len], dx, accumulate);
        });
    }
}

pub(super) struct Add;

impl Layer for Add {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], _: &[f32], _: &mut [f32], y: &mut [f32]) {
        pass.threads.each(y, STRETCH, |i, y| {
            for (which, x) in xs.iter().enumerate() {
                pointwise::copy(&x[i * STRETCH..][..y.len()], y, which > 0);
            }
        });
    }

    fn backward_input(
        &mut self,
        pass: &Pass,
        _: usize,
        _: &[&[f32]],
        _: &[f32],
        dy: &[f32],
        _: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        pass.threads.each(dx, STRETCH, |i, dx| {
            pointwise::copy(&dy[i * STRETCH..][..dx.len()], dx, accumulate);
        });
    }
}

pub(super) struct Concat {
    /// Channels of every input.
    widths: Vec<usize>,
    width: usize,
}

impl Concat {
    pub fn new(widths: Vec<usize>) -> Self {
        Concat { width: widths.iter().sum(), widths }
    }

    fn start(&self, which: usize) -> usize {
        self.widths[..which].iter().sum()
    }
}

impl Layer for Concat {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], _: &[f32], _: &mut [f32], y: &mut [f32]) {
        let rows = y.len() / self.width / pass.n;
        pass.threads.each(y, rows * self.width, |i, y| {
            for (which, (x, &width)) in xs.iter().zip(&self.widths).enumerate() {
                let x = &x[i * rows * width..][..rows * width];
                pointwise::put_columns(x, width, y, self.width, self.start(which));
            }
        });
    }

    fn backward_input(
        &mut self,
        pass: &Pass,
        which: usize,
        _: &[&[f32]],
        y: &[f32],
        dy: &[f32],
        _: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        let rows = y.len() / self.width / pass.n;
        let width = self.widths[which];
        pass.threads.each(dx, rows * width, |i, dx| {
            let dy = &dy[i * rows * self.width..][..rows * self.width];
            pointwise::take_columns(dy, self.width, self.start(which), dx, width, accumulate);
        });
    }
}
