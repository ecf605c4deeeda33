//! MiniRocket's features: convolutions as sums, comparisons with thresholds, shares of time.

use std::ops::Range;

use super::sink::{Sink, int, ints};
use crate::proto::dtype;

/// Length of a kernel.
const TAPS: usize = 9;

/// A convolution of −1 at nine places, 2 at three of them, over some channels; zeros beyond the ends.
#[derive(Debug, Clone, PartialEq)]
pub struct RocketConv {
    /// Distance of neighbouring places.
    pub dilation: usize,
    /// Places of weight 2, each below 9.
    pub twos: [usize; 3],
    /// Channels that are read.
    pub channels: Vec<usize>,
    /// Thresholds.
    pub biases: Vec<f32>,
    /// Positions that are counted.
    pub counted: Range<usize>,
}

/// MiniRocket's features of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct RocketFeatures {
    /// Convolutions with their thresholds, in the order of the features.
    pub convolutions: Vec<RocketConv>,
    /// Whether the last step of each channel and the mean of each follow.
    pub levels: bool,
}

impl RocketFeatures {
    /// Returns the number of features of so many channels; none where the convolutions do not fit the series.
    pub(super) fn width(&self, [channels, length]: [usize; 2]) -> Option<usize> {
        let fits = |conv: &RocketConv| {
            conv.channels.iter().all(|channel| *channel < channels)
                && conv.twos.iter().all(|place| *place < TAPS)
                && conv.counted.start < conv.counted.end
                && conv.counted.end <= length
                && (TAPS - 1) * conv.dilation < length
        };
        let shares: usize = self.convolutions.iter().map(|conv| conv.biases.len()).sum();
        let is_whole = !self.convolutions.is_empty() && self.convolutions.iter().all(fits);
        is_whole.then_some(shares + if self.levels { 2 * channels } else { 0 })
    }

    /// Writes the features `[batch, features]` of `value` `[batch, channels, length]`.
    pub(super) fn emit(
        &self,
        sink: &mut Sink,
        name: &str,
        value: &str,
        [channels, length]: [usize; 2],
    ) -> String {
        let base = |part: &str| format!("{name}/rocket/{part}");
        let mut parts = vec![];
        // Neighbours of one dilation and as many thresholds are convolved together.
        let alike =
            |a: &RocketConv, b: &RocketConv| (a.dilation, a.biases.len()) == (b.dilation, b.biases.len());
        for group in self.convolutions.chunk_by(alike).filter(|group| !group[0].biases.is_empty()) {
            parts.push(shares(sink, &base("dilation"), value, group, length));
        }
        if self.levels {
            let last = sink.ints(&base("last_step"), &[length as i64 - 1]);
            let last = sink.step("Gather", &[value, &last], &base("last"), vec![int("axis", 2)]);
            let flat = sink.ints(&base("flat"), &[0, channels as i64]);
            parts.push(sink.step("Reshape", &[&last, &flat], &base("ends"), vec![]));
            let over = vec![ints("axes", vec![2]), int("keepdims", 0)];
            parts.push(sink.step("ReduceMean", &[value], &base("means"), over));
        }
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        sink.step("Concat", &parts, &format!("{name}/rocket"), vec![int("axis", 1)])
    }
}

/// Writes the features of convolutions of one dilation and as many thresholds each.
fn shares(sink: &mut Sink, base: &str, value: &str, group: &[RocketConv], length: usize) -> String {
    let part = |part: &str| format!("{base}/{part}");
    let (kernels, count) = (group.len(), group[0].biases.len());
    let mut counted = vec![0.0; kernels * length];
    for (kernel, conv) in group.iter().enumerate() {
        counted[kernel * length..][conv.counted.clone()].fill(1.0);
    }
    let convolved = convolved(sink, base, value, group, length);
    let axis = sink.ints(&part("axis"), &[2]);
    let beside = sink.step("Unsqueeze", &[&convolved, &axis], &part("beside"), vec![]);
    let biases: Vec<f32> = group.iter().flat_map(|conv| conv.biases.iter().copied()).collect();
    let biases = sink.floats(&part("thresholds"), &[1, kernels, count, 1], &biases);
    let above = sink.step("Greater", &[&beside, &biases], &part("above"), vec![]);
    let ones = sink.step("Cast", &[&above], &part("ones"), vec![int("to", i64::from(dtype::FLOAT))]);
    let mask = sink.floats(&part("counted"), &[1, kernels, 1, length], &counted);
    let inside = sink.step("Mul", &[&ones, &mask], &part("inside"), vec![]);
    let time = sink.ints(&part("time"), &[3]);
    let sums = sink.step("ReduceSum", &[&inside, &time], &part("sums"), vec![int("keepdims", 0)]);
    let positions: Vec<f32> = group.iter().map(|conv| conv.counted.len() as f32).collect();
    let positions = sink.floats(&part("positions"), &[1, kernels, 1], &positions);
    let shares = sink.step("Div", &[&sums, &positions], &part("shares"), vec![]);
    let flat = sink.ints(&part("flat"), &[0, (kernels * count) as i64]);
    sink.step("Reshape", &[&shares, &flat], base, vec![])
}

/// Writes the convolutions `[batch, kernels, length]` as sums in taxel's order: channel after channel, tap after tap. The
/// weights 2 and −1 are exact, so that every runtime finds the same values. Its own convolutions may add in another order,
/// and many values lie at a threshold.
fn convolved(sink: &mut Sink, base: &str, value: &str, group: &[RocketConv], length: usize) -> String {
    let part = |part: &str| format!("{base}/{part}");
    let (kernels, dilation) = (group.len(), group[0].dilation);
    let pad = (TAPS / 2 * dilation) as i64;
    let pads = sink.ints(&part("pads"), &[0, 0, pad, 0, 0, pad]);
    let padded = sink.step("Pad", &[value, &pads], &part("padded"), vec![]);
    let time = sink.ints(&part("axis"), &[2]);
    let bounds: Vec<[String; 2]> = (0..TAPS)
        .map(|tap| {
            [tap * dilation, tap * dilation + length].map(|at| sink.ints(&part("bounds"), &[at as i64]))
        })
        .collect();
    let most = group.iter().map(|conv| conv.channels.len()).max().unwrap_or(0);
    let mut sum: Option<String> = None;
    for place in 0..most {
        let channels: Vec<i64> =
            group.iter().map(|conv| conv.channels.get(place).map_or(0, |channel| *channel as i64)).collect();
        let channels = sink.ints(&part("channels"), &channels);
        let read = sink.step("Gather", &[&padded, &channels], &part("read"), vec![int("axis", 1)]);
        for (tap, [from, to]) in bounds.iter().enumerate() {
            let weight = |conv: &RocketConv| match conv.channels.get(place) {
                None => 0.0,
                Some(_) if conv.twos.contains(&tap) => 2.0,
                Some(_) => -1.0,
            };
            let weight: Vec<f32> = group.iter().map(weight).collect();
            let weight = sink.floats(&part("weight"), &[1, kernels, 1], &weight);
            let seen = sink.step("Slice", &[&read, from, to, &time], &part("seen"), vec![]);
            let term = sink.step("Mul", &[&seen, &weight], &part("term"), vec![]);
            sum = Some(match sum {
                None => term,
                Some(before) => sink.step("Add", &[&before, &term], &part("sum"), vec![]),
            });
        }
    }
    sum.unwrap_or(padded)
}
