//! The output that says how unlike those of the training the readings of a sample are.

use super::gate::transposed;
use super::sink::{Sink, int, ints, sizes};
use super::value::info;
use crate::proto::{Attribute, ValueInfo};

/// Name of the output: the Mahalanobis distance `[batch]` of the numbers that summarise a raw sample.
pub const READINGS_DISTANCE: &str = "readings_distance";
/// Key of the fact that says, by the name of an output, the distance beyond which a sample is unknown at 0.05: an object of JSON. One output
/// beyond its own is enough.
pub const UNKNOWN_BEYOND: &str = "taxel.unknown_beyond";

/// The gate of readings: the axes of a sample, and where the numbers of known samples lie.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingsPlace {
    /// Channels of a sample; of still images rows.
    pub channels: usize,
    /// Steps of a channel; of still images columns.
    pub steps: usize,
    /// Whether steps come before channels in memory, as in a sequence of frames.
    pub steps_first: bool,
    /// Whether steps follow each other in time.
    pub has_time: bool,
    /// Number that is added to deviations before their logarithm is taken.
    pub floor: f32,
    /// Mean of each number.
    pub center: Vec<f32>,
    /// Lower triangle of the matrix that brings deviations from the center to variance 1, row by row.
    pub around: Vec<f32>,
}

/// Nodes of the gate.
struct Builder<'s> {
    sink: &'s mut Sink,
    floor: String,
}

impl Builder<'_> {
    fn step(&mut self, op: &str, inputs: &[&str], part: &str, attributes: Vec<Attribute>) -> String {
        self.sink.step(op, inputs, &format!("{READINGS_DISTANCE}/{part}"), attributes)
    }

    /// Reduces one axis.
    fn over(&mut self, op: &str, x: &str, axis: i64, keeps: bool) -> String {
        self.step(op, &[x], op, vec![ints("axes", vec![axis]), int("keepdims", i64::from(keeps))])
    }

    /// Returns the mean square over one axis.
    fn mean_square(&mut self, x: &str, axis: i64, keeps: bool) -> String {
        let square = self.step("Mul", &[x, x], "square", vec![]);
        self.over("ReduceMean", &square, axis, keeps)
    }

    fn root(&mut self, x: &str) -> String {
        self.step("Sqrt", &[x], "root", vec![])
    }

    fn log(&mut self, x: &str) -> String {
        let floor = self.floor.clone();
        let above = self.step("Add", &[x, &floor], "above", vec![]);
        self.step("Log", &[&above], "logarithm", vec![])
    }

    /// Returns the differences of neighbours along an axis of that size.
    fn differences(&mut self, x: &str, axis: i64, size: usize) -> String {
        let mut part = |from: i64, to: i64| {
            let [from, to, axis] =
                [from, to, axis].map(|at| self.sink.ints(&format!("{READINGS_DISTANCE}/at"), &[at]));
            self.step("Slice", &[x, &from, &to, &axis], "part", vec![])
        };
        let (next, before) = (part(1, size as i64), part(0, size as i64 - 1));
        self.step("Sub", &[&next, &before], "differences", vec![])
    }
}

impl ReadingsPlace {
    /// Brings raw samples to `[batch, channels, steps]`.
    fn by_channel(&self, to: &mut Builder, x: &str) -> String {
        let shape = if self.steps_first { [self.steps, self.channels] } else { [self.channels, self.steps] };
        let shape = to.sink.ints(&format!("{READINGS_DISTANCE}/shape"), &[&[0], &sizes(&shape)[..]].concat());
        let x = to.step("Reshape", &[x, &shape], "channels", vec![]);
        if self.steps_first {
            to.step("Transpose", &[&x], "by_channel", vec![ints("perm", vec![0, 2, 1])])
        } else {
            x
        }
    }

