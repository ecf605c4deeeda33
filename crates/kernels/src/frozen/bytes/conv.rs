//! Convolution in bytes between two places.

use std::ops::Range;

use crate::frozen::conv::{ConvRow, lines_of, taps_of};
use crate::frozen::place::{ImagePlace, Route};
use crate::lengths::{at_least, exactly};
use crate::tile::even;
use crate::window::Window3;

use super::dot::Width;
use super::output::{ByteOutput, Ending, Target};
use super::tile::{Kernels, Tile};
use super::{ByteScale, Bytes};

/// Weights, and what becomes of the sums of products with them.
#[derive(Debug, Clone, Copy)]
pub struct Sums<'a> {
    /// In the order of [`crate::conv`]: group × kernel × channels in × channels out; depthwise kernel × channels.
    pub weight: &'a [i8],
    /// One unit of the sums of each filter.
    pub unit: &'a [f32],
    /// One per filter, in those units.
    pub bias: &'a [i32],
    /// How the inputs are written.
    pub input: ByteScale,
    /// How the addend is written, where the route has one.
    pub addend: Option<ByteScale>,
    /// As what the outputs are stored.
    pub output: ByteOutput,
}

/// A convolution with its weights.
pub struct Conv {
    kernels: &'static Kernels,
    to: ImagePlace,
    addend: Option<(ImagePlace, f32, f32)>,
    output: ByteOutput,
    ending: Ending,
    /// Distance of the inputs of neighbouring outputs.
    step: usize,
    /// Fours of bytes in a stretch of inputs.
    fours: usize,
    lines: Vec<ConvRow>,
    panels: Vec<BytePanel>,
    weights: Bytes,
    /// Bytes of the input that are read, at least.
    reach: usize,
}

/// Filters that one kernel computes.
struct BytePanel {
    vectors: usize,
    /// Filters in the last vector.
    last: usize,
    /// First filter of all, and first channel of its group.
    filter: usize,
    channel: usize,
    /// Where its weights start.
    weights: usize,
    /// Of every list of taps: starts in the input and in these weights, and what sums start from.
    segments: Vec<Vec<(usize, usize)>>,
    starts: Vec<Vec<i32>>,
    factors: Vec<f32>,
}

/// Sizes that all panels are packed by.
struct Packing<'a> {
    taps: &'a [Vec<(usize, usize)>],
    /// Inputs of a stretch.
    run: usize,
    channels: usize,
    filters: usize,
    groups: usize,
    volume: usize,
    columns: usize,
}

impl Conv {
    /// Makes a convolution along `route`, whose margins hold the input's zero.
    pub fn new(window: &Window3, dilation: [usize; 3], groups: usize, sums: &Sums, route: Route) -> Self {
        Self::at(Width::widest(), window, dilation, groups, sums, route)
    }

