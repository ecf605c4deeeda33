//! Mean over windows that cut each axis into a given number of parts, one image at a time, channels last.

use std::ops::Range;

use crate::lengths::{at_least, image};

/// Sizes of an adaptive average pool over (depth, rows, columns); missing axes have size 1.
///
/// Part i of n over a size s covers ⌊i·s/n⌋ to ⌈(i+1)·s/n⌉, as in `torch.nn.AdaptiveAvgPool3d`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AdaptivePool {
    /// Input size.
    pub input: [usize; 3],
    /// Parts per axis, each at least 1.
    pub output: [usize; 3],
    /// Channels.
    pub channels: usize,
}

impl AdaptivePool {
    /// Writes the mean of every window: x [input positions × channels] → y [output positions × channels].
    pub fn forward(&self, x: &[f32], y: &mut [f32]) {
        at_least("input of a pool", x.len(), image(self.input, self.channels));
        at_least("output of a pool", y.len(), image(self.output, self.channels));
        self.windows(|position, share, inputs| {
            let y = &mut y[position * self.channels..][..self.channels];
            y.fill(0.0);
            for run in inputs {
                for x in x[run].chunks_exact(self.channels) {
                    for (y, x) in y.iter_mut().zip(x) {
                        *y += x;
                    }
                }
            }
            for y in y {
                *y *= share;
            }
        });
    }

    /// Adds each output's gradient, divided, to every position under its window.
    pub fn backward(&self, dy: &[f32], dx: &mut [f32]) {
        at_least("dy of a pool", dy.len(), image(self.output, self.channels));
        at_least("dx of a pool", dx.len(), image(self.input, self.channels));
        self.windows(|position, share, inputs| {
            let dy = &dy[position * self.channels..][..self.channels];
            for run in inputs {
                for dx in dx[run].chunks_exact_mut(self.channels) {
                    for (dx, dy) in dx.iter_mut().zip(dy) {
                        *dx += share * dy;
                    }
                }
            }
        });
    }

    /// Calls `body` with each output position, one over its window's size, and the runs of input values
    /// under the window.
    fn windows(&self, mut body: impl FnMut(usize, f32, &mut dyn Iterator<Item = Range<usize>>)) {
        let [_, rows, columns] = self.output;
        for position in 0..self.output.iter().product() {
            let at = [position / (rows * columns), position / columns % rows, position % columns];
            let [d, r, c] = [0, 1, 2].map(|axis| part(self.input[axis], self.output[axis], at[axis]));
            let share = 1.0 / (d.len() * r.len() * c.len()) as f32;
            let mut runs = d.flat_map(|d| {
                let c = c.clone();
                r.clone().map(move |r| {
                    let line = (d * self.input[1] + r) * self.input[2];
                    (line + c.start) * self.channels..(line + c.end) * self.channels
                })
            });
            body(position, share, &mut runs);
        }
    }
}

/// Returns part `i` of an axis of `size` that is cut into `parts`.
pub(crate) fn part(size: usize, parts: usize, i: usize) -> Range<usize> {
    i * size / parts..((i + 1) * size).div_ceil(parts)
}
