//! Predictions beside the samples that they belong to, and how many of them are right.

use taxel::Predictions;
use taxel::base::thousands;
use taxel::learn::certainty::AnswerSet;
use taxel::learn::metrics::Levels;

use super::explain::Explained;
use super::guard::Replaced;
use super::true_values::TrueValues;
use crate::commands::arguments::certainty::set_of;

/// Predictions with the samples that they belong to.
pub struct SamplePredictions<'a> {
    pub origins: &'a [String],
    /// First time step of each, where samples are windows of recordings.
    pub starts: Option<&'a [usize]>,
    pub predictions: &'a Predictions,
    /// Names of the true classes, where the recordings have labels.
    pub truth: Option<&'a [Vec<String>]>,
    /// The true values, where the recordings have some.
    pub values: Option<&'a TrueValues>,
    /// Broken channels and taxels that the guard of the model replaced.
    pub replaced: Option<&'a Replaced>,
    /// The parts that each rests on, where that is asked for.
    pub explained: Option<&'a Explained>,
    /// Whether the probabilities were fitted to held-out predictions.
    pub is_calibrated: bool,
    /// The familiarity up to which a sample is unknown to the model.
    pub unknown: f32,
    /// Sets of classes, where they are asked for.
    pub sets: Option<&'a AnswerSet>,
    /// Share of samples whose intervals hold the true values; none without intervals.
    pub interval: Option<f64>,
}

impl SamplePredictions<'_> {
    /// Returns the ends of the intervals of a sample.
    pub fn ends(&self, i: usize) -> Option<Vec<[f32; 2]>> {
        self.predictions.intervals(i, self.interval?)
    }

    pub fn familiarity(&self) -> Option<&Vec<f32>> {
        self.predictions.familiarity.as_ref()
    }

    pub fn is_unknown(&self, i: usize) -> bool {
        self.predictions.is_unknown(i, self.unknown)
    }

    /// Returns each attribute with the classes in the set of a sample.
    pub fn set_classes(&self, sets: &AnswerSet, i: usize) -> Vec<(taxel::Attribute, Vec<usize>)> {
        let task = &self.predictions.task;
        let classes = set_of(sets, self.predictions.row(i), &Levels::of_task(task), self.is_unknown(i));
        task.attributes().into_iter().zip(classes).collect()
    }

    /// Returns the names of the classes in the set of a sample, with the name of each attribute.
    pub fn set_names(&self, sets: &AnswerSet, i: usize) -> Vec<(String, Vec<String>)> {
        let names = |(attribute, set): (taxel::Attribute, Vec<usize>)| {
            (attribute.name, set.into_iter().map(|class| attribute.classes[class].clone()).collect())
        };
        self.set_classes(sets, i).into_iter().map(names).collect()
    }

    /// Returns of every output whether the set of a sample has its class.
    pub fn set_mask(&self, sets: &AnswerSet, i: usize) -> Vec<bool> {
        let of = |(attribute, set): (taxel::Attribute, Vec<usize>)| {
            (0..attribute.classes.len()).map(move |class| set.contains(&class))
        };
        self.set_classes(sets, i).into_iter().flat_map(of).collect()
    }

    pub fn set_words(&self, sets: &AnswerSet, i: usize) -> String {
        let joined = |(_, set): (String, Vec<String>)| set.join(" | ");
        self.set_names(sets, i).into_iter().map(joined).collect::<Vec<_>>().join("; ")
    }

    /// Returns the number of each window's recording, in the order of the recordings.
    pub fn recordings(&self) -> Vec<i64> {
        let mut number = 0;
        let next = |i: usize| {
            let starts = self.starts.is_none_or(|starts| starts[i] == 0);
            number += i64::from(i > 0 && (starts || self.origins[i] != self.origins[i - 1]));
            number
        };
        (0..self.origins.len()).map(next).collect()
    }

    /// Counts the right predictions, and all whose true names the model knows.
    pub fn right(&self) -> Option<(usize, usize)> {
        let truth = self.truth?;
        let knows = |attribute: &taxel::Attribute, name: &String| attribute.classes.contains(name);
        let (mut right, mut of) = (0, 0);
        let attributes = self.predictions.task.attributes();
        for (i, names) in truth.iter().enumerate() {
            for ((predicted, attribute), name) in
                self.predictions.predicted(i).iter().zip(&attributes).zip(names)
            {
                of += usize::from(knows(attribute, name));
                right += usize::from(knows(attribute, name) && predicted.class == name);
            }
        }
        (of > 0).then_some((right, of))
    }

    pub fn score(&self) -> Option<String> {
        if let Some(values) = self.values {
            return values.score(self.predictions);
        }
        let truth = self.truth.filter(|_| self.predictions.task.quantities().is_empty())?;
        let all: usize = truth.iter().map(Vec::len).sum();
        Some(match self.right() {
            None => "the labels are no classes of the model: nothing is scored".into(),
            Some((right, of)) => {
                let share = 100.0 * right as f64 / of as f64;
                let (right, count) = (thousands(right as u64), thousands(of as u64));
                let foreign = if of < all {
                    format!("; {} labels are no classes of the model", all - of)
                } else {
                    String::new()
                };
                let unknown = (0..self.predictions.len()).filter(|i| self.is_unknown(*i)).count();
                let refused = match unknown {
                    0 => String::new(),
                    some => format!("; {some} are unknown to the model, and count by their likeliest class"),
                };
                format!("{right} of {count} right ({share:.2} %){refused}{foreign}")
            }
        })
    }
}
