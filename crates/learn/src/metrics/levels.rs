//! Scores of ordered levels (Zhang et al. 2022, Table 2): which level, and how far off.

use serde::{Deserialize, Serialize};
use taxel_data::Task;

use crate::error::Result;
use crate::metrics::{
    BINS, ClassScores, Confusion, MacroScores, argmax, brier, calibration_error, log_loss, softmax,
};

/// Several attributes, each one level out of its own outputs.
///
/// The outputs of a network are those of the attributes one after the other: 10 elasticity and 10 hardness
/// levels are 20 outputs. The predicted level of an attribute is the largest of its outputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Levels {
    sizes: Vec<usize>,
}

/// Calls `change` with the outputs of each attribute in turn, in rows of all attributes, whose `sizes` are their numbers of classes;
/// with none of an attribute without classes.
pub(crate) fn each_attribute(values: &mut [f32], sizes: &[usize], mut change: impl FnMut(&mut [f32])) {
    let mut rest = values;
    for size in sizes.iter().cycle() {
        if rest.len() < *size || *size == 0 {
            return;
        }
        let (row, others) = rest.split_at_mut(*size);
        change(row);
        rest = others;
    }
}

/// Scores of one attribute, shares in `[0, 1]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LevelScores {
    /// Accuracy and macro means.
    #[serde(flatten)]
    pub scores: MacroScores,
    /// Mean of |predicted − true level|: a miss by one level is not a miss by nine.
    pub mean_absolute_error: f64,
    /// Share of samples that are at most one level off; none in files of before it was counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_one: Option<f64>,
    /// Precision, recall and F1 of each level.
    pub per_level: Vec<ClassScores>,
    /// Counts `[true][predicted]`.
    pub confusion: Confusion,
}

impl Levels {
    /// Attributes with that many levels each.
    pub fn new(sizes: &[usize]) -> Self {
        Levels { sizes: sizes.to_vec() }
    }

    /// Returns the attributes of classes and levels; none of values.
    pub fn of_task(task: &Task) -> Self {
        Levels { sizes: task.attributes().iter().map(|attribute| attribute.classes.len()).collect() }
    }

    /// Levels of each attribute.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Outputs of a network for all attributes.
    pub fn outputs(&self) -> usize {
        self.sizes.iter().sum()
    }

    /// Turns labels `[n, attributes]` into targets `[n, outputs]`: one 1 per attribute, 0 elsewhere.
    pub fn targets(&self, labels: &[u32]) -> Vec<f32> {
        let mut targets = vec![];
        for row in labels.chunks_exact(self.sizes.len().max(1)) {
            for (&label, &size) in row.iter().zip(&self.sizes) {
                targets.extend((0..size).map(|level| f32::from(u8::from(level == label as usize))));
            }
        }
        targets
    }

    /// Turns targets `[n, outputs]` of [`Levels::targets`], in place, into those of
    /// [`Loss::CumulativeLogits`](taxel_graph::Loss::CumulativeLogits): of each attribute 1 up to the level, 0 above; of shares the
    /// share of this level and higher ones.
    pub fn accumulate(&self, targets: &mut [f32]) {
        each_attribute(targets, &self.sizes, |row| {
            let mut sum = 0.0;
            for share in row.iter_mut().rev() {
                sum += *share;
                *share = sum;
            }
        });
    }

    /// Turns outputs `[n, outputs]` of [`Loss::CumulativeLogits`](taxel_graph::Loss::CumulativeLogits) into probabilities, in
    /// place. Nothing is allocated.
    pub(crate) fn cumulative_probabilities(&self, outputs: &mut [f32]) {
        each_attribute(outputs, &self.sizes, |row| {
            let mut sum = 0.0;
            for logit in row.iter_mut().skip(1) {
                sum += *logit;
                *logit = sum;
            }
            row[0] = 0.0;
            softmax(row, row.len());
        });
    }

    /// Turns outputs `[n, outputs]` into predicted levels `[n, attributes]`.
    pub fn predicted(&self, outputs: &[f32]) -> Vec<u32> {
        let mut levels = vec![];
        for mut row in outputs.chunks_exact(self.outputs().max(1)) {
            for &size in &self.sizes {
                let (of_attribute, rest) = row.split_at(size);
                levels.extend(argmax(of_attribute, size));
                row = rest;
            }
        }
        levels
    }

