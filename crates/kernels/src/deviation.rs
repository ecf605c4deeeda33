//! Standard deviation over the positions of one image, channels last.

use crate::lengths::{exactly, whole_rows};
use crate::reduce;
use crate::simd::{Simd, at_level};

/// Computes the standard deviation of each channel, x (positions × channels) → y (channels):
/// `√(mean((x − mean)²) + eps)`. Leaves the mean of each channel in `mean`.
pub fn forward(channels: usize, eps: f32, x: &[f32], mean: &mut [f32], y: &mut [f32]) {
    whole_rows("input of a deviation", x.len(), channels);
    exactly("means of a deviation", mean.len(), channels);
    exactly("output of a deviation", y.len(), channels);
    let share = 1.0 / (x.len() / channels) as f32;
    mean.fill(0.0);
    reduce::add_columns(channels, x, mean);
    mean.iter_mut().for_each(|mean| *mean *= share);
    y.fill(0.0);
    reduce::add_squared_deviations(channels, x, mean, y);
    y.iter_mut().for_each(|y| *y = (*y * share + eps).sqrt());
}

at_level! {
    /// Computes `dx = dy · (x − mean) / (positions · y)`, written or added to `dx`; `mean` and `y` come from
    /// [`forward`].
    pub fn backward(
        channels: usize, x: &[f32], mean: &[f32], y: &[f32], dy: &[f32], dx: &mut [f32], accumulate: bool,
    ) = backward_at
}

/// Computes [`backward`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn backward_at<S: Simd>(
    channels: usize,
    x: &[f32],
    mean: &[f32],
    y: &[f32],
    dy: &[f32],
    dx: &mut [f32],
    accumulate: bool,
) {
    whole_rows("input of a deviation", x.len(), channels);
    exactly("input gradient of a deviation", dx.len(), x.len());
    for (what, len) in [("means", mean.len()), ("outputs", y.len()), ("gradients", dy.len())] {
        exactly(what, len, channels);
    }
    let share = 1.0 / (x.len() / channels) as f32;
    for (x, dx) in x.chunks_exact(channels).zip(dx.chunks_exact_mut(channels)) {
        let per_channel = mean.iter().zip(y).zip(dy);
        for ((dx, x), ((mean, y), dy)) in dx.iter_mut().zip(x).zip(per_channel) {
            let gradient = share * dy * (x - mean) / y;
            *dx = if accumulate { *dx + gradient } else { gradient };
        }
    }
}
