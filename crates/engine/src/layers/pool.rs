//! Windowed and global pooling.

use taxel_kernels::{Window3, pointwise, pool};

use super::{Layer, Pass};

pub(super) struct MaxPool {
    window: Window3,
    channels: usize,
    /// Input position of every maximum.
    taken: Vec<u32>,
}

impl MaxPool {
    pub fn new(window: Window3, channels: usize, batch: usize) -> Self {
        MaxPool { window, channels, taken: vec![0; batch * window.output_len() * channels] }
    }
}

impl Layer for MaxPool {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], _: &[f32], _: &mut [f32], y: &mut [f32]) {
        let (window, channels) = (&self.window, self.channels);
        let (x_len, y_len) = (window.input_len() * channels, window.output_len() * channels);
        let taken = &mut self.taken[..pass.n * y_len];
        pass.threads.each2((y, y_len), (taken, y_len), |i, y, taken| {
            pool::max_forward(window, channels, &xs[0][i * x_len..][..x_len], y, taken);
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
        let (x_len, y_len) =
            (self.window.input_len() * self.channels, self.window.output_len() * self.channels);
        pass.threads.each(dx, x_len, |i, dx| {
            if !accumulate {
                dx.fill(0.0);
            }
            let (taken, dy) = (&self.taken[i * y_len..][..y_len], &dy[i * y_len..][..y_len]);
            pool::max_backward(self.channels, taken, dy, dx);
        });
    }
}

pub(super) struct AveragePool {
    pub window: Window3,
    pub counted: [(usize, usize); 3],
    pub channels: usize,
}

impl Layer for AveragePool {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], _: &[f32], _: &mut [f32], y: &mut [f32]) {
        let (x_len, y_len) =
            (self.window.input_len() * self.channels, self.window.output_len() * self.channels);
        pass.threads.each(y, y_len, |i, y| {
            pool::average_forward(
                &self.window,
                &self.counted,
                self.channels,
                &xs[0][i * x_len..][..x_len],
                y,
            );
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
        let (x_len, y_len) =
            (self.window.input_len() * self.channels, self.window.output_len() * self.channels);
        pass.threads.each(dx, x_len, |i, dx| {
            if !accumulate {
                dx.fill(0.0);
            }
            pool::average_backward(&self.window, &self.counted, self.channels, &dy[i * y_len..][..y_len], dx);
        });
    }
}

pub(super) struct GlobalAveragePool {
    pub channels: usize,
}

impl Layer for GlobalAveragePool {
    fn forward(&mut self, pass: &Pass, xs: &[&[f32]], _: &[f32], _: &mut [f32], y: &mut [f32]) {
        let x_len = xs[0].len() / pass.n;
        pass.threads.each(y, self.channels, |i, y| {
            pointwise::mean_positions(self.channels, &xs[0][i * x_len..][..x_len], y);
        });
    }

    fn backward_input(
        &mut self,
        pass: &Pass,
        _: usize,
        xs: &[&[f32]],
        _: &[f32],
        dy: &[f32],
        _: &[f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        let x_len = xs[0].len() / pass.n;
        pass.threads.each(dx, x_len, |i, dx| {
            let dy = &dy[i * self.channels..][..self.channels];
            pointwise::mean_positions_backward(self.channels, dy, dx, accumulate);
        });
    }
}
