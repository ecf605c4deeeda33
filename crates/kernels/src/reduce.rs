//! Sums over the rows of one image (rows × channels).

use crate::fold::Fold;
use crate::lengths::{exactly, whole_rows};
use crate::rows::{load, store};
use crate::simd::{Simd, at_level};
use crate::view::{AffineView, Rectifier, rectified_gradient};

/// Adds each channel's sum.
pub fn add_columns(channels: usize, x: &[f32], sums: &mut [f32]) {
    whole_rows("rows to add up", x.len(), channels);
    exactly("sums", sums.len(), channels);
    let mut rest = 0;
    if let Some(fold) = Fold::new(channels) {
        rest = fold.whole(x.len());
        let mut wide = fold.zeros();
        columns(fold.channels(), &x[..rest], &mut wide);
        fold.add_up(&wide, sums);
    }
    columns(channels, &x[rest..], sums);
}

at_level! {
    fn columns(channels: usize, x: &[f32], sums: &mut [f32]) = columns_at
}

/// Adds each channel's sum with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn columns_at<S: Simd>(channels: usize, x: &[f32], sums: &mut [f32]) {
    exactly("sums", sums.len(), channels);
    let mut c = 0;
    while c < channels {
        let n = (channels - c).min(S::LANES);
        // SAFETY: `c + n <= channels`: the asserted length of `sums`, and that of every row that
        // `chunks_exact` gives.
        unsafe {
            // Four chains hide the latency of additions.
            let mut part = [S::splat(0.0); 4];
            let mut rows = x.chunks_exact(4 * channels);
            for rows in &mut rows {
                for (i, part) in part.iter_mut().enumerate() {
                    *part = S::add(*part, load::<S>(rows, i * channels + c, n));
                }
            }
            for row in rows.remainder().chunks_exact(channels) {
                part[0] = S::add(part[0], load::<S>(row, c, n));
            }
            let sum = S::add(S::add(part[0], part[1]), S::add(part[2], part[3]));
            store::<S>(sums, c, n, S::add(load::<S>(sums, c, n), sum));
        }
        c += n;
    }
}

/// Adds each channel's sum of squared deviations from `mean`.
pub fn add_squared_deviations(channels: usize, x: &[f32], mean: &[f32], sums: &mut [f32]) {
    whole_rows("rows to add up", x.len(), channels);
    exactly("means", mean.len(), channels);
    exactly("sums", sums.len(), channels);
    let mut rest = 0;
    if let Some(fold) = Fold::new(channels) {
        rest = fold.whole(x.len());
        let mut wide = fold.zeros();
        deviations(fold.channels(), &x[..rest], &fold.repeat(mean), &mut wide);
        fold.add_up(&wide, sums);
    }
    deviations(channels, &x[rest..], mean, sums);
}

at_level! {
    fn deviations(channels: usize, x: &[f32], mean: &[f32], sums: &mut [f32]) = deviations_at
}

/// Adds each channel's sum of squared deviations from `mean` with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn deviations_at<S: Simd>(channels: usize, x: &[f32], mean: &[f32], sums: &mut [f32]) {
    exactly("means", mean.len(), channels);
    exactly("sums", sums.len(), channels);
    let mut c = 0;
    while c < channels {
        let n = (channels - c).min(S::LANES);
        // SAFETY: `c + n <= channels`: the asserted length of `mean` and `sums`, and that of every row that
        // `chunks_exact` gives.
        unsafe {
            let mean = load::<S>(mean, c, n);
            let mut part = [S::splat(0.0); 4];
            let mut rows = x.chunks_exact(4 * channels);
            for rows in &mut rows {
                for (i, part) in part.iter_mut().enumerate() {
                    let d = S::sub(load::<S>(rows, i * channels + c, n), mean);
                    *part = S::fma(d, d, *part);
                }
            }
            for row in rows.remainder().chunks_exact(channels) {
                let d = S::sub(load::<S>(row, c, n), mean);
                part[0] = S::fma(d, d, part[0]);
            }
            let sum = S::add(S::add(part[0], part[1]), S::add(part[2], part[3]));
            store::<S>(sums, c, n, S::add(load::<S>(sums, c, n), sum));
        }
        c += n;
    }
}

