//! Convolution over up to three spatial axes, one image at a time.
//!
//! The patch under a block of window positions is copied into a matrix (positions × kernel · channels)
//! that stays in cache, and one matrix product does the rest. Weights lie as
//! group × kernel × channels in × channels out.

use std::cell::RefCell;

use crate::Window3;
use crate::matmul::{Matrix, matmul};

/// Sizes of a convolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conv {
    /// Spatial sizes.
    pub window: Window3,
    /// Input channels of all groups.
    pub channels: usize,
    /// Output channels of all groups.
    pub filters: usize,
    /// Channel groups; divides both.
    pub groups: usize,
}

/// Values of the copied patch, chosen to stay inside L2 beside weights and output.
const PATCH: usize = 64 * 1024;

thread_local! {
    static SCRATCH: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
}

impl Conv {
    /// Kernel values that meet in one output value.
    pub fn depth(&self) -> usize {
        self.window.volume() * self.channels / self.groups
    }

    /// Length of the weights.
    pub fn weight_len(&self) -> usize {
        self.depth() * self.filters
    }

    /// Multiply–accumulates of one image.
    pub fn macs(&self) -> usize {
        self.window.output_len() * self.weight_len()
    }

    /// `y = conv(x) + bias`: x [input positions × channels], y [output positions × filters].
    pub fn forward(&self, x: &[f32], weight: &[f32], bias: Option<&[f32]>, y: &mut [f32]) {
        let y = &mut y[..self.window.output_len() * self.filters];
        if let Some(bias) = bias {
            for row in y.chunks_exact_mut(self.filters) {
                row.copy_from_slice(bias);
            }
        }
        let (depth, out) = (self.depth(), self.filters / self.groups);
        self.blocks(|from, to, patch| {
            for group in 0..self.groups {
                let columns = self.patch(x, from, to, group, patch);
                let weight = Matrix::new(&weight[group * depth * out..(group + 1) * depth * out], depth, out);
                let y = &mut y[from * self.filters + group * out..to * self.filters];
                matmul(y, self.filters, columns, weight, bias.is_some());
            }
        });
    }

    /// Gradient of the input, written to or added to `dx`.
    pub fn backward_input(&self, dy: &[f32], weight: &[f32], dx: &mut [f32], accumulate: bool) {
        let dx = &mut dx[..self.window.input_len() * self.channels];
        let (depth, out) = (self.depth(), self.filters / self.groups);
        if self.groups == 1 && self.window.is_identity() {
            let rows = self.window.output_len();
            let dy = Matrix::new(dy, rows, self.filters);
            matmul(dx, self.channels, dy, Matrix::new(weight, depth, out).t(), accumulate);
            return;
        }
        if !accumulate {
            dx.fill(0.0);
        }
        self.blocks(|from, to, patch| {
            for group in 0..self.groups {
                patch.resize((to - from) * depth, 0.0);
                let dy = &dy[from * self.filters + group * out..to * self.filters];
                let dy = Matrix::strided(dy, to - from, out, self.filters);
                let weight = Matrix::new(&weight[group * depth * out..(group + 1) * depth * out], depth, out);
                matmul(patch, depth, dy, weight.t(), false);
                self.scatter(patch, from, to, group, dx);
            }
        });
    }

    /// Adds the gradients of weights and bias of one image.
    pub fn backward_weight(&self, x: &[f32], dy: &[f32], dweight: &mut [f32], dbias: Option<&mut [f32]>) {
        let (depth, out) = (self.depth(), self.filters / self.groups);
        if let Some(dbias) = dbias {
            for row in dy[..self.window.output_len() * self.filters].chunks_exact(self.filters) {
                for (sum, value) in dbias.iter_mut().zip(row) {
                    *sum += value;
                }
            }
        }
        self.blocks(|from, to, patch| {
            for group in 0..self.groups {
                let columns = self.patch(x, from, to, group, patch);
                let dy = &dy[from * self.filters + group * out..to * self.filters];
                let dy = Matrix::strided(dy, to - from, out, self.filters);
                let dweight = &mut dweight[group * depth * out..(group + 1) * depth * out];
                matmul(dweight, out, columns.t(), dy, true);
            }
        });
    }

