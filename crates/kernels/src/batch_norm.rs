//! Batch normalisation over rows × channels.
//!
//! Reductions come as per-part sums in `f64`: the caller splits the rows, adds the parts in a fixed
//! order and so gets the same bits from any number of threads.

/// Adds each channel's sum.
pub fn sum(channels: usize, x: &[f32], sums: &mut [f64]) {
    accumulate(channels, sums, x.chunks_exact(channels), |row, channel| row[channel]);
}

/// Adds each channel's sum of squared deviations from `mean`.
pub fn squared_deviations(channels: usize, x: &[f32], mean: &[f32], sums: &mut [f64]) {
    accumulate(channels, sums, x.chunks_exact(channels), |row, channel| {
        let deviation = row[channel] - mean[channel];
        deviation * deviation
    });
}

/// `y = x · scale + shift` per channel.
pub fn affine(channels: usize, x: &[f32], scale: &[f32], shift: &[f32], y: &mut [f32]) {
    for (y, x) in y.chunks_exact_mut(channels).zip(x.chunks_exact(channels)) {
        for c in 0..channels {
            y[c] = x[c] * scale[c] + shift[c];
        }
    }
}

/// Adds each channel's sum of `dy` and of `dy · (x - mean)`.
pub fn backward_sums(
    channels: usize,
    x: &[f32],
    dy: &[f32],
    mean: &[f32],
    dy_sums: &mut [f64],
    deviation_sums: &mut [f64],
) {
    accumulate(channels, dy_sums, dy.chunks_exact(channels), |row, c| row[c]);
    let rows = x.chunks_exact(channels).zip(dy.chunks_exact(channels));
    accumulate(channels, deviation_sums, rows, |(x, dy), c| dy[c] * (x[c] - mean[c]));
}

/// Coefficients of the input gradient: `dx = a · dy + b · (x − mean) + c` per channel.
#[derive(Debug, Clone, Default)]
pub struct InputGradient {
    /// Factor of `dy`.
    pub dy: Vec<f32>,
    /// Factor of `x − mean`.
    pub x: Vec<f32>,
    /// Batch mean.
    pub mean: Vec<f32>,
    /// Constant.
    pub constant: Vec<f32>,
}

/// `dx = a · dy + b · (x − mean) + c`, written or added.
pub fn backward_input(
    channels: usize,
    x: &[f32],
    dy: &[f32],
    gradient: &InputGradient,
    dx: &mut [f32],
    accumulate: bool,
) {
    let (a, b) = (&gradient.dy[..channels], &gradient.x[..channels]);
    let (mean, constant) = (&gradient.mean[..channels], &gradient.constant[..channels]);
    let rows = x.chunks_exact(channels).zip(dy.chunks_exact(channels));
    for (dx, (x, dy)) in dx.chunks_exact_mut(channels).zip(rows) {
        for c in 0..channels {
            let value = a[c] * dy[c] + (b[c] * (x[c] - mean[c]) + constant[c]);
            dx[c] = if accumulate { dx[c] + value } else { value };
        }
    }
}

/// Sums in `f32` over short stretches of rows, then in `f64`: near the speed of the one, near the
/// accuracy of the other.
fn accumulate<R>(
    channels: usize,
    sums: &mut [f64],
    rows: impl Iterator<Item = R>,
    value: impl Fn(&R, usize) -> f32,
) {
    const STRETCH: usize = 64;
    let mut partial = vec![0.0f32; channels];
    let mut held = 0;
    let mut flush = |partial: &mut [f32]| {
        for (sum, partial) in sums.iter_mut().zip(partial.iter_mut()) {
            *sum += f64::from(*partial);
            *partial = 0.0;
        }
    };
    for row in rows {
        for (channel, partial) in partial.iter_mut().enumerate() {
            *partial += value(&row, channel);
        }
        held += 1;
        if held == STRETCH {
            flush(&mut partial);
            held = 0;
        }
    }
    flush(&mut partial);
}
