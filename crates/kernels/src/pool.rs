//! Maximum and mean over windows, one image at a time, channels last.

use std::ops::Range;

use crate::lengths::{at_least, exactly, image};
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};
use crate::view::{AffineView, Rectifier, rectify};
use crate::window::Window3;

/// Maximum over windows, with the positions under every window.
#[derive(Debug, Clone)]
pub struct MaxPool {
    channels: usize,
    /// Values of an input image.
    input_len: usize,
    /// Positions under a window, counted from its first one, each with its number in the window. All windows
    /// that lie inside the input share the first list; each window over an edge has a list of its own.
    under: Vec<(usize, f32)>,
    /// First position of every window, and where its others are in `under`. All lie inside the input.
    windows: Vec<(usize, Range<usize>)>,
    /// Where windows do not overlap: the positions that no window covers.
    uncovered: Option<Vec<usize>>,
    /// Scale and shift of a view that has none.
    plain: [Vec<f32>; 2],
}

impl MaxPool {
    /// Makes a pool over an image of `channels`.
    pub fn new(window: &Window3, channels: usize) -> Self {
        let Window3 { input, kernel, .. } = *window;
        let line = |d: usize, r: usize| (d * input[1] + r) * input[2];
        let number = |d: usize, r: usize, c: usize| ((d * kernel[1] + r) * kernel[2] + c) as f32;
        let mut under: Vec<(usize, f32)> = vec![];
        let add = |under: &mut Vec<(usize, f32)>, ranges: [Range<usize>; 3]| {
            let [depths, rows, columns] = ranges;
            let from = under.len();
            for d in depths.clone() {
                for r in rows.clone() {
                    for c in columns.clone() {
                        let at = line(d - depths.start, r - rows.start) + c - columns.start;
                        under.push((at, number(d, r, c)));
                    }
                }
            }
            from..under.len()
        };
        let whole = add(&mut under, kernel.map(|size| 0..size));
        let windows: Vec<(usize, Range<usize>)> = (0..window.output_len())
            .map(|position| {
                let at = window.unravel(position);
                let [d, r, c] = [0, 1, 2].map(|axis| window.inside(axis, at[axis]));
                let first = line(d.1, r.1) + c.1;
                let ranges = [d.0, r.0, c.0];
                let inside = (0..3).all(|axis| ranges[axis].len() == kernel[axis]);
                (first, if inside { whole.clone() } else { add(&mut under, ranges) })
            })
            .collect();
        for (first, range) in &windows {
            let mut inside = under[range.clone()].iter().map(|(offset, _)| first + offset);
            assert!(inside.all(|at| at < window.input_len()), "positions inside the input are needed");
        }
        let disjoint = (0..3).all(|axis| window.stride[axis] >= kernel[axis]);
        let uncovered = disjoint.then(|| {
            let mut covered = vec![false; window.input_len()];
            for (first, range) in &windows {
                for (offset, _) in &under[range.clone()] {
                    covered[first + offset] = true;
                }
            }
            (0..covered.len()).filter(|&at| !covered[at]).collect()
        });
        let plain = [vec![1.0; channels], vec![0.0; channels]];
        MaxPool { channels, input_len: image(input, channels), under, windows, uncovered, plain }
    }

    /// Returns the number of values of one output image.
    pub fn output_len(&self) -> usize {
        self.windows.len() * self.channels
    }

    /// Computes the maximum per window and channel of `x` as seen through `view`; `taken` remembers which value of
    /// the window won, for the gradient.
    ///
    /// Padding never wins. Of equal values the first wins; NaN wins over everything, as in PyTorch.
    pub fn forward(&self, view: &AffineView, x: &[f32], y: &mut [f32], taken: &mut [f32]) {
        let len = self.output_len();
        at_least("output of a pool", y.len(), len);
        at_least("winners of a pool", taken.len(), len);
        let [ones, zeros] = &self.plain;
        let (scale, shift) = view.affine.unwrap_or((ones, zeros));
        max_of_windows(self, x, scale, shift, view.rectifier, &mut y[..len], &mut taken[..len]);
    }

    /// Gives each output's gradient to the input position that won, written to or added to `dx`.
    pub fn backward(&self, taken: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) {
        let len = self.output_len();
        at_least("winners of a pool", taken.len(), len);
        at_least("dy of a pool", dy.len(), len);
        at_least("dx of a pool", dx.len(), self.input_len);
        let dx = &mut dx[..self.input_len];
        if !accumulate {
            match &self.uncovered {
                Some(positions) => {
                    for at in positions {
                        dx[at * self.channels..(at + 1) * self.channels].fill(0.0);
                    }
                }
                None => dx.fill(0.0),
            }
        }
        let add = accumulate || self.uncovered.is_none();
        give_to_winners(self, &taken[..len], &dy[..len], dx, add);
    }
}