    /// Makes a convolution as [`Conv::new`] does, in another width, which must be one of [`Width::all`].
    pub fn at(
        width: Width,
        window: &Window3,
        dilation: [usize; 3],
        groups: usize,
        sums: &Sums,
        route: Route,
    ) -> Self {
        assert!(Width::all().contains(&width), "a width of this CPU is needed: {width:?}");
        let mut window = *window;
        let Route { mut from, mut to, mut addend, rectifier } = route;
        assert!(window.input == from.size && window.output == to.size, "{window:?}: {from:?} to {to:?}");
        assert!(addend.is_none_or(|a| a.size == to.size && a.channels == to.channels), "{addend:?}: {to:?}");
        assert!(addend.is_some() == sums.addend.is_some(), "an addend is needed with its scale: {addend:?}");
        let lines = (from.line(), to.line(), addend.map_or(Some(None), |a| a.line().map(Some)));
        if let (true, (Some(x), Some(y), Some(a))) = (window.is_identity(), lines) {
            (from, to, addend) = (x, y, a);
            (window.input, window.output) = (x.size, y.size);
        }
        let (channels, filters) = (from.channels / groups, to.channels / groups);
        let volume = window.volume();
        exactly("weights of a convolution", sums.weight.len(), volume * channels * to.channels);
        exactly("bias of a convolution", sums.bias.len(), to.channels);
        exactly("units of a convolution", sums.unit.len(), to.channels);
        let (lines, cuts) = lines_of(&window, dilation, &from, &to, addend.as_ref());
        // Channels of neighbouring columns lie one after the other.
        let whole = groups == 1 && dilation[2] == 1 && from.pitch[2] == channels;
        let (run, steps) =
            if whole { (window.kernel[2] * channels, 1) } else { (channels, window.kernel[2]) };
        let list = |cut: &[Range<usize>; 2]| taps_of(&window, dilation, &from, cut, channels, steps);
        let taps: Vec<Vec<(usize, usize)>> = cuts.iter().map(list).collect();
        let step = window.stride[2] * from.pitch[2];
        let across = (to.size[2].max(1) - 1) * step;
        let fours = run.div_ceil(4);
        let last = |line: &ConvRow| {
            let furthest = taps[line.taps].iter().map(|tap| tap.0 + 4 * fours).max();
            line.from + (groups - 1) * channels + across + furthest.unwrap_or(0)
        };
        let reach = lines.iter().map(last).max().unwrap_or(0);
        let kernels = Kernels::of(width);
        let columns = to.size[2];
        let packing = Packing { taps: &taps, run, channels, filters, groups, volume, columns };
        let (panels, weights) = pack(kernels, &packing, sums);
        let addend = addend
            .zip(sums.addend)
            .map(|(place, scale)| (place, f32::from(scale.zero), sums.output.factor(scale.step)));
        let (output, ending) = (sums.output, sums.output.ending(rectifier));
        Conv { kernels, to, addend, output, ending, step, fours, lines, panels, weights, reach }
    }

    /// Computes `y = rectifier(conv(x) + bias + addend)`, in the output's scale. Up to [`Bytes::SPARE`] bytes are
    /// read behind the last input.
    pub fn run(&self, x: &[u8], addend: Option<&[u8]>, mut y: Target) {
        at_least("input of a frozen convolution", x.len(), self.reach);
        at_least("output of a frozen convolution", y.len(), self.to.end());
        assert!(y.fits(self.output), "memory for {:?} is needed", self.output);
        if let Some((place, ..)) = &self.addend {
            at_least("addend of a frozen convolution", addend.map_or(0, <[u8]>::len), place.end());
        }
        for panel in &self.panels {
            // SAFETY: the three lengths that the plan needs are asserted above; the panels and their weights were made
            // by `at`, which asserts that they fit and that the CPU has the width.
            unsafe { self.run_panel(panel, x, addend.unwrap_or(&[]), &mut y) };
        }
    }

    /// Computes the filters of one panel, at all positions.
    ///
    /// # Safety
    /// `x` holds `reach` bytes, `y` the outputs up to the end of `to`, `addend`, where there is one, those up to its
    /// end; the CPU has the width of the kernels.
    unsafe fn run_panel(&self, panel: &BytePanel, x: &[u8], addend: &[u8], y: &mut Target) {
        let columns = self.to.size[2];
        let most = even(columns, self.kernels.rows(panel.vectors));
        let weights = &self.weights[panel.weights..];
        for line in &self.lines {
            for column in (0..columns).step_by(most) {
                let rows = most.min(columns - column);
                let addend = self.addend.as_ref().map(|(place, zero, factor)| {
                    let at = line.addend + column * place.pitch[2] + panel.filter;
                    (addend[at..].as_ptr(), place.pitch[2], *zero, *factor)
                });
                let tile = Tile {
                    a: x[line.from + column * self.step + panel.channel..].as_ptr(),
                    a_row: self.step,
                    b: weights.as_ptr().cast(),
                    segments: &panel.segments[line.taps],
                    fours: self.fours,
                    start: panel.starts[line.taps].as_ptr(),
                    factor: panel.factors.as_ptr(),
                    addend,
                    ending: self.ending,
                    c: y.at(line.to + column * self.to.pitch[2] + panel.filter),
                    c_row: self.to.pitch[2],
                    last: panel.last,
                };
                // SAFETY: `a` ends at most `rows - 1` steps, the furthest tap and its fours further, which is what
                // `reach` counts for the last group; `b` walks this panel's weights, `start` and `factor` hold all
                // lanes of its vectors; `c` and the addend cover `rows` neighbouring positions of one row and these
                // filters, inside their places; `y` is borrowed exclusively.
                unsafe { self.kernels.kernel(panel.vectors, rows)(&tile) };
            }
        }
    }
}

