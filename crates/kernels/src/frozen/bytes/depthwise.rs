//! Depthwise convolution in bytes: sums are floats that hold whole numbers.

use std::ops::Range;

use crate::frozen::conv::{ConvRow, lines_of, taps_of};
use crate::frozen::place::{ImagePlace, Route};
use crate::lengths::{at_least, exactly};
use crate::rows::{load, vectors};
use crate::simd::{Simd, at_level};
use crate::window::Window3;

use super::conv::Sums;
use super::map::store_at;
use super::output::{ByteOutput, Ending, Target};

/// Whole numbers below this one are exact in a float, and so are their sums.
pub const EXACT: i32 = 1 << 24;

/// A depthwise convolution with its weights.
pub struct Depthwise {
    to: ImagePlace,
    output: ByteOutput,
    ending: Ending,
    /// Kernel columns, and distances of neighbouring taps and of the inputs of neighbouring outputs.
    columns: usize,
    tap: usize,
    step: usize,
    /// The kernel and the stride, where loaded inputs serve several outputs.
    shared: Option<(usize, usize)>,
    lines: Vec<DepthwiseRow>,
    weights: Vec<f32>,
    /// Of every list of rows: what sums start from.
    starts: Vec<Vec<f32>>,
    factors: Vec<f32>,
    reach: usize,
}

/// A row of outputs.
struct DepthwiseRow {
    to: usize,
    /// Number of what its sums start from.
    start: usize,
    /// Rows of inputs under it, and the first of the weights that each meets.
    rows: Vec<(usize, usize)>,
}

impl Depthwise {
    /// Makes a convolution along `route`, which adds nothing. No sum may reach [`EXACT`].
    pub fn new(window: &Window3, dilation: [usize; 3], sums: &Sums, route: Route) -> Self {
        let Route { from, to, addend, rectifier } = route;
        assert!(addend.is_none() && sums.addend.is_none(), "no addend is needed: {addend:?}");
        let Window3 { output, kernel, stride, .. } = *window;
        assert!(window.input == from.size && output == to.size, "{window:?}: {from:?} to {to:?}");
        assert!(from.channels == to.channels, "as many filters as channels are needed: {from:?} to {to:?}");
        let channels = to.channels;
        exactly("weights of a convolution", sums.weight.len(), window.volume() * channels);
        exactly("bias of a convolution", sums.bias.len(), channels);
        exactly("units of a convolution", sums.unit.len(), channels);
        let (plain, cuts) = lines_of(window, dilation, &from, &to, None);
        let row_taps = |cut| taps_of(window, dilation, &from, cut, channels, 1);
        let taps: Vec<Vec<(usize, usize)>> = cuts.iter().map(row_taps).collect();
        let row = |line: &ConvRow| DepthwiseRow {
            to: line.to,
            start: line.taps,
            rows: taps[line.taps].iter().map(|&(at, weight)| (line.from + at, weight)).collect(),
        };
        let lines: Vec<DepthwiseRow> = plain.iter().map(row).collect();
        let starts = cuts.iter().map(|cut| starts(window, cut, sums)).collect();
        let (tap, step) = (dilation[2] * from.pitch[2], stride[2] * from.pitch[2]);
        let width = (output[2].max(1) - 1) * step + (kernel[2] - 1) * tap + channels;
        let reach = lines.iter().flat_map(|line| &line.rows).map(|row| row.0 + width).max().unwrap_or(0);
        let is_shared = kernel[2] == 3 && dilation[2] == 1 && (1..=2).contains(&stride[2]);
        Depthwise {
            to,
            output: sums.output,
            ending: sums.output.ending(rectifier),
            columns: kernel[2],
            tap,
            step,
            shared: is_shared.then_some((3, stride[2])),
            lines,
            weights: sums.weight.iter().map(|&w| f32::from(w)).collect(),
            starts,
            factors: sums.unit.iter().map(|&u| sums.output.factor(u)).collect(),
            reach,
        }
    }

    /// Computes `y = rectifier(conv(x) + bias)`, in the output's scale.
    pub fn run(&self, x: &[u8], mut y: Target) {
        run(self, x, &mut y);
    }
}

/// Returns the start of each channel's sums, where this much of the kernel lies over the image: depths and rows.
fn starts(window: &Window3, [depths, rows]: &[Range<usize>; 2], sums: &Sums) -> Vec<f32> {
    let [_, kernel_rows, columns] = window.kernel;
    let channels = sums.bias.len();
    let start = |c: usize| {
        let (mut all, mut most) = (0i32, 0i32);
        for depth in depths.clone() {
            for row in rows.clone() {
                let first = (depth * kernel_rows + row) * columns;
                for k in first..first + columns {
                    let weight = i32::from(sums.weight[k * channels + c]);
                    (all, most) = (all + weight, most + 255 * weight.abs());
                }
            }
        }
        let start = sums.bias[c] - i32::from(sums.input.zero) * all;
        assert!(start.abs() + most < EXACT, "smaller sums are needed: {start} and {most}");
        start as f32
    };
    (0..channels).map(start).collect()
}

