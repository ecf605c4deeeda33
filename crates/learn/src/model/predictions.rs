//! Predictions of a model.

use serde::Serialize;
use taxel_data::{Attribute, Quantity, Task};

use crate::certainty::Intervals;
use crate::metrics::Levels;

/// Predictions for `n` samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Predictions {
    /// The predicted quantity: a class, levels of several attributes, or values.
    pub task: Task,
    /// Probabilities `[n, outputs]`, row-major: the classes, or the levels of the attributes one after the other; of
    /// values the values themselves.
    pub outputs: Vec<f32>,
    /// The likeliest class or level of each attribute, `[n, attributes]`; none of values.
    pub labels: Vec<u32>,
    /// The familiarity of each sample: the share of held-out samples that were at least as far from what the model has
    /// learned, 0.01..1. None of a model without a gate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub familiarity: Option<Vec<f32>>,
    /// How far below and above its values the model expects the true ones, `[n, quantities, 2]`; empty where it says nothing of it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub spread: Vec<f32>,
    #[serde(skip)]
    intervals: Option<Intervals>,
    samples: usize,
}

/// One attribute of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction<'a> {
    /// Name of the attribute.
    pub attribute: &'a str,
    /// The likeliest class or level.
    pub class: &'a str,
    /// Its probability, 0 to 1.
    pub probability: f32,
}

impl Predictions {
    pub(super) fn new(task: Task, outputs: Vec<f32>, familiarity: Option<Vec<f32>>) -> Self {
        let labels = match task {
            Task::Classes(_) | Task::Levels(_) => Levels::of_task(&task).predicted(&outputs),
            Task::Values(_) => vec![],
        };
        let samples = outputs.len() / task.outputs().max(1);
        Predictions { task, outputs, labels, familiarity, spread: vec![], intervals: None, samples }
    }

    /// Adds how far off values may be: the spread `[n, quantities, 2]` that the model states, and the intervals of its card.
    pub(super) fn with_intervals(self, spread: Vec<f32>, intervals: Option<Intervals>) -> Self {
        Predictions { spread, intervals, ..self }
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.samples
    }

    /// Checks whether there are none.
    pub fn is_empty(&self) -> bool {
        self.samples == 0
    }

    /// Returns the number of outputs of one sample.
    pub fn width(&self) -> usize {
        self.task.outputs()
    }

    /// Returns the outputs of sample `i`.
    pub fn row(&self, i: usize) -> &[f32] {
        &self.outputs[i * self.width()..(i + 1) * self.width()]
    }

    /// Returns the values of sample `i` with what they are; none of classes and levels.
    pub fn values(&self, i: usize) -> Vec<(&Quantity, f32)> {
        self.task.quantities().iter().zip(self.row(i).iter().copied()).collect()
    }

    /// Returns the intervals of the values of sample `i` that hold the true ones in `share` of samples, 0.8, 0.9, 0.95 or 0.99; none of
    /// classes, and of a model without intervals of that share.
    pub fn intervals(&self, i: usize, share: f64) -> Option<Vec<[f32; 2]>> {
        let at = self.intervals.as_ref()?.at(share)?;
        let ends = |(quantity, value): (usize, &f32)| at.ends(quantity, *value, self.around(i, quantity));
        Some(self.row(i).iter().enumerate().map(ends).collect())
    }

    /// Returns how far below and above one value of sample `i` the model expects the true one; 1 where it says nothing of it.
    pub(super) fn around(&self, i: usize, quantity: usize) -> [f32; 2] {
        let place = 2 * (i * self.width() + quantity);
        self.spread.get(place..place + 2).map_or([1.0; 2], |around| [around[0], around[1]])
    }

    /// Returns the predictions for sample `i`, one per attribute; none of values.
    pub fn predicted(&self, i: usize) -> Vec<Prediction<'_>> {
        let class = TaskAttributes(&self.task);
        let width = class.count();
        let labels = &self.labels[i * width..(i + 1) * width];
        let mut outputs = self.row(i);
        let mut predictions = vec![];
        for (at, &label) in labels.iter().enumerate() {
            let (attribute, classes) = class.attribute(at);
            let probability = outputs[label as usize];
            predictions.push(Prediction { attribute, class: &classes[label as usize], probability });
            outputs = &outputs[classes.len()..];
        }
        predictions
    }

    /// Checks whether sample `i` is unlike those that the model has learned from: its familiarity is at most `limit`. Of held-out
    /// samples such a share is.
    pub fn is_unknown(&self, i: usize, limit: f32) -> bool {
        self.familiarity.as_ref().is_some_and(|all| all[i] <= limit)
    }

    /// Returns the likeliest class of sample `i`, of several attributes the first one's; the empty text for values.
    pub fn class(&self, i: usize) -> &str {
        self.predicted(i).first().map_or("", |first| first.class)
    }
}

/// The attributes of a task without a copy of their names.
struct TaskAttributes<'t>(&'t Task);

impl<'t> TaskAttributes<'t> {
    fn count(&self) -> usize {
        match self.0 {
            Task::Classes(_) => 1,
            Task::Levels(attributes) => attributes.len(),
            Task::Values(_) => 0,
        }
    }

    fn attribute(&self, at: usize) -> (&'t str, &'t [String]) {
        let of_one = |attribute: &'t Attribute| (attribute.name.as_str(), attribute.classes.as_slice());
        match self.0 {
            Task::Classes(classes) => ("class", classes),
            Task::Levels(attributes) => attributes.get(at).map_or(("", &[]), of_one),
            Task::Values(_) => ("", &[]),
        }
    }
}
