//! Maximum and mean over windows, one image at a time, channels last.

use crate::Window3;

/// Maximum per window and channel; `taken` remembers the input position for the gradient.
///
/// Padding never wins. Of equal values the first wins; NaN wins over everything, as in PyTorch.
pub fn max_forward(window: &Window3, channels: usize, x: &[f32], y: &mut [f32], taken: &mut [u32]) {
    let outputs = y.chunks_exact_mut(channels).zip(taken.chunks_exact_mut(channels));
    for (position, (y, taken)) in outputs.enumerate().take(window.output_len()) {
        y.fill(f32::NEG_INFINITY);
        let mut first = true;
        each_inside(window, position, |at| {
            let x = &x[at * channels..(at + 1) * channels];
            for ((y, taken), &x) in y.iter_mut().zip(taken.iter_mut()).zip(x) {
                if first || x > *y || (x.is_nan() && !y.is_nan()) {
                    *y = x;
                    *taken = at as u32;
                }
            }
            first = false;
        });
    }
}

/// Adds each output's gradient to the input position that won.
pub fn max_backward(channels: usize, taken: &[u32], dy: &[f32], dx: &mut [f32]) {
    for (taken, dy) in taken.chunks_exact(channels).zip(dy.chunks_exact(channels)) {
        for (channel, (&at, &dy)) in taken.iter().zip(dy).enumerate() {
            dx[at as usize * channels + channel] += dy;
        }
    }
}

/// Mean per window and channel. `counted` is the padding (before, after) per axis that the divisor
/// counts as zeros.
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
        let (mut y, mut taken, mut dx) = ([0.0; 3], [0; 3], [0.0; 6]);
        max_forward(&WINDOW, 1, &[1.0, 1.0, 1.0, 0.0, 2.0, 2.0], &mut y, &mut taken);
        max_backward(1, &taken, &[1.0, 10.0, 100.0], &mut dx);
        assert_eq!(y, [1.0, 1.0, 2.0]);
        assert_eq!(dx, [1.0, 10.0, 0.0, 0.0, 100.0, 0.0]);
    }

    #[test]
    fn nan_and_infinity_come_through() {
        let (mut y, mut taken) = ([0.0; 3], [0; 3]);
        let x = [f32::NEG_INFINITY, f32::NEG_INFINITY, 5.0, f32::NAN, 7.0, f32::INFINITY];
        max_forward(&WINDOW, 1, &x, &mut y, &mut taken);
        assert_eq!(y[0], f32::NEG_INFINITY);
        assert!(y[1].is_nan() && taken[1] == 3, "NaN wins over 5");
        assert!(y[2].is_nan() && taken[2] == 3, "NaN stays although larger values follow");
    }
}
