//! Depthwise convolution between two places: vectors run along channels, blocks along columns.

use crate::lengths::{at_least, exactly};
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};
use crate::view::{Rectifier, rectify};
use crate::window::Window3;

use super::conv::{ConvRow, lines_of, taps_of};
use super::place::{ImagePlace, Route};

/// Neighbouring outputs whose sums stay in registers.
const BLOCK: usize = 8;

/// A depthwise convolution with its weights.
pub struct Depthwise {
    to: ImagePlace,
    /// Kernel columns, and distances of neighbouring taps and of the inputs of neighbouring outputs.
    columns: usize,
    tap: usize,
    step: usize,
    lines: Vec<DepthwiseRow>,
    weights: Vec<f32>,
    bias: Vec<f32>,
    rectifier: Rectifier,
    reach: usize,
}

/// A row of outputs.
struct DepthwiseRow {
    to: usize,
    /// Rows of inputs under it, and the first of the weights that each meets.
    rows: Vec<(usize, usize)>,
}

impl Depthwise {
    /// Makes a convolution along `route`, which adds nothing; `weight` lies as kernel × channels. Margins are as in
    /// [`Conv::new`](super::Conv::new).
    pub fn new(window: &Window3, dilation: [usize; 3], weight: &[f32], bias: &[f32], route: Route) -> Self {
        let Route { from, to, addend, rectifier } = route;
        assert!(addend.is_none(), "no addend is needed: {addend:?}");
        let Window3 { output, kernel, stride, .. } = *window;
        assert!(window.input == from.size && output == to.size, "{window:?}: {from:?} to {to:?}");
        assert!(from.channels == to.channels, "as many filters as channels are needed: {from:?} to {to:?}");
        exactly("weights of a convolution", weight.len(), window.volume() * to.channels);
        exactly("bias of a convolution", bias.len(), to.channels);
        let (plain, cuts) = lines_of(window, dilation, &from, &to, None);
        let row_taps = |cut| taps_of(window, dilation, &from, cut, to.channels, 1);
        let taps: Vec<Vec<(usize, usize)>> = cuts.iter().map(row_taps).collect();
        let row = |line: &ConvRow| DepthwiseRow {
            to: line.to,
            rows: taps[line.taps].iter().map(|&(at, weight)| (line.from + at, weight)).collect(),
        };
        let lines: Vec<DepthwiseRow> = plain.iter().map(row).collect();
        let (tap, step) = (dilation[2] * from.pitch[2], stride[2] * from.pitch[2]);
        let width = (output[2].max(1) - 1) * step + (kernel[2] - 1) * tap + from.channels;
        let reach = lines.iter().flat_map(|line| &line.rows).map(|row| row.0 + width).max().unwrap_or(0);
        let (weights, bias) = (weight.to_vec(), bias.to_vec());
        Depthwise { to, columns: kernel[2], tap, step, lines, weights, bias, rectifier, reach }
    }

    /// Computes `y = rectifier(conv(x) + bias)`.
    pub fn run(&self, x: &[f32], y: &mut [f32]) {
        run(self, x, y);
    }
}

at_level! {
    fn run(conv: &Depthwise, x: &[f32], y: &mut [f32]) = run_at
}

/// Computes [`Depthwise::run`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn run_at<S: Simd>(conv: &Depthwise, x: &[f32], y: &mut [f32]) {
    at_least("input of a frozen convolution", x.len(), conv.reach);
    at_least("output of a frozen convolution", y.len(), conv.to.end());
    let ImagePlace { size: [_, _, width], channels, .. } = conv.to;
    for line in &conv.lines {
        vectors!(S, channels, c, n, {
            let mut column = 0;
            // SAFETY: the lengths are asserted above; `c + n <= channels`, and the outputs of a block end with the
            // row.
            unsafe {
                while column + BLOCK <= width {
                    block::<S, BLOCK>(conv, line, column, c, n, x, y);
                    column += BLOCK;
                }
                if column + 4 <= width {
                    block::<S, 4>(conv, line, column, c, n, x, y);
                    column += 4;
                }
                while column < width {
                    block::<S, 1>(conv, line, column, c, n, x, y);
                    column += 1;
                }
            }
        });
    }
}

/// Computes lanes `c..c + n` of `B` outputs from `column` on.
///
/// # Safety
/// The CPU has the features of `S`; `x` holds `reach` values, `y` those up to the end of `to`; `c + n` is at most
/// `channels`, `column + B` at most the width of a row.
#[inline(always)]
unsafe fn block<S: Simd, const B: usize>(
    conv: &Depthwise,
    line: &DepthwiseRow,
    column: usize,
    c: usize,
    n: usize,
    x: &[f32],
    y: &mut [f32],
) {
    // SAFETY: the furthest input of a row is `(B - 1)` steps and all taps behind its first, which `reach` counts for
    // the last column and all channels; weights hold a row of channels per tap, biases one. Outputs lie inside `to`.
    unsafe {
        let mut sums = [load::<S>(&conv.bias, c, n); B];
        for &(from, weights) in &line.rows {
            for tap in 0..conv.columns {
                let w = load::<S>(&conv.weights, weights + tap * conv.to.channels + c, n);
                let at = from + column * conv.step + tap * conv.tap + c;
                for (b, sum) in sums.iter_mut().enumerate() {
                    *sum = S::fma(load::<S>(x, at + b * conv.step, n), w, *sum);
                }
            }
        }
        let at = line.to + column * conv.to.pitch[2] + c;
        for (b, sum) in sums.iter().enumerate() {
            store::<S>(y, at + b * conv.to.pitch[2], n, rectify::<S>(conv.rectifier, *sum));
        }
    }
}