/// Packs the weights of all groups into panels, one after the other: stretches × fours × vectors × lanes × 4.
fn pack(kernels: &Kernels, packing: &Packing, sums: &Sums) -> (Vec<BytePanel>, Bytes) {
    let &Packing { run, channels, filters, groups, volume, .. } = packing;
    let fours = run.div_ceil(4);
    let stretches = volume * channels / run.max(1);
    let (mut panels, mut len) = (vec![], 0);
    for group in 0..groups {
        let mut filter = 0;
        while filter < filters {
            let left = filters - filter;
            let vectors = kernels.vectors(left, packing.columns);
            let taken = left.min(vectors * kernels.lanes);
            let last = taken - (vectors - 1) * kernels.lanes;
            panels.push(panel(kernels, packing, sums, (group, filter), (vectors, last, len)));
            len += stretches * fours * vectors * kernels.lanes * 4;
            filter += taken;
        }
    }
    let mut packed = Bytes::filled(len, 0);
    for panel in &panels {
        let (group, first) = (panel.filter / filters, panel.filter % filters);
        let weight = &sums.weight[group * volume * channels * filters..][..volume * channels * filters];
        let width = panel.vectors * kernels.lanes;
        for (at, row) in weight.chunks_exact(filters).enumerate() {
            let (stretch, k) = (at / run, at % run);
            let four = panel.weights + (stretch * fours + k / 4) * width * 4;
            for lane in 0..width.min(filters - first) {
                let (vector, lane_in) = (lane / kernels.lanes, lane % kernels.lanes);
                let place = vector * 4 * kernels.lanes + (kernels.place)(lane_in, k % 4);
                packed[four + place] = row[first + lane] as u8;
            }
        }
    }
    (panels, packed)
}

fn panel(
    kernels: &Kernels,
    packing: &Packing,
    sums: &Sums,
    (group, first): (usize, usize),
    (vectors, last, weights): (usize, usize, usize),
) -> BytePanel {
    let &Packing { taps, run, channels, filters, volume, .. } = packing;
    let width = vectors * kernels.lanes;
    let fours = run.div_ceil(4);
    let segments =
        |list: &Vec<(usize, usize)>| list.iter().map(|&(a, k)| (a, k / run * fours * width * 4)).collect();
    let weight = &sums.weight[group * volume * channels * filters..][..volume * channels * filters];
    let zero = i32::from(sums.input.zero) - i32::from(kernels.taken);
    let start = |list: &Vec<(usize, usize)>| {
        let one = |lane: usize| {
            let filter = first + lane;
            if filter >= filters {
                return 0;
            }
            let rows = list.iter().flat_map(|&(_, k)| k..k + run);
            let sum: i32 = rows.map(|k| i32::from(weight[k * filters + filter])).sum();
            sums.bias[group * filters + filter] - zero * sum
        };
        (0..width).map(one).collect()
    };
    let factor = |lane: usize| {
        if first + lane < filters {
            sums.output.factor(sums.unit[group * filters + first + lane])
        } else {
            0.0
        }
    };
    BytePanel {
        vectors,
        last,
        filter: group * filters + first,
        channel: group * channels,
        weights,
        segments: taps.iter().map(segments).collect(),
        starts: taps.iter().map(start).collect(),
        factors: (0..width).map(factor).collect(),
    }
}
