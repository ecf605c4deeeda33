//! Operations value by value, and the mean over positions.

use crate::simd::{Simd, at_level};
use crate::view::View;

at_level! {
    /// `y = max(x, 0)`; NaN stays NaN.
    pub fn relu(x: &[f32], y: &mut [f32]) = relu_at
}

// The bodies below are plain loops: instantiated per level, the compiler makes vectors of them.

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn relu_at<S: Simd>(x: &[f32], y: &mut [f32]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y = if x <= 0.0 { 0.0 } else { x };
    }
}

at_level! {
    /// Passes the gradient where `x` (or its ReLU) is not zero or below (PyTorch: the gradient at 0 is 0;
    /// NaN lets it pass).
    pub fn relu_backward(x: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) = relu_backward_at
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn relu_backward_at<S: Simd>(x: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool) {
    for ((dx, &x), &dy) in dx.iter_mut().zip(x).zip(dy) {
        let value = if x <= 0.0 { 0.0 } else { dy };
        *dx = if accumulate { *dx + value } else { value };
    }
}

at_level! {
    /// `y = x`, or `y += x` when `accumulate`.
    pub fn copy(x: &[f32], y: &mut [f32], accumulate: bool) = copy_at
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn copy_at<S: Simd>(x: &[f32], y: &mut [f32], accumulate: bool) {
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

/// Columns `x` (rows × `width`) added to columns `at..at + width` of `y` (rows × `y_width`).
pub fn add_to_columns(x: &[f32], width: usize, y: &mut [f32], y_width: usize, at: usize) {
    for (x, y) in x.chunks_exact(width).zip(y.chunks_exact_mut(y_width)) {
        copy(x, &mut y[at..at + width], true);
    }
}

/// Column `g · width/groups + i` of `x` (rows × `width`) into or onto column `i · groups + g` of `y`;
/// `groups` divides `width`.
pub fn shuffle_columns(x: &[f32], width: usize, groups: usize, y: &mut [f32], accumulate: bool) {
    let each = width / groups;
    for (x, y) in x.chunks_exact(width).zip(y.chunks_exact_mut(width)) {
        for (g, x) in x.chunks_exact(each).enumerate() {
            for (y, &x) in y[g..].iter_mut().step_by(groups).zip(x) {
                *y = if accumulate { *y + x } else { x };
            }
        }
    }
}

at_level! {
    /// `y = factor · x`, or `y += factor · x` when `accumulate`.
    pub fn scale(factor: f32, x: &[f32], y: &mut [f32], accumulate: bool) = scale_at
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn scale_at<S: Simd>(factor: f32, x: &[f32], y: &mut [f32], accumulate: bool) {
    for (y, &x) in y.iter_mut().zip(x) {
        let value = factor * x;
        *y = if accumulate { *y + value } else { value };
    }
}

/// Mean over positions of one image as seen through `view`: x (positions × channels) → y (channels);
/// `scratch` holds as many values as `x`.
pub fn mean_positions(channels: usize, view: &View, x: &[f32], scratch: &mut [f32], y: &mut [f32]) {
    y.fill(0.0);
    crate::reduce::add_columns(channels, view.seen(channels, x, scratch), y);
    let share = 1.0 / (x.len() / channels) as f32;
    for y in y {
        *y *= share;
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