at_level! {
    fn max_of_windows(
        pool: &MaxPool, x: &[f32], scale: &[f32], shift: &[f32], rectifier: Rectifier, y: &mut [f32], taken: &mut [f32],
    ) = max_of_windows_at
}

/// Computes maxima and winners of all windows with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn max_of_windows_at<S: Simd>(
    pool: &MaxPool,
    x: &[f32],
    scale: &[f32],
    shift: &[f32],
    rectifier: Rectifier,
    y: &mut [f32],
    taken: &mut [f32],
) {
    let channels = pool.channels;
    at_least("input of a pool", x.len(), pool.input_len);
    exactly("scale of a pool's view", scale.len(), channels);
    exactly("shift of a pool's view", shift.len(), channels);
    let outputs = y.chunks_exact_mut(channels).zip(taken.chunks_exact_mut(channels));
    for ((base, under), (y, taken)) in pool.windows.iter().zip(outputs) {
        let under = &pool.under[under.clone()];
        vectors!(S, channels, c, n, {
            // SAFETY: `c + n <= channels`: the asserted length of scale and shift, and that of `y` and
            // `taken` by `chunks_exact`. Every position lies inside the input, as `MaxPool::new` has
            // asserted, and `x` is asserted to hold the input.
            unsafe {
                let (scale, shift) = (load::<S>(scale, c, n), load::<S>(shift, c, n));
                let (mut best, mut which) = (S::splat(f32::NEG_INFINITY), S::splat(0.0));
                for (i, &(offset, k)) in under.iter().enumerate() {
                    let at = base + offset;
                    let value = S::fma(load::<S>(x, at * channels + c, n), scale, shift);
                    let value = rectify::<S>(rectifier, value);
                    if i == 0 {
                        (best, which) = (value, S::splat(k));
                    } else {
                        which = S::where_beats(value, best, S::splat(k), which);
                        best = S::where_beats(value, best, value, best);
                    }
                }
                store::<S>(y, c, n, best);
                store::<S>(taken, c, n, which);
            }
        });
    }
}

at_level! {
    fn give_to_winners(pool: &MaxPool, taken: &[f32], dy: &[f32], dx: &mut [f32], add: bool) =
        give_to_winners_at
}

/// Writes each output's gradient to the winner of its window, and 0 to the other values under it, with vectors of
/// `S`. With `add` it adds them.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn give_to_winners_at<S: Simd>(pool: &MaxPool, taken: &[f32], dy: &[f32], dx: &mut [f32], add: bool) {
    let channels = pool.channels;
    at_least("dx of a pool", dx.len(), pool.input_len);
    let outputs = taken.chunks_exact(channels).zip(dy.chunks_exact(channels));
    for ((base, under), (taken, dy)) in pool.windows.iter().zip(outputs) {
        let under = &pool.under[under.clone()];
        vectors!(S, channels, c, n, {
            // SAFETY: `c + n <= channels`, the length of `taken` and `dy` by `chunks_exact`. Every position
            // lies inside the input, as `MaxPool::new` has asserted, and `dx` is asserted to hold the input.
            unsafe {
                let (taken, dy) = (load::<S>(taken, c, n), load::<S>(dy, c, n));
                for &(offset, k) in under {
                    let at = base + offset;
                    let mut value = S::where_equal(taken, S::splat(k), dy);
                    if add {
                        value = S::add(value, load::<S>(dx, at * channels + c, n));
                    }
                    store::<S>(dx, at * channels + c, n, value);
                }
            }
        });
    }
}

/// Computes the mean per window and channel. `counted` is the padding (before, after) per axis that the divisor
/// counts as zeros.
///
/// `x` is what the pool sees: no view in between.
pub fn average_forward(
    window: &Window3,
    counted: &[(usize, usize); 3],
    channels: usize,
    x: &[f32],
    y: &mut [f32],
) {
    at_least("input of a pool", x.len(), image(window.input, channels));
    at_least("output of a pool", y.len(), image(window.output, channels));
    for (position, y) in y.chunks_exact_mut(channels).enumerate().take(window.output_len()) {
        y.fill(0.0);
        each_inside(window, position, |at| {
            for (y, x) in y.iter_mut().zip(&x[at * channels..(at + 1) * channels]) {
                *y += x;
            }
        });
        let share = 1.0 / divisor(window, counted, position) as f32;
        for y in y {
            *y *= share;
        }
    }
}

