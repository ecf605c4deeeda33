//! Maximum and mean over windows, one image at a time, channels last.

use crate::Window3;
use crate::simd::{Simd, at_level};
use crate::view::{Rectifier, View, load, rectify, store, vectors};

/// Maximum per window and channel of `x` as seen through `view`; `taken` remembers which value of the
/// window won, for the gradient.
///
/// Padding never wins. Of equal values the first wins; NaN wins over everything, as in PyTorch.
pub fn max_forward(
    window: &Window3,
    channels: usize,
    view: &View,
    x: &[f32],
    y: &mut [f32],
    taken: &mut [f32],
) {
    assert!(x.len() >= window.input_len() * channels, "an input image");
    let len = window.output_len() * channels;
    let (ones, zeros);
    let (scale, shift) = match view.affine {
        Some(affine) => affine,
        None => {
            (ones, zeros) = (vec![1.0; channels], vec![0.0; channels]);
            (&ones[..], &zeros[..])
        }
    };
    max_of_windows(window, channels, x, scale, shift, view.rectifier, &mut y[..len], &mut taken[..len]);
}

at_level! {
    fn max_of_windows(
        window: &Window3, channels: usize, x: &[f32], scale: &[f32], shift: &[f32], rectifier: Rectifier,
        y: &mut [f32], taken: &mut [f32],
    ) = max_of_windows_at
}

/// # Safety
/// The CPU has the features of `S`; `x` holds an input image.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
unsafe fn max_of_windows_at<S: Simd>(
    window: &Window3,
    channels: usize,
    x: &[f32],
    scale: &[f32],
    shift: &[f32],
    rectifier: Rectifier,
    y: &mut [f32],
    taken: &mut [f32],
) {
    assert!(scale.len() == channels && shift.len() == channels);
    let mut windows = Under::new(window);
    let outputs = y.chunks_exact_mut(channels).zip(taken.chunks_exact_mut(channels));
    for (position, (y, taken)) in outputs.enumerate() {
        let (base, under) = windows.at(position);
        vectors!(S, channels, c, n, {
            // SAFETY: `c + n <= channels`; positions lie inside the image.
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

/// Gives each output's gradient to the input position that won, written to or added to `dx`.
pub fn max_backward(
    window: &Window3,
    channels: usize,
    taken: &[f32],
    dy: &[f32],
    dx: &mut [f32],
    accumulate: bool,
) {
    let len = window.output_len() * channels;
    let dx = &mut dx[..window.input_len() * channels];
    // Where windows tile the input, every position is written exactly once.
    let tiled = (0..3).all(|a| {
        window.stride[a] == window.kernel[a]
            && window.before[a] == 0
            && window.output[a] * window.stride[a] >= window.input[a]
    });
    if !accumulate && !tiled {
        dx.fill(0.0);
    }
    give_to_winners(window, channels, &taken[..len], &dy[..len], dx, accumulate || !tiled);
}

at_level! {
    fn give_to_winners(
        window: &Window3, channels: usize, taken: &[f32], dy: &[f32], dx: &mut [f32], add: bool,
    ) = give_to_winners_at
}

/// # Safety
/// The CPU has the features of `S`; `dx` holds an input image.
#[inline(always)]
unsafe fn give_to_winners_at<S: Simd>(
    window: &Window3,
    channels: usize,
    taken: &[f32],
    dy: &[f32],
    dx: &mut [f32],
    add: bool,
) {
    let mut windows = Under::new(window);
    let outputs = taken.chunks_exact(channels).zip(dy.chunks_exact(channels));
    for (position, (taken, dy)) in outputs.enumerate() {
        let (base, under) = windows.at(position);
        vectors!(S, channels, c, n, {
            // SAFETY: `c + n <= channels`; positions lie inside the image.
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

/// Input positions under windows, each with its number inside the window.
struct Under<'a> {
    window: &'a Window3,
    /// Of a window that lies inside the input, from its first position.
    whole: Vec<(usize, f32)>,
    /// Of one that hangs over an edge.
    cut: Vec<(usize, f32)>,
}

impl<'a> Under<'a> {
    fn new(window: &'a Window3) -> Self {
        let Window3 { input, kernel, .. } = *window;
        let mut whole = vec![];
        for kd in 0..kernel[0] {
            for kr in 0..kernel[1] {
                for kc in 0..kernel[2] {
                    whole.push(((kd * input[1] + kr) * input[2] + kc, whole.len() as f32));
                }
            }
        }
        Under { window, whole, cut: vec![] }
    }

    /// The positions under a window: a first one, and offsets from it.
    fn at(&mut self, position: usize) -> (usize, &[(usize, f32)]) {
        let window = self.window;
        let [d, r, c] = window.unravel(position);
        let (depths, first_d) = window.inside(0, d);
        let (rows, first_r) = window.inside(1, r);
        let (columns, first_c) = window.inside(2, c);
        if [depths.len(), rows.len(), columns.len()] == window.kernel {
            return ((first_d * window.input[1] + first_r) * window.input[2] + first_c, &self.whole);
        }
        self.cut.clear();
        for kd in depths.clone() {
            for kr in rows.clone() {
                for kc in columns.clone() {
                    let line = (first_d + kd - depths.start) * window.input[1] + first_r + kr - rows.start;
                    let at = line * window.input[2] + first_c + kc - columns.start;
                    self.cut.push((at, ((kd * window.kernel[1] + kr) * window.kernel[2] + kc) as f32));
                }
            }
        }
        (0, &self.cut)
    }
}

/// Mean per window and channel. `counted` is the padding (before, after) per axis that the divisor
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

/// Window values inside the input and its counted padding.
fn divisor(window: &Window3, counted: &[(usize, usize); 3], position: usize) -> usize {
    let at = window.unravel(position);
    (0..3)
        .map(|axis| {
            // In coordinates that start at the first padded position.
            let start = at[axis] * window.stride[axis];
            let low = start.max(window.before[axis] - counted[axis].0);
            let high =
                (start + window.kernel[axis]).min(window.before[axis] + window.input[axis] + counted[axis].1);
            high.saturating_sub(low).max(1)
        })
        .product()
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
        max_forward(&WINDOW, 1, &View::default(), &x, &mut y, &mut taken);
        max_backward(&WINDOW, 1, &taken, &[1.0, 10.0, 100.0], &mut dx, false);
        assert_eq!(y, [1.0, 1.0, 2.0]);
        assert_eq!(dx, [1.0, 10.0, 0.0, 0.0, 100.0, 0.0]);
    }

    #[test]
    fn nan_and_infinity_come_through() {
        let (mut y, mut taken) = ([0.0; 3], [0.0; 3]);
        let x = [f32::NEG_INFINITY, f32::NEG_INFINITY, 5.0, f32::NAN, 7.0, f32::INFINITY];
        max_forward(&WINDOW, 1, &View::default(), &x, &mut y, &mut taken);
        assert_eq!(y[0], f32::NEG_INFINITY);
        assert!(y[1].is_nan() && taken[1] == 2.0, "NaN wins over 5");
        assert!(y[2].is_nan() && taken[2] == 0.0, "NaN stays although larger values follow");
    }
}