at_level! {
    fn run(conv: &Depthwise, x: &[u8], y: &mut Target) = run_at
}

/// Computes [`Depthwise::run`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn run_at<S: Simd>(conv: &Depthwise, x: &[u8], y: &mut Target) {
    at_least("input of a frozen convolution", x.len(), conv.reach);
    at_least("output of a frozen convolution", y.len(), conv.to.end());
    assert!(y.fits(conv.output), "memory for {:?} is needed", conv.output);
    let ImagePlace { size: [_, _, width], channels, .. } = conv.to;
    for line in &conv.lines {
        vectors!(S, channels, c, n, {
            let mut column = 0;
            // SAFETY: the lengths are asserted above; `c + n <= channels`, and the outputs of a block end with the
            // row.
            unsafe {
                while column < width {
                    let left = width - column;
                    column += match conv.shared {
                        Some((3, 1)) if left >= 8 && S::LANES == 16 => {
                            block_of_three::<S, 8, 10, 1>(conv, line, column, (c, n), x, y)
                        }
                        Some((3, 1)) if left >= 4 => {
                            block_of_three::<S, 4, 6, 1>(conv, line, column, (c, n), x, y)
                        }
                        Some((3, 2)) if left >= 4 => {
                            block_of_three::<S, 4, 9, 2>(conv, line, column, (c, n), x, y)
                        }
                        None if left >= 4 => block::<S, 4>(conv, line, column, (c, n), x, y),
                        _ => block::<S, 1>(conv, line, column, (c, n), x, y),
                    };
                }
            }
        });
    }
}

/// Computes lanes `c..c + n` of `B` outputs from `column` on; returns `B`.
///
/// # Safety
/// The CPU has the features of `S`; `x` holds `reach` bytes, `y` the values up to the end of `to`; `c + n` is at most
/// `channels`, `column + B` at most the width of a row.
#[inline(always)]
unsafe fn block<S: Simd, const B: usize>(
    conv: &Depthwise,
    line: &DepthwiseRow,
    column: usize,
    (c, n): (usize, usize),
    x: &[u8],
    y: &mut Target,
) -> usize {
    // SAFETY: the furthest input of a row is `(B - 1)` steps and all taps behind its first, which `reach` counts for
    // the last column and all channels; weights hold a row of channels per tap, starts one. Outputs lie inside `to`.
    unsafe {
        let mut sums = [load::<S>(&conv.starts[line.start], c, n); B];
        for &(from, weights) in &line.rows {
            for tap in 0..conv.columns {
                let w = load::<S>(&conv.weights, weights + tap * conv.to.channels + c, n);
                let at = x.as_ptr().add(from + column * conv.step + tap * conv.tap + c);
                for (b, sum) in sums.iter_mut().enumerate() {
                    *sum = S::fma(S::load_bytes(at.add(b * conv.step), n), w, *sum);
                }
            }
        }
        end::<S, B>(conv, line, column, (c, n), &sums, y);
    }
    B
}

/// Computes the same as [`block`] for three taps side by side: every input is read once for all outputs that it
/// meets. `X` are the inputs of a row, `T` is the stride.
///
/// # Safety
/// As [`block`].
#[inline(always)]
unsafe fn block_of_three<S: Simd, const B: usize, const X: usize, const T: usize>(
    conv: &Depthwise,
    line: &DepthwiseRow,
    column: usize,
    (c, n): (usize, usize),
    x: &[u8],
    y: &mut Target,
) -> usize {
    const { assert!(X == (B - 1) * T + 3) };
    // SAFETY: as in `block`.
    unsafe {
        let mut sums = [load::<S>(&conv.starts[line.start], c, n); B];
        let channels = conv.to.channels;
        for &(from, weights) in &line.rows {
            let at = x.as_ptr().add(from + column * conv.step + c);
            let mut row = [S::splat(0.0); X];
            for (i, value) in row.iter_mut().enumerate() {
                *value = S::load_bytes(at.add(i * conv.tap), n);
            }
            for tap in 0..3 {
                let w = load::<S>(&conv.weights, weights + tap * channels + c, n);
                for (b, sum) in sums.iter_mut().enumerate() {
                    *sum = S::fma(row[b * T + tap], w, *sum);
                }
            }
        }
        end::<S, B>(conv, line, column, (c, n), &sums, y);
    }
    B
}

/// Stores the sums of `B` outputs, times the factor of each channel.
///
/// # Safety
/// As [`block`].
#[inline(always)]
unsafe fn end<S: Simd, const B: usize>(
    conv: &Depthwise,
    line: &DepthwiseRow,
    column: usize,
    (c, n): (usize, usize),
    sums: &[S::V; B],
    y: &mut Target,
) {
    // SAFETY: outputs lie inside `to`; factors are one per channel.
    unsafe {
        let factor = load::<S>(&conv.factors, c, n);
        let at = line.to + column * conv.to.pitch[2] + c;
        for (b, sum) in sums.iter().enumerate() {
            let value = S::mul(*sum, factor);
            store_at::<S>(y, at + b * conv.to.pitch[2], n, value, &conv.ending);
        }
    }
}