    /// Calls `body(from, to, scratch)` for blocks of window positions.
    fn blocks(&self, mut body: impl FnMut(usize, usize, &mut Vec<f32>)) {
        let positions = self.window.output_len();
        let block = (PATCH / self.depth()).clamp(8, 1024);
        SCRATCH.with_borrow_mut(|scratch| {
            for from in (0..positions).step_by(block) {
                body(from, (from + block).min(positions), scratch);
            }
        });
    }

    /// The matrix of input values under windows `from..to`: positions × depth.
    fn patch<'a>(
        &self,
        x: &'a [f32],
        from: usize,
        to: usize,
        group: usize,
        scratch: &'a mut Vec<f32>,
    ) -> Matrix<'a> {
        let depth = self.depth();
        if self.groups == 1 && self.window.is_identity() {
            return Matrix::new(&x[from * self.channels..to * self.channels], to - from, depth);
        }
        scratch.resize((to - from) * depth, 0.0);
        let channels = self.channels / self.groups;
        self.runs(from, to, |row, at, source, taps| {
            let target = row * depth + at * channels;
            if self.groups == 1 {
                match source {
                    Some(source) => scratch[target..target + taps * channels]
                        .copy_from_slice(&x[source * channels..(source + taps) * channels]),
                    None => scratch[target..target + taps * channels].fill(0.0),
                }
            } else {
                for tap in 0..taps {
                    let to = target + tap * channels;
                    match source {
                        Some(source) => {
                            let from = (source + tap) * self.channels + group * channels;
                            scratch[to..to + channels].copy_from_slice(&x[from..from + channels]);
                        }
                        None => scratch[to..to + channels].fill(0.0),
                    }
                }
            }
        });
        Matrix::new(scratch, to - from, depth)
    }

    /// Adds a patch matrix back to the input positions that it was taken from.
    fn scatter(&self, patch: &[f32], from: usize, to: usize, group: usize, dx: &mut [f32]) {
        let (depth, channels) = (self.depth(), self.channels / self.groups);
        self.runs(from, to, |row, at, source, taps| {
            let Some(source) = source else { return };
            for tap in 0..taps {
                let from = row * depth + (at + tap) * channels;
                let to = (source + tap) * self.channels + group * channels;
                for (sum, value) in dx[to..to + channels].iter_mut().zip(&patch[from..from + channels]) {
                    *sum += value;
                }
            }
        });
    }

    /// For every window in `from..to`: runs of kernel taps that are contiguous in the input, as
    /// (window, first tap, first input position or `None` outside, number of taps).
    fn runs(&self, from: usize, to: usize, mut run: impl FnMut(usize, usize, Option<usize>, usize)) {
        let Window3 { input, kernel, .. } = self.window;
        for position in from..to {
            let row = position - from;
            let [d, r, c] = self.window.unravel(position);
            let (inside_d, first_d) = self.window.inside(0, d);
            let (inside_r, first_r) = self.window.inside(1, r);
            let (inside_c, first_c) = self.window.inside(2, c);
            for kd in 0..kernel[0] {
                for kr in 0..kernel[1] {
                    let at = (kd * kernel[1] + kr) * kernel[2];
                    if !inside_d.contains(&kd) || !inside_r.contains(&kr) || inside_c.is_empty() {
                        run(row, at, None, kernel[2]);
                        continue;
                    }
                    let depth = first_d + kd - inside_d.start;
                    let line = first_r + kr - inside_r.start;
                    let source = (depth * input[1] + line) * input[2] + first_c;
                    if inside_c.start > 0 {
                        run(row, at, None, inside_c.start);
                    }
                    run(row, at + inside_c.start, Some(source), inside_c.len());
                    if inside_c.end < kernel[2] {
                        run(row, at + inside_c.end, None, kernel[2] - inside_c.end);
                    }
                }
            }
        }
    }
}
