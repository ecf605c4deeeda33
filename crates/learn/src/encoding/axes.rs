//! The axes that each input takes, and what is said of others.

use ndarray::{ArrayD, ArrayView, ArrayViewD, Axis, Dimension};
use taxel_base::Layout;
use taxel_encodings::Reduction;

use super::names::{IMAGE, ROCKET, SERIES, SIGNAL, TENSOR};
use crate::error::{Error, Result};

pub(super) fn refused(source: &str, input: &'static str, error: taxel_encodings::Error) -> Error {
    Error::Encoding { source_label: source.into(), input, source: error }
}

/// Makes the refusal of samples of `shape`, the axis of samples left out.
pub(super) fn wrong_axes(shape: &[usize], input: &'static str, source: &str) -> Error {
    let shape = shape.to_vec();
    let reason = match input {
        SIGNAL => "a signal is [N, C, T], [N, F] or [N, fingers, C, T]",
        ROCKET => "MiniRocket's features are made of [N, C, T], [N, T] or [N, fingers, C, T]",
        SERIES => "its axes are not those of its layout",
        TENSOR => "a tactile tensor is made of squeezes [N, T, H, W]",
        _ => {
            "a field and rows are made of [N, C, T]; samples that are images need encoding.image.kind = \"raw\" and \
              [N, H, W] or [N, C, H, W], squeezes \"frame\" and [N, T, H, W], NumaTac bits \"numatac\""
        }
    };
    Error::Axes { source_label: source.into(), input, shape, reason }
}

/// Returns samples `[N, ..]` as an array of so many axes.
///
/// # Errors
/// Samples with other axes.
pub(super) fn with_axes<'a, D: Dimension>(
    x: ArrayViewD<'a, f32>,
    input: &'static str,
    source: &str,
) -> Result<ArrayView<'a, f32, D>> {
    let shape = x.raw_dim();
    x.into_dimensionality().map_err(|_| wrong_axes(of_sample(shape.slice()), input, source))
}

/// Returns the shape of one of the samples of an array.
pub(super) fn of_sample(shape: &[usize]) -> &[usize] {
    shape.get(1..).unwrap_or_default()
}

pub(super) fn signal_axes(x: ArrayD<f32>, input: &'static str, source: &str) -> Result<ArrayD<f32>> {
    match x.ndim() {
        2 => Ok(x.insert_axis(Axis(1))),
        3 => Ok(x),
        _ => Err(wrong_axes(of_sample(x.shape()), input, source)),
    }
}

pub(super) fn image_axes(x: ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
    match x.ndim() {
        3 => Ok(x.insert_axis(Axis(1))),
        4 => Ok(x),
        _ => Err(wrong_axes(of_sample(x.shape()), IMAGE, source)),
    }
}

/// Turns samples into recordings `[N, channels, length]`: rows of an image and taxels of a frame become channels.
///
/// Images `[H, W]` are H channels, colour images `[3, H, W]` 3·H, squeezes `[T, H, W]` H·W channels of length
/// T, fingers `[fingers, channels, ticks]` fingers · channels of length `ticks`.
pub(super) fn series(x: &ArrayD<f32>, layout: Layout, source: &str) -> Result<ArrayD<f32>> {
    let shape = match (layout, x.shape()) {
        (Layout::Features, &[n, length]) => [n, 1, length],
        (Layout::Series | Layout::Image, &[n, channels, length]) => [n, channels, length],
        (Layout::Colour | Layout::Fingers, &[n, a, b, length]) => [n, a * b, length],
        (Layout::Sequence, &[n, frames, rows, columns]) => [n, rows * columns, frames],
        _ => return Err(wrong_axes(of_sample(x.shape()), SERIES, source)),
    };
    let x = x.view();
    let x = if layout == Layout::Sequence { x.permuted_axes(vec![0, 2, 3, 1]) } else { x };
    let values: Vec<f32> = x.iter().copied().collect();
    #[expect(clippy::expect_used, reason = "an axis split or joined keeps the number of values")]
    Ok(ArrayD::from_shape_vec(shape.to_vec(), values).expect("as many values as before"))
}

/// Takes the mean of the first `readings` off each channel of samples `[N, C, T]`.
///
/// # Errors
/// Samples with other axes, or with fewer readings.
pub(super) fn less_baseline(mut x: ArrayD<f32>, readings: usize, source: &str) -> Result<ArrayD<f32>> {
    let length = x.shape().last().copied().unwrap_or(0);
    if x.ndim() != 3 || length < readings {
        let reason = "encoding.baseline needs [N, C, T] with at least as many readings";
        let shape = of_sample(x.shape()).to_vec();
        return Err(Error::Axes { source_label: source.into(), input: SIGNAL, shape, reason });
    }
    for mut series in x.lanes_mut(Axis(2)) {
        let sum: f64 = series.iter().take(readings).map(|&v| f64::from(v)).sum();
        let mean = (sum / readings as f64) as f32;
        series.mapv_inplace(|v| v - mean);
    }
    Ok(x)
}

/// Applies a reduction to samples `[N, ..]` of a layout.
///
/// # Errors
/// A reduction without a meaning for such samples.
pub(super) fn reduced(
    x: &ArrayD<f32>,
    layout: Layout,
    reduction: &Reduction,
) -> taxel_encodings::Result<ArrayD<f32>> {
    let plan = reduction.plan(layout, of_sample(x.shape()))?;
    let mut left = ArrayD::zeros([&[x.len_of(Axis(0))], plan.shape()].concat());
    for (sample, mut to) in x.outer_iter().zip(left.outer_iter_mut()) {
        let sample = sample.as_standard_layout();
        if let (Some(sample), Some(to)) = (sample.as_slice(), to.as_slice_mut()) {
            plan.apply(sample, to)?;
        }
    }
    Ok(left)
}
