//! Operations value by value, and the mean over positions.

/// `y = max(x, 0)`; NaN stays NaN.
pub fn relu(x: &[f32], y: &mut [f32]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y = if x <= 0.0 { 0.0 } else { x };
    }
}

/// Passes the gradient where the output is not zero (PyTorch: the gradient at 0 is 0; NaN lets it pass).
pub fn relu_backward(y: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) {
    for ((dx, &y), &dy) in dx.iter_mut().zip(y).zip(dy) {
        let value = if y <= 0.0 { 0.0 } else { dy };
        *dx = if accumulate { *dx + value } else { value };
    }
}

/// `y = x`, or `y += x` when `accumulate`.
pub fn copy(x: &[f32], y: &mut [f32], accumulate: bool) {
    if accumulate {
        for (y, x) in y.iter_mut().zip(x) {
            *y += x;
        }
    } else {
        y.copy_from_slice(x);
    }
}

/// Columns `x` (rows × `width`) into columns `at..at + width` of `y` (rows × `y_width`).
pub fn put_columns(x: &[f32], width: usize, y: &mut [f32], y_width: usize, at: usize) {
    for (x, y) in x.chunks_exact(width).zip(y.chunks_exact_mut(y_width)) {
        y[at..at + width].copy_from_slice(x);
    }
}

/// Columns `at..at + width` of `y` (rows × `y_width`) into or onto `x` (rows × `width`).
pub fn take_columns(y: &[f32], y_width: usize, at: usize, x: &mut [f32], width: usize, accumulate: bool) {
    for (x, y) in x.chunks_exact_mut(width).zip(y.chunks_exact(y_width)) {
        copy(&y[at..at + width], x, accumulate);
    }
}

/// Mean over positions of one image: x (positions × channels) → y (channels).
pub fn mean_positions(channels: usize, x: &[f32], y: &mut [f32]) {
    let mut sums = vec![0.0f64; channels];
    crate::batch_norm::sum(channels, x, &mut sums);
    let positions = (x.len() / channels) as f64;
    for (y, sum) in y.iter_mut().zip(sums) {
        *y = (sum / positions) as f32;
    }
}

/// Spreads the gradient of a mean evenly over the positions of one image.
pub fn mean_positions_backward(channels: usize, dy: &[f32], dx: &mut [f32], accumulate: bool) {
    let share = 1.0 / (dx.len() / channels) as f32;
    for dx in dx.chunks_exact_mut(channels) {
        for (dx, dy) in dx.iter_mut().zip(dy) {
            *dx = if accumulate { *dx + share * dy } else { share * dy };
        }
    }
}