/// Returns Σ x · y of two slices of one length.
pub fn dot(x: &[f32], y: &[f32]) -> f32 {
    exactly("second factor of a dot product", y.len(), x.len());
    // Chains of their own, so that the compiler may keep them in a vector.
    const CHAINS: usize = 16;
    let mut sums = [0.0f32; CHAINS];
    let (xs, ys) = (x.chunks_exact(CHAINS), y.chunks_exact(CHAINS));
    let rest: f32 = xs.remainder().iter().zip(ys.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in xs.zip(ys) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f32>() + rest
}

/// Adds each channel's sum of `dy` and of `dy · (x − mean)`, where `dy` counts only where the view of `x`
/// lets a gradient through. The view is that of a batch norm: it has scale and shift.
pub fn add_gradient_sums(
    channels: usize,
    x: &[f32],
    view: &AffineView,
    dy: &[f32],
    mean: &[f32],
    sums: &mut [f32],
    deviation_sums: &mut [f32],
) {
    whole_rows("rows to add up", x.len(), channels);
    exactly("dy of the rows", dy.len(), x.len());
    exactly("means", mean.len(), channels);
    exactly("sums", sums.len(), channels);
    exactly("sums of deviations", deviation_sums.len(), channels);
    #[expect(clippy::expect_used, reason = "only a batch norm's parameters have such sums")]
    let (scale, shift) = view.affine.expect("the view of a batch norm has scale and shift");
    let mut rest = 0;
    if let Some(fold) = Fold::new(channels) {
        rest = fold.whole(x.len());
        let (mut wide, mut deviations) = (fold.zeros(), fold.zeros());
        let (scale, shift, mean) = (fold.repeat(scale), fold.repeat(shift), fold.repeat(mean));
        let (x, dy) = (&x[..rest], &dy[..rest]);
        let (wide_sums, wide_deviations) = (&mut wide, &mut deviations);
        gradient_sums(
            fold.channels(),
            x,
            &scale,
            &shift,
            view.rectifier,
            dy,
            &mean,
            wide_sums,
            wide_deviations,
        );
        fold.add_up(&wide, sums);
        fold.add_up(&deviations, deviation_sums);
    }
    let (x, dy) = (&x[rest..], &dy[rest..]);
    gradient_sums(channels, x, scale, shift, view.rectifier, dy, mean, sums, deviation_sums);
}

at_level! {
    fn gradient_sums(
        channels: usize, x: &[f32], scale: &[f32], shift: &[f32], rectifier: Rectifier, dy: &[f32],
        mean: &[f32], sums: &mut [f32], deviation_sums: &mut [f32],
    ) = gradient_sums_at
}

/// Adds the sums of [`add_gradient_sums`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
unsafe fn gradient_sums_at<S: Simd>(
    channels: usize,
    x: &[f32],
    scale: &[f32],
    shift: &[f32],
    rectifier: Rectifier,
    dy: &[f32],
    mean: &[f32],
    sums: &mut [f32],
    deviation_sums: &mut [f32],
) {
    for len in [scale.len(), shift.len(), mean.len(), sums.len(), deviation_sums.len()] {
        exactly("coefficients and sums", len, channels);
    }
    let mut c = 0;
    while c < channels {
        let n = (channels - c).min(S::LANES);
        // SAFETY: `c + n <= channels`: the asserted length of coefficients and sums, and that of every row
        // that `chunks_exact` gives.
        unsafe {
            let (scale, shift, mean) =
                (load::<S>(scale, c, n), load::<S>(shift, c, n), load::<S>(mean, c, n));
            let (mut plain, mut weighted) = ([S::splat(0.0); 4], [S::splat(0.0); 4]);
            macro_rules! step {
                ($x:expr, $dy:expr, $at:expr, $i:expr) => {
                    let (x, dy) = (load::<S>($x, $at, n), load::<S>($dy, $at, n));
                    let dy = rectified_gradient::<S>(rectifier, S::fma(x, scale, shift), dy);
                    plain[$i] = S::add(plain[$i], dy);
                    weighted[$i] = S::fma(dy, S::sub(x, mean), weighted[$i]);
                };
            }
            let (mut xs, mut dys) = (x.chunks_exact(4 * channels), dy.chunks_exact(4 * channels));
            for (x, dy) in (&mut xs).zip(&mut dys) {
                for i in 0..4 {
                    step!(x, dy, i * channels + c, i);
                }
            }
            let rest = xs.remainder().chunks_exact(channels).zip(dys.remainder().chunks_exact(channels));
            for (x, dy) in rest {
                step!(x, dy, c, 0);
            }
            let plain = S::add(S::add(plain[0], plain[1]), S::add(plain[2], plain[3]));
            let weighted = S::add(S::add(weighted[0], weighted[1]), S::add(weighted[2], weighted[3]));
            store::<S>(sums, c, n, S::add(load::<S>(sums, c, n), plain));
            let before = load::<S>(deviation_sums, c, n);
            store::<S>(deviation_sums, c, n, S::add(before, weighted));
        }
        c += n;
    }
}