    /// Adds the numbers that summarise raw samples `[batch, ..]` and returns their names, each `[batch, 1]`, or
    /// `[batch, channels]` for those of single channels.
    fn numbers(&self, sink: &mut Sink, x: &str) -> Vec<String> {
        let name = |part: &str| format!("{READINGS_DISTANCE}/{part}");
        let floor = sink.floats(&name("floor"), &[], &[self.floor]);
        let mut to = Builder { sink, floor };
        let x = self.by_channel(&mut to, x);
        let means = to.over("ReduceMean", &x, 2, true);
        let off = to.step("Sub", &[&x, &means], "off", vec![]);
        let variance = to.mean_square(&off, 2, false);
        let spreads = to.root(&variance);
        let means = to.over("ReduceMean", &x, 2, false);
        let changes = if self.steps > 1 {
            let differences = to.differences(&x, 2, self.steps);
            let squares = to.mean_square(&differences, 2, false);
            to.root(&squares)
        } else {
            to.step("Sub", &[&means, &means], "none", vec![])
        };
        let mean = to.over("ReduceMean", &means, 1, true);
        let apart = to.step("Sub", &[&means, &mean], "apart", vec![]);
        let between = to.mean_square(&apart, 1, true);
        let inside = to.over("ReduceMean", &variance, 1, true);
        let whole = to.step("Add", &[&inside, &between], "whole", vec![]);
        let [within, change] = [&spreads, &changes].map(|all| to.over("ReduceMean", all, 1, true));
        let spread = to.root(&whole);
        let spread = to.log(&spread);
        let [low, high] = ["ReduceMin", "ReduceMax"].map(|op| {
            let of_channels = to.over(op, &x, 2, false);
            to.over(op, &of_channels, 1, true)
        });
        let mut numbers = if self.has_time {
            let (within, change) = (to.log(&within), to.log(&change));
            let rough = to.step("Sub", &[&change, &within], "rough", vec![]);
            let between = to.root(&between);
            let ends = [
                (&spreads, "ReduceMin"),
                (&spreads, "ReduceMax"),
                (&means, "ReduceMin"),
                (&means, "ReduceMax"),
            ];
            let ends = ends.map(|(all, op)| to.over(op, all, 1, true));
            [&[mean, spread, within, change, rough, low, high, between][..], &ends].concat()
        } else {
            let across = if self.channels > 1 {
                let differences = to.differences(&x, 1, self.channels);
                let squares = to.mean_square(&differences, 2, false);
                let squares = to.over("ReduceMean", &squares, 1, true);
                to.root(&squares)
            } else {
                to.step("Sub", &[&mean, &mean], "none", vec![])
            };
            let both = to.step("Add", &[&change, &across], "both", vec![]);
            let both = to.log(&both);
            let rough = to.step("Sub", &[&both, &spread], "rough", vec![]);
            let [change, across, within] = [&change, &across, &within].map(|number| to.log(number));
            vec![mean, spread, change, across, rough, within, low, high]
        };
        numbers.extend(self.of_single(&mut to, &x, means, numbers.len()));
        numbers
    }

    /// Returns the numbers after the `shared` ones: the `means` of single channels, or features. None where there are no more.
    fn of_single(&self, to: &mut Builder, x: &str, means: String, shared: usize) -> Option<String> {
        match self.center.len() - shared {
            0 => None,
            single if single == self.channels => Some(means),
            _ => {
                let shape = to.sink.ints(&format!("{READINGS_DISTANCE}/row"), &[0, -1]);
                Some(to.step("Reshape", &[x, &shape], "features", vec![]))
            }
        }
    }

    /// Adds the output of the distance of raw samples `[batch, ..]`; none where the name is taken.
    pub(super) fn emit(&self, x: &str, sink: &mut Sink) -> Option<ValueInfo> {
        if !sink.take(READINGS_DISTANCE) {
            return None;
        }
        let numbers = self.numbers(sink, x);
        let name = |part: &str| format!("{READINGS_DISTANCE}/{part}");
        let size = self.center.len();
        let numbers: Vec<&str> = numbers.iter().map(String::as_str).collect();
        let numbers = sink.step("Concat", &numbers, &name("numbers"), vec![int("axis", 1)]);
        let center = sink.floats(&name("center"), &[size], &self.center);
        let off = sink.step("Sub", &[&numbers, &center], &name("off"), vec![]);
        let matrix = sink.floats(&name("around"), &[size, size], &transposed(&self.around, size));
        let whitened = sink.step("MatMul", &[&off, &matrix], &name("whitened"), vec![]);
        let axes = vec![ints("axes", vec![1]), int("keepdims", 0)];
        let square = sink.step("ReduceSumSquare", &[&whitened], &name("square"), axes);
        let share = sink.floats(&name("share"), &[], &[1.0 / size as f32]);
        let mean = sink.step("Mul", &[&square, &share], &name("mean"), vec![]);
        sink.put("Sqrt", &[&mean], READINGS_DISTANCE, vec![]);
        Some(info(READINGS_DISTANCE, &[], None))
    }
}
