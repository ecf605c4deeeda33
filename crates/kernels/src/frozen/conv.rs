//! Convolution between two places: bias, addend and rectifier on the way.

use std::ops::Range;

use crate::buffer::Buffer;
use crate::lengths::{at_least, exactly};
use crate::tile::{ColumnBlock, Start, Tile, columns, even, pair_columns};
use crate::view::Rectifier;
use crate::window::Window3;

use super::place::{ImagePlace, Route};

/// A convolution with its weights.
pub struct Conv {
    to: ImagePlace,
    addend: Option<ImagePlace>,
    rectifier: Rectifier,
    /// Distance of the inputs of neighbouring outputs.
    step: usize,
    /// Length of a stretch of inputs that meets one stretch of weights.
    run: usize,
    lines: Vec<ConvRow>,
    panels: Vec<FilterPanel>,
    weights: Buffer,
    bias: Vec<f32>,
    /// Values of the input that are read, at least.
    reach: usize,
}

/// A row of outputs.
pub(super) struct ConvRow {
    pub from: usize,
    pub to: usize,
    pub addend: usize,
    /// Number of its list of taps.
    pub taps: usize,
}

/// Filters that one kernel computes, with their weights in the order in which it reads them.
struct FilterPanel {
    columns: ColumnBlock,
    /// First filter of all.
    filter: usize,
    /// First channel of its group.
    channel: usize,
    /// Where its weights start.
    weights: usize,
    /// Of every list of taps: starts in the input and in these weights.
    segments: Vec<Vec<(usize, usize)>>,
}

impl Conv {
    /// Makes a convolution along `route`.
    ///
    /// `weight` lies as group × kernel × channels in × channels out, as [`crate::conv`] has it; `bias` is one value per
    /// filter. Rows and depths outside the image count as zeros; columns outside are read, so the margins must be as
    /// wide as windows reach.
    pub fn new(
        window: &Window3,
        dilation: [usize; 3],
        groups: usize,
        weight: &[f32],
        bias: &[f32],
        route: Route,
    ) -> Self {
        Self::with(window, dilation, groups, (weight, bias), route, false)
    }

    /// Makes a convolution of pairs of bf16: channels of its input, and weights, are pairs of channels.
    pub(super) fn paired(
        window: &Window3,
        dilation: [usize; 3],
        groups: usize,
        weight: &[f32],
        bias: &[f32],
        route: Route,
    ) -> Self {
        Self::with(window, dilation, groups, (weight, bias), route, true)
    }

    fn with(
        window: &Window3,
        dilation: [usize; 3],
        groups: usize,
        (weight, bias): (&[f32], &[f32]),
        route: Route,
        in_pairs: bool,
    ) -> Self {
        let mut window = *window;
        let Route { mut from, mut to, mut addend, rectifier } = route;
        assert!(window.input == from.size && window.output == to.size, "{window:?}: {from:?} to {to:?}");
        assert!(addend.is_none_or(|a| a.size == to.size && a.channels == to.channels), "{addend:?}: {to:?}");
        let lines = (from.line(), to.line(), addend.map_or(Some(None), |a| a.line().map(Some)));
        if let (true, (Some(x), Some(y), Some(a))) = (window.is_identity(), lines) {
            // One long row makes longer blocks than many short ones.
            (from, to, addend) = (x, y, a);
            (window.input, window.output) = (x.size, y.size);
        }
        let (channels, filters) = (from.channels / groups, to.channels / groups);
        exactly("weights of a convolution", weight.len(), window.volume() * channels * to.channels);
        exactly("bias of a convolution", bias.len(), to.channels);
        let (lines, cuts) = lines_of(&window, dilation, &from, &to, addend.as_ref());
        // Channels of neighbouring columns lie one after the other.
        let whole = groups == 1 && dilation[2] == 1 && from.pitch[2] == channels;
        let (run, steps) =
            if whole { (window.kernel[2] * channels, 1) } else { (channels, window.kernel[2]) };
        let taps: Vec<Vec<(usize, usize)>> =
            cuts.iter().map(|cut| taps_of(&window, dilation, &from, cut, channels, steps)).collect();
        let step = window.stride[2] * from.pitch[2];
        let across = (to.size[2].max(1) - 1) * step;
        let last = |line: &ConvRow| {
            let furthest = taps[line.taps].iter().map(|tap| tap.0 + run).max();
            line.from + (groups - 1) * channels + across + furthest.unwrap_or(0)
        };
        let reach = lines.iter().map(last).max().unwrap_or(0).max(from.end());
        let depth = window.volume() * channels;
        let (panels, weights) = pack(weight, depth, [channels, filters], groups, &taps, in_pairs);
        let bias = bias.to_vec();
        Conv { to, addend, rectifier, step, run, lines, panels, weights, bias, reach }
    }

    /// Computes `y = rectifier(conv(x) + bias + addend)`.
    pub fn run(&self, x: &[f32], addend: Option<&[f32]>, y: &mut [f32]) {
        at_least("input of a frozen convolution", x.len(), self.reach);
        at_least("output of a frozen convolution", y.len(), self.to.end());
        if let Some(place) = &self.addend {
            at_least("addend of a frozen convolution", addend.map_or(0, <[f32]>::len), place.end());
        }
        for panel in &self.panels {
            // SAFETY: the three lengths that the plan needs are asserted above; the panels, their weights and the
            // biases were made by `new`, which asserts that they fit.
            unsafe { self.run_panel(panel, x, addend.unwrap_or(&[]), y) };
        }
    }