/// Adds each output's gradient, divided, to every position under its window.
pub fn average_backward(
    window: &Window3,
    counted: &[(usize, usize); 3],
    channels: usize,
    dy: &[f32],
    dx: &mut [f32],
) {
    at_least("dy of a pool", dy.len(), image(window.output, channels));
    at_least("dx of a pool", dx.len(), image(window.input, channels));
    for (position, dy) in dy.chunks_exact(channels).enumerate().take(window.output_len()) {
        let share = 1.0 / divisor(window, counted, position) as f32;
        each_inside(window, position, |at| {
            for (dx, dy) in dx[at * channels..(at + 1) * channels].iter_mut().zip(dy) {
                *dx += share * dy;
            }
        });
    }
}

fn each_inside(window: &Window3, position: usize, mut body: impl FnMut(usize)) {
    let [d, r, c] = window.unravel(position);
    let (depths, first_d) = window.inside(0, d);
    let (rows, first_r) = window.inside(1, r);
    let (columns, first_c) = window.inside(2, c);
    for d in first_d..first_d + depths.len() {
        for r in first_r..first_r + rows.len() {
            let line = (d * window.input[1] + r) * window.input[2];
            for at in line + first_c..line + first_c + columns.len() {
                body(at);
            }
        }
    }
}

/// Returns the number of window values inside the input and its counted padding.
fn divisor(window: &Window3, counted: &[(usize, usize); 3], position: usize) -> usize {
    let at = window.unravel(position);
    (0..3).map(|axis| window.counted(axis, at[axis], counted[axis])).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: Window3 = Window3 {
        input: [1, 1, 6],
        output: [1, 1, 3],
        kernel: [1, 1, 3],
        stride: [1, 1, 2],
        before: [0, 0, 1],
    };

    /// Compares the gradients of equal values with PyTorch's:
    ///
    /// ```python
    /// x = torch.tensor([[[1., 1., 1., 0., 2., 2.]]], requires_grad=True)
    /// y = torch.nn.functional.max_pool1d(x, 3, 2, padding=1)
    /// (y * torch.tensor([1., 10., 100.])).sum().backward()
    /// # y: 1 1 2, x.grad: 1 10 0 0 100 0
    /// ```
    #[test]
    fn the_first_of_equals_gets_the_gradient() {
        let (mut y, mut taken, mut dx) = ([0.0; 3], [0.0; 3], [0.0; 6]);
        let x = [1.0, 1.0, 1.0, 0.0, 2.0, 2.0];
        let pool = MaxPool::new(&WINDOW, 1);
        pool.forward(&AffineView::default(), &x, &mut y, &mut taken);
        pool.backward(&taken, &[1.0, 10.0, 100.0], &mut dx, false);
        assert_eq!(y, [1.0, 1.0, 2.0]);
        assert_eq!(dx, [1.0, 10.0, 0.0, 0.0, 100.0, 0.0]);
    }

    #[test]
    fn nan_and_infinity_come_through() {
        let (mut y, mut taken) = ([0.0; 3], [0.0; 3]);
        let x = [f32::NEG_INFINITY, f32::NEG_INFINITY, 5.0, f32::NAN, 7.0, f32::INFINITY];
        MaxPool::new(&WINDOW, 1).forward(&AffineView::default(), &x, &mut y, &mut taken);
        assert_eq!(y[0], f32::NEG_INFINITY);
        assert!(y[1].is_nan() && taken[1] == 2.0, "NaN wins over 5");
        assert!(y[2].is_nan() && taken[2] == 0.0, "NaN stays although larger values follow");
    }

    /// Covers overlapping windows, and ones that leave a column out.
    #[test]
    fn gradients_are_written_or_added() {
        let apart = Window3 {
            input: [1, 1, 5],
            output: [1, 1, 2],
            kernel: [1, 1, 2],
            stride: [1, 1, 2],
            before: [0; 3],
        };
        let cases =
            [(WINDOW, vec![1.0, 10.0, 0.0, 0.0, 100.0, 0.0]), (apart, vec![1.0, 0.0, 10.0, 0.0, 0.0])];
        let x = [1.0, 1.0, 1.0, 0.0, 2.0, 2.0];
        for (window, want) in cases {
            let pool = MaxPool::new(&window, 1);
            let (mut y, mut taken) = (vec![0.0; pool.output_len()], vec![0.0; pool.output_len()]);
            pool.forward(&AffineView::default(), &x[..want.len()], &mut y, &mut taken);
            let dy = [1.0, 10.0, 100.0];
            let mut dx = vec![7.0; want.len()];
            pool.backward(&taken, &dy[..y.len()], &mut dx, false);
            assert_eq!(dx, want, "written");
            pool.backward(&taken, &dy[..y.len()], &mut dx, true);
            assert_eq!(dx, want.iter().map(|v| 2.0 * v).collect::<Vec<f32>>(), "added");
        }
    }
}
