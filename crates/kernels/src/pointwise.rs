//! Values moved, added and scaled, and the mean over positions.

use crate::lengths::{exactly, whole_rows};
use crate::reduce;
use crate::simd::{Simd, at_level};
use crate::view::AffineView;

// The bodies below are plain loops: instantiated per level, the compiler makes vectors of them.

at_level! {
    /// Writes `y = x`, or `y += x` when `accumulate`.
    pub fn copy(x: &[f32], y: &mut [f32], accumulate: bool) = copy_at
}

/// Runs [`copy`], compiled for the vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn copy_at<S: Simd>(x: &[f32], y: &mut [f32], accumulate: bool) {
    exactly("output of a copy", y.len(), x.len());
    if accumulate {
        for (y, x) in y.iter_mut().zip(x) {
            *y += x;
        }
    } else {
        y.copy_from_slice(x);
    }
}

/// Copies `x` (rows × `width`) into columns `at..at + width` of `y` (rows × `y_width`).
pub fn put_columns(x: &[f32], width: usize, y: &mut [f32], y_width: usize, at: usize) {
    check_columns(x, width, y, y_width, at);
    for (x, y) in x.chunks_exact(width).zip(y.chunks_exact_mut(y_width)) {
        y[at..at + width].copy_from_slice(x);
    }
}

/// Copies columns `at..at + width` of `y` (rows × `y_width`) into `x` (rows × `width`), or adds them to it.
pub fn take_columns(y: &[f32], y_width: usize, at: usize, x: &mut [f32], width: usize, accumulate: bool) {
    check_columns(x, width, y, y_width, at);
    for (x, y) in x.chunks_exact_mut(width).zip(y.chunks_exact(y_width)) {
        copy(&y[at..at + width], x, accumulate);
    }
}

/// Adds `x` (rows × `width`) to columns `at..at + width` of `y` (rows × `y_width`).
pub fn add_to_columns(x: &[f32], width: usize, y: &mut [f32], y_width: usize, at: usize) {
    check_columns(x, width, y, y_width, at);
    for (x, y) in x.chunks_exact(width).zip(y.chunks_exact_mut(y_width)) {
        copy(x, &mut y[at..at + width], true);
    }
}

/// Panics unless `x` and `y` hold equally many rows and the columns lie inside those of `y`.
fn check_columns(x: &[f32], width: usize, y: &[f32], y_width: usize, at: usize) {
    whole_rows("the narrow rows", x.len(), width);
    whole_rows("the wide rows", y.len(), y_width);
    exactly("rows of both", x.len() / width, y.len() / y_width);
    assert!(at <= y_width && width <= y_width - at, "{width} columns from {at} on are needed of {y_width}");
}

/// Copies column `g · width/groups + i` of `x` (rows × `width`) into column `i · groups + g` of `y`, or adds it;
/// `groups` divides `width`.
pub fn shuffle_columns(x: &[f32], width: usize, groups: usize, y: &mut [f32], accumulate: bool) {
    assert!(groups > 0 && width.is_multiple_of(groups), "groups that divide {width} columns are needed");
    whole_rows("input of a shuffle", x.len(), width);
    exactly("output of a shuffle", y.len(), x.len());
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
    /// Computes `y = factor · x`, or `y += factor · x` when `accumulate`.
    pub fn scale(factor: f32, x: &[f32], y: &mut [f32], accumulate: bool) = scale_at
}

/// Computes [`scale`], compiled for the vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn scale_at<S: Simd>(factor: f32, x: &[f32], y: &mut [f32], accumulate: bool) {
    exactly("output of a product", y.len(), x.len());
    for (y, &x) in y.iter_mut().zip(x) {
        let value = factor * x;
        *y = if accumulate { *y + value } else { value };
    }
}

/// Computes the mean over positions of one image as seen through `view`: x (positions × channels) → y (channels).
/// `scratch` holds as many values as `x`.
pub fn mean_positions(channels: usize, view: &AffineView, x: &[f32], scratch: &mut [f32], y: &mut [f32]) {
    whole_rows("input of a mean", x.len(), channels);
    exactly("output of a mean", y.len(), channels);
    y.fill(0.0);
    reduce::add_columns(channels, view.seen(channels, x, scratch), y);
    let share = 1.0 / (x.len() / channels) as f32;
    for y in y {
        *y *= share;
    }
}

/// Spreads the gradient of a mean evenly over the positions of one image.
pub fn mean_positions_backward(channels: usize, dy: &[f32], dx: &mut [f32], accumulate: bool) {
    whole_rows("input gradient of a mean", dx.len(), channels);
    exactly("gradient of a mean", dy.len(), channels);
    let share = 1.0 / (dx.len() / channels) as f32;
    for dx in dx.chunks_exact_mut(channels) {
        for (dx, dy) in dx.iter_mut().zip(dy) {
            *dx = if accumulate { *dx + share * dy } else { share * dy };
        }
    }
}