    /// Computes the filters of one panel, at all positions.
    ///
    /// # Safety
    /// `x` holds `reach` values, `y` those up to the end of `to`, `addend`, where there is one, those up to its end.
    unsafe fn run_panel(&self, panel: &FilterPanel, x: &[f32], addend: &[f32], y: &mut [f32]) {
        let columns = self.to.size[2];
        let most = even(columns, panel.columns.rows());
        let bias = self.bias[panel.filter..].as_ptr();
        for line in &self.lines {
            for column in (0..columns).step_by(most) {
                let rows = most.min(columns - column);
                let addend = self.addend.as_ref().map(|place| {
                    let at = line.addend + column * place.pitch[2] + panel.filter;
                    (addend[at..].as_ptr(), place.pitch[2])
                });
                let tile = Tile {
                    a: x[line.from + column * self.step + panel.channel..].as_ptr(),
                    a_row: self.step,
                    a_step: 1,
                    b: self.weights[panel.weights..].as_ptr(),
                    b_row: panel.columns.width(),
                    c: y[line.to + column * self.to.pitch[2] + panel.filter..].as_mut_ptr(),
                    c_row: self.to.pitch[2],
                    segments: &panel.segments[line.taps],
                    run: self.run,
                    start: Start::Bias(bias),
                    last: panel.columns.last,
                    addend,
                    rectifier: self.rectifier,
                };
                // SAFETY: `a` ends at most `rows - 1` steps, the furthest tap and a run further, which is what
                // `reach` counts for the last group; `b` walks this panel's weights; `c` and the addend cover `rows`
                // neighbouring positions of one row and these filters, inside their places; `y` is borrowed
                // exclusively.
                unsafe { panel.columns.frozen(rows)(&tile) };
            }
        }
    }
}

/// Returns the number of columns of zeros that windows reach before and after every row.
pub fn margins(window: &Window3, dilation: [usize; 3]) -> [usize; 2] {
    let Window3 { input, output, kernel, stride, before } = *window;
    let reach = (output[2].max(1) - 1) * stride[2] + (kernel[2] - 1) * dilation[2] + 1;
    [before[2], reach.saturating_sub(before[2] + input[2])]
}

/// Returns every row of outputs, and every part of the kernel that lies over the image: depths and rows.
pub(super) fn lines_of(
    window: &Window3,
    dilation: [usize; 3],
    from: &ImagePlace,
    to: &ImagePlace,
    addend: Option<&ImagePlace>,
) -> (Vec<ConvRow>, Vec<[Range<usize>; 2]>) {
    let Window3 { output, before, .. } = *window;
    let needed = margins(window, dilation);
    assert!((0..2).all(|a| needed[a] <= from.margin[a]), "margins of {needed:?} are needed: {from:?}");
    let left = before[2].saturating_mul(from.pitch[2]);
    assert!(left <= from.start, "{left} values are needed before the first: {from:?}");
    let (mut lines, mut cuts) = (vec![], vec![]);
    for d in 0..output[0] {
        for r in 0..output[1] {
            let (depths, first_d) = window.inside_dilated(0, d, dilation[0]);
            let (rows, first_r) = window.inside_dilated(1, r, dilation[1]);
            let cut = [depths, rows];
            let is_empty = cut.iter().any(Range::is_empty);
            let taps = cuts.iter().position(|c| *c == cut).unwrap_or_else(|| {
                cuts.push(cut);
                cuts.len() - 1
            });
            // Without a tap nothing is read; the start need only lie in the buffer.
            let first = if is_empty { [0; 3] } else { [first_d, first_r, 0] };
            lines.push(ConvRow {
                from: from.at(first) - left,
                to: to.at([d, r, 0]),
                addend: addend.map_or(0, |a| a.at([d, r, 0])),
                taps,
            });
        }
    }
    (lines, cuts)
}

/// Returns the stretches of inputs under one cut: start from the line's own, and number of products before it in the
/// kernel.
pub(super) fn taps_of(
    window: &Window3,
    dilation: [usize; 3],
    from: &ImagePlace,
    [depths, rows]: &[Range<usize>; 2],
    channels: usize,
    steps: usize,
) -> Vec<(usize, usize)> {
    let kernel = window.kernel;
    let apart = [0, 1, 2].map(|axis| dilation[axis] * from.pitch[axis]);
    let mut taps = vec![];
    for kd in depths.clone() {
        for kr in rows.clone() {
            for kc in 0..steps {
                let at = (kd - depths.start) * apart[0] + (kr - rows.start) * apart[1] + kc * apart[2];
                taps.push((at, ((kd * kernel[1] + kr) * kernel[2] + kc) * channels));
            }
        }
    }
    taps
}

/// Packs the weights of all groups into panels, one after the other: kernel × channels × filters of the panel.
fn pack(
    weight: &[f32],
    depth: usize,
    [channels, filters]: [usize; 2],
    groups: usize,
    taps: &[Vec<(usize, usize)>],
    in_pairs: bool,
) -> (Vec<FilterPanel>, Buffer) {
    let blocks: Vec<ColumnBlock> =
        if in_pairs { pair_columns(filters).collect() } else { columns(filters).collect() };
    let mut weights = Buffer::zeros(depth * filters * groups);
    let (mut panels, mut at) = (vec![], 0);
    for group in 0..groups {
        let weight = &weight[group * depth * filters..][..depth * filters];
        for &columns in &blocks {
            let width = columns.width();
            for (row, to) in weight.chunks_exact(filters).zip(weights[at..].chunks_exact_mut(width)) {
                to.copy_from_slice(&row[columns.from..][..width]);
            }
            let segments = |list: &Vec<(usize, usize)>| list.iter().map(|&(a, k)| (a, k * width)).collect();
            let segments = taps.iter().map(segments).collect();
            let (filter, channel) = (group * filters + columns.from, group * channels);
            panels.push(FilterPanel { columns, filter, channel, weights: at, segments });
            at += depth * width;
        }
    }
    (panels, weights)
}