    /// Returns how sure a row of probabilities `[outputs]` is: the least of the attributes' highest ones, 0..1. Nothing is
    /// allocated.
    pub fn confidence(&self, probabilities: &[f32]) -> f32 {
        let mut rest = probabilities;
        let highest = |size: &usize| {
            let (own, others) = rest.split_at(*size);
            rest = others;
            own.iter().copied().fold(0.0, f32::max)
        };
        self.sizes.iter().map(highest).fold(1.0, f32::min)
    }

    /// Returns values `[n, outputs]`, such as probabilities, and labels `[n, attributes]` of each attribute, with the number of
    /// its levels.
    pub(crate) fn of_each(&self, values: &[f32], labels: &[u32]) -> Vec<(Vec<f32>, Vec<u32>, usize)> {
        let outputs = self.outputs().max(1);
        let mut first = 0;
        let of_attribute = |(attribute, &size): (usize, &usize)| {
            let rows = values.chunks_exact(outputs);
            let of_size = rows.flat_map(|row| &row[first..first + size]).copied().collect();
            first += size;
            (of_size, self.column(labels, attribute), size)
        };
        self.sizes.iter().enumerate().map(of_attribute).collect()
    }

    /// Returns the labels of one attribute out of `[n, attributes]`.
    fn column(&self, labels: &[u32], attribute: usize) -> Vec<u32> {
        labels.iter().skip(attribute).step_by(self.sizes.len().max(1)).copied().collect()
    }

    /// Computes the expected calibration error in [`BINS`] bins and the Brier score of probabilities `[n, outputs]`,
    /// means over the attributes.
    ///
    /// # Errors
    /// No samples, or labels `[n, attributes]` that do not fit.
    pub fn calibration(&self, probabilities: &[f32], truth: &[u32]) -> Result<(f64, f64)> {
        let (width, mut sums) = (self.sizes.len().max(1), (0.0, 0.0));
        for (probabilities, truth, size) in self.of_each(probabilities, truth) {
            sums.0 += calibration_error(&probabilities, &truth, size, BINS)?;
            sums.1 += brier(&probabilities, &truth, size)?;
        }
        Ok((sums.0 / width as f64, sums.1 / width as f64))
    }

    /// Computes the mean over the attributes of [`log_loss`]: probabilities are `[n, outputs]`, labels
    /// `[n, attributes]`.
    ///
    /// # Errors
    /// As [`Levels::calibration`].
    pub fn log_loss(&self, probabilities: &[f32], truth: &[u32]) -> Result<f64> {
        let (width, mut loss) = (self.sizes.len().max(1), 0.0);
        for (probabilities, truth, size) in self.of_each(probabilities, truth) {
            loss += log_loss(&probabilities, &truth, size)? / width as f64;
        }
        Ok(loss)
    }

    /// Scores of each attribute; labels and predictions are `[n, attributes]`.
    ///
    /// # Errors
    /// No or unequally many labels, or a level that does not exist.
    pub fn scores(&self, truth: &[u32], predicted: &[u32]) -> Result<Vec<LevelScores>> {
        let of = |(attribute, &size): (usize, &usize)| {
            let (truth, predicted) = (self.column(truth, attribute), self.column(predicted, attribute));
            Ok(LevelScores::of(Confusion::new(&truth, &predicted, size)?))
        };
        self.sizes.iter().enumerate().map(of).collect()
    }
}

impl LevelScores {
    /// Computes all that follows from the counts.
    pub fn of(confusion: Confusion) -> Self {
        let (mut off, mut near, mut total) = (0.0, 0, 0);
        for (truth, row) in confusion.counts().iter().enumerate() {
            for (predicted, &count) in row.iter().enumerate() {
                off += count as f64 * truth.abs_diff(predicted) as f64;
                near += if truth.abs_diff(predicted) <= 1 { count } else { 0 };
                total += count;
            }
        }
        LevelScores {
            scores: confusion.scores(),
            mean_absolute_error: if total == 0 { 0.0 } else { off / total as f64 },
            within_one: (total > 0).then(|| near as f64 / total as f64),
            per_level: confusion.per_class(),
            confusion,
        }
    }
}
