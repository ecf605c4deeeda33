//! Depthwise convolution: every channel has its own kernel, so vectors run along channels.
//!
//! Weights lie as kernel × channels.

use crate::Window3;
use crate::simd::{Simd, at_level};
use crate::view::{load, store, vectors};

at_level! {
    /// `y = conv(x) + bias` on a halo-padded image of size `padded` (positions × channels), written or
    /// added to `y`.
    pub(crate) fn forward(
        window: &Window3, padded: [usize; 3], channels: usize, x: &[f32], weight: &[f32], bias: &[f32],
        y: &mut [f32], add: bool,
    ) = forward_at
}

/// Kernel sizes whose weights stay in registers.
const HELD: usize = 9;

/// # Safety
/// The CPU has the features of `S`.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
unsafe fn forward_at<S: Simd>(
    window: &Window3,
    padded: [usize; 3],
    channels: usize,
    x: &[f32],
    weight: &[f32],
    bias: &[f32],
    y: &mut [f32],
    add: bool,
) {
    let offsets = offsets(window, padded);
    check(window, padded, channels, x, weight, y);
    assert!(bias.is_empty() || bias.len() == channels);
    vectors!(S, channels, c, n, {
        // SAFETY: `c + n <= channels`; a position's last tap ends inside the padded image.
        unsafe {
            let start = if bias.is_empty() { S::splat(0.0) } else { load::<S>(bias, c, n) };
            let mut held = [S::splat(0.0); HELD];
            let few = offsets.len() == HELD;
            for (k, held) in held.iter_mut().enumerate().take(offsets.len()) {
                *held = load::<S>(weight, k * channels + c, n);
            }
            for position in 0..window.output_len() {
                let at = first(window, padded, position) * channels + c;
                let to = position * channels + c;
                let mut sum = if add { S::add(start, load::<S>(y, to, n)) } else { start };
                if few {
                    for k in 0..HELD {
                        sum = S::fma(load::<S>(x, at + offsets[k] * channels, n), held[k], sum);
                    }
                } else {
                    for (k, offset) in offsets.iter().enumerate() {
                        let w = load::<S>(weight, k * channels + c, n);
                        sum = S::fma(load::<S>(x, at + offset * channels, n), w, sum);
                    }
                }
                store::<S>(y, to, n, sum);
            }
        }
    });
}

at_level! {
    /// Adds the gradient of the weights.
    pub(crate) fn backward_weight(
        window: &Window3, padded: [usize; 3], channels: usize, x: &[f32], dy: &[f32], dweight: &mut [f32],
    ) = backward_weight_at
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn backward_weight_at<S: Simd>(
    window: &Window3,
    padded: [usize; 3],
    channels: usize,
    x: &[f32],
    dy: &[f32],
    dweight: &mut [f32],
) {
    let offsets = offsets(window, padded);
    check(window, padded, channels, x, dweight, dy);
    vectors!(S, channels, c, n, {
        // As many taps at a time as stay in registers.
        for (block, offsets) in offsets.chunks(HELD).enumerate() {
            // SAFETY: `c + n <= channels`; a position's last tap ends inside the padded image.
            unsafe {
                let mut sums = [S::splat(0.0); HELD];
                for position in 0..window.output_len() {
                    let at = first(window, padded, position) * channels + c;
                    let dy = load::<S>(dy, position * channels + c, n);
                    for (sum, offset) in sums.iter_mut().zip(offsets) {
                        *sum = S::fma(load::<S>(x, at + offset * channels, n), dy, *sum);
                    }
                }
                for (k, sum) in sums.iter().enumerate().take(offsets.len()) {
                    let to = (block * HELD + k) * channels + c;
                    store::<S>(dweight, to, n, S::add(load::<S>(dweight, to, n), *sum));
                }
            }
        }
    });
}

at_level! {
    /// Adds the gradient of the input, tap by tap; for strides above 1.
    pub(crate) fn scatter(
        window: &Window3, channels: usize, dy: &[f32], weight: &[f32], dx: &mut [f32],
    ) = scatter_at
}

/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn scatter_at<S: Simd>(window: &Window3, channels: usize, dy: &[f32], weight: &[f32], dx: &mut [f32]) {
    let Window3 { input, kernel, .. } = *window;
    for position in 0..window.output_len() {
        let [d, r, c] = window.unravel(position);
        let (depths, first_d) = window.inside(0, d);
        let (rows, first_r) = window.inside(1, r);
        let (columns, first_c) = window.inside(2, c);
        let dy = &dy[position * channels..(position + 1) * channels];
        for kd in depths.clone() {
            for kr in rows.clone() {
                for kc in columns.clone() {
                    let k = (kd * kernel[1] + kr) * kernel[2] + kc;
                    let line = (first_d + kd - depths.start) * input[1] + first_r + kr - rows.start;
                    let at = (line * input[2] + first_c + kc - columns.start) * channels;
                    let dx = &mut dx[at..at + channels];
                    let weight = &weight[k * channels..(k + 1) * channels];
                    vectors!(S, channels, c, n, {
                        // SAFETY: `c + n <= channels`, the length of the three rows.
                        unsafe {
                            let product =
                                S::fma(load::<S>(dy, c, n), load::<S>(weight, c, n), load::<S>(dx, c, n));
                            store::<S>(dx, c, n, product);
                        }
                    });
                }
            }
        }
    }
}

/// Positions of the taps from a window's first one.
fn offsets(window: &Window3, padded: [usize; 3]) -> Vec<usize> {
    let Window3 { kernel, .. } = window;
    let mut offsets = Vec::with_capacity(window.volume());
    for kd in 0..kernel[0] {
        for kr in 0..kernel[1] {
            offsets.extend((0..kernel[2]).map(|kc| (kd * padded[1] + kr) * padded[2] + kc));
        }
    }
    offsets
}

/// A window's first position in the padded image.
#[inline(always)]
fn first(window: &Window3, padded: [usize; 3], position: usize) -> usize {
    let [d, r, c] = window.unravel(position);
    let stride = window.stride;
    (d * stride[0] * padded[1] + r * stride[1]) * padded[2] + c * stride[2]
}

fn check(window: &Window3, padded: [usize; 3], channels: usize, x: &[f32], weight: &[f32], y: &[f32]) {
    assert!(x.len() >= padded.iter().product::<usize>() * channels, "a padded image");
    assert!((0..3).all(|a| (window.output[a] - 1) * window.stride[a] + window.kernel[a] <= padded[a]));
    assert!(weight.len() >= window.volume() * channels && y.len() >= window.output_len() * channels);
}
