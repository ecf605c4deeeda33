//! The quantile code of series: ramps between the quantiles of each channel's views, and z-scores.

use super::sink::{Sink, int};

/// Readings of the level of a channel.
const WINDOW: usize = 5;
/// Largest absolute value of a z-score.
const LARGEST_SCORE: f32 = 8.0;

/// The values that are fitted to one view of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct CodeRow {
    /// Mean of the training values.
    pub mean: f32,
    /// Standard deviation, above 0.
    pub sd: f32,
    /// Ends of the ramps, ascending.
    pub edges: Vec<f32>,
}

/// A quantile code: four views of each channel, ramps of each view, steps in time that come out.
#[derive(Debug, Clone, PartialEq)]
pub struct Code {
    /// Four of each channel: readings, change, level, drift.
    pub rows: Vec<CodeRow>,
    /// Ramps of each view; those that it does not need are 0.
    pub ramps: usize,
    /// Steps in time that come out, each the mean of as many readings but for the last.
    pub steps: usize,
}

impl Code {
    /// Returns rows and steps of the code of samples of so many channels; none where it is not theirs.
    pub(super) fn shape(&self, [channels, length]: [usize; 2]) -> Option<[usize; 2]> {
        let fits = self.rows.len() == 4 * channels
            && (1..=length).contains(&self.steps)
            && self.rows.iter().all(|row| row.edges.len() <= self.ramps + 1);
        fits.then_some([self.rows.len() * (self.ramps + 1), self.steps])
    }

    /// Writes the code `[batch, rows, steps]` of `value` `[batch, channels, length]`.
    pub(super) fn emit(&self, sink: &mut Sink, name: &str, value: &str, length: usize) -> String {
        let base = |part: &str| format!("{name}/code/{part}");
        let views = self.views(sink, name, value, length);
        let count = self.rows.len();
        // Beside each other: batch × views × ramps × time.
        let apart = sink.ints(&base("apart"), &[0, count as i64, 1, length as i64]);
        let views = sink.step("Reshape", &[&views, &apart], &base("views"), vec![]);
        let (mut low, mut factor) = (vec![0.0; count * self.ramps], vec![0.0; count * self.ramps]);
        for (view, row) in self.rows.iter().enumerate() {
            for (ramp, pair) in row.edges.windows(2).enumerate() {
                low[view * self.ramps + ramp] = pair[0];
                factor[view * self.ramps + ramp] = 1.0 / (pair[1] - pair[0]);
            }
        }
        let ramps = self.lines(sink, &base("ramp"), &views, (self.ramps, &low, &factor), [0.0, 1.0], length);
        let mean: Vec<f32> = self.rows.iter().map(|row| row.mean).collect();
        let inverse: Vec<f32> = self.rows.iter().map(|row| 1.0 / row.sd).collect();
        let ends = [-LARGEST_SCORE, LARGEST_SCORE];
        let scores = self.lines(sink, &base("score"), &views, (1, &mean, &inverse), ends, length);
        sink.step("Concat", &[&ramps, &scores], &format!("{name}/code"), vec![int("axis", 1)])
    }

    /// Writes the four views of each channel, `[batch, channels, 4 × length]`.
    fn views(&self, sink: &mut Sink, name: &str, value: &str, length: usize) -> String {
        let base = |part: &str| format!("{name}/code/{part}");
        let moved = |sink: &mut Sink, from: &str, part: &str, at: &dyn Fn(usize) -> usize| {
            let steps: Vec<i64> = (0..length).map(|step| at(step) as i64).collect();
            let steps = sink.ints(&base(&format!("{part}_steps")), &steps);
            sink.step("Gather", &[from, &steps], &base(part), vec![int("axis", 2)])
        };
        // A reading less itself is 0, where there is nothing before it.
        let before = moved(sink, value, "before", &|step| step.saturating_sub(1));
        let change = sink.step("Sub", &[value, &before], &base("change"), vec![]);
        let mut sum = String::new();
        for i in 0..WINDOW {
            let at = |step: usize| (step + i).saturating_sub(WINDOW / 2).min(length - 1);
            let reading = moved(sink, value, "near", &at);
            sum = if i == 0 { reading } else { sink.step("Add", &[&sum, &reading], &base("sum"), vec![]) };
        }
        let fifth = sink.floats(&base("fifth"), &[], &[0.2]);
        let level = sink.step("Mul", &[&sum, &fifth], &base("level"), vec![]);
        let old = moved(sink, &level, "old", &|step| step.checked_sub(WINDOW).unwrap_or(step));
        let drift = sink.step("Sub", &[&level, &old], &base("drift"), vec![]);
        sink.step("Concat", &[value, &change, &level, &drift], &base("beside"), vec![int("axis", 2)])
    }

    /// Writes the mean over time of `(v − low) · factor`, between two ends, for so many lines of each view: `[batch, views ×
    /// lines, steps]`.
    fn lines(
        &self,
        sink: &mut Sink,
        base: &str,
        views: &str,
        (count, low, factor): (usize, &[f32], &[f32]),
        ends: [f32; 2],
        length: usize,
    ) -> String {
        let part = |part: &str| format!("{base}/{part}");
        let shape = [1, self.rows.len(), count, 1];
        let (low, factor) =
            (sink.floats(&part("low"), &shape, low), sink.floats(&part("factor"), &shape, factor));
        let off = sink.step("Sub", &[views, &low], &part("off"), vec![]);
        let line = sink.step("Mul", &[&off, &factor], &part("line"), vec![]);
        let [least, most] = ends.map(|end| sink.floats(&part("end"), &[], &[end]));
        let mut value = sink.step("Clip", &[&line, &least, &most], &part("clipped"), vec![]);
        if self.steps < length {
            let shares = sink.floats(&part("shares"), &[length, self.steps], &shares(length, self.steps));
            value = sink.step("MatMul", &[&value, &shares], &part("mean"), vec![]);
        }
        let rows = sink.ints(&part("rows"), &[0, (self.rows.len() * count) as i64, self.steps as i64]);
        sink.step("Reshape", &[&value, &rows], base, vec![])
    }
}

/// Computes `[length, steps]`: what each reading counts in the mean of each step.
fn shares(length: usize, steps: usize) -> Vec<f32> {
    let stride = length.div_ceil(steps);
    let mut shares = vec![0.0; length * steps];
    for at in 0..length {
        let step = at / stride;
        shares[at * steps + step] = 1.0 / stride.min(length - step * stride) as f32;
    }
    shares
}
