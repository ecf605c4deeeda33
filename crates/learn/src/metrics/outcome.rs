//! True targets of test samples beside what was predicted.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use taxel_data::{TargetSteps, Targets, Task};

use crate::error::Result;
use crate::metrics::Levels;

/// True targets of test samples beside what was predicted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Outcome {
    /// Classes, or levels of several attributes.
    Labels {
        /// `[samples]`, of several attributes `[samples, attributes]`, row-major.
        #[serde(rename = "true")]
        truth: Vec<u32>,
        /// The same of the predicted ones.
        predicted: Vec<u32>,
        /// `[samples, outputs]`, row-major.
        probabilities: Vec<f32>,
        /// Of each attribute the classes that were tested but not trained; empty where there are none.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        untrained: Vec<Vec<u32>>,
        /// The time steps of the samples, where each time step has its own class.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        steps: Option<TargetSteps>,
    },
    /// Values, each in its unit.
    Values {
        /// `[samples, quantities]`, row-major.
        #[serde(rename = "true")]
        truth: Vec<f32>,
        /// The same of the predicted ones.
        predicted: Vec<f32>,
        /// How far below and above its answers the network expects the true values, `[samples, quantities, 2]`; empty where it
        /// says nothing of it.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        spread: Vec<f32>,
    },
}

impl Outcome {
    /// Reads the outputs `[rows, outputs]` of a model as predictions, beside the targets of `rows`.
    pub fn new(targets: &Targets, rows: &[usize], outputs: Vec<f32>) -> Self {
        match targets {
            Targets::Classes { labels, .. } | Targets::Levels(labels) => Outcome::Labels {
                truth: labels.of(rows),
                predicted: Levels::new(&labels.sizes()).predicted(&outputs),
                probabilities: outputs,
                untrained: vec![],
                steps: targets.steps().map(|steps| steps.of(rows)),
            },
            Targets::Values(values) => {
                Outcome::Values { truth: values.of(rows), predicted: outputs, spread: vec![] }
            }
        }
    }

    /// Notes the classes that have test samples but no training sample: macro means leave them out.
    pub(crate) fn with_training(mut self, targets: &Targets, train: &[usize]) -> Self {
        if let (Outcome::Labels { truth, untrained, .. }, Some(labels)) = (&mut self, targets.labels()) {
            let width = labels.sizes().len();
            let trained = labels.of(train);
            let of = |labels: &[u32], attribute: usize| -> BTreeSet<u32> {
                labels.iter().skip(attribute).step_by(width.max(1)).copied().collect()
            };
            let missing =
                |attribute| of(truth, attribute).difference(&of(&trained, attribute)).copied().collect();
            let each: Vec<Vec<u32>> = (0..width).map(missing).collect();
            *untrained = if each.iter().all(Vec::is_empty) { vec![] } else { each };
        }
        self
    }

    /// Notes how far below and above its answers the network expects the true values, `[samples, quantities, 2]`.
    pub(crate) fn with_spread(mut self, given: &[f32]) -> Self {
        if let Outcome::Values { spread, .. } = &mut self {
            *spread = given.to_vec();
        }
        self
    }

    /// Notes of each attribute the classes that were tested but not trained, as another outcome of the same fold has them.
    pub fn with_untrained(mut self, classes: &[Vec<u32>]) -> Self {
        if let Outcome::Labels { untrained, .. } = &mut self {
            *untrained = classes.to_vec();
        }
        self
    }

    /// Returns the classes of an attribute that were tested but not trained.
    pub fn untrained(&self, attribute: usize) -> &[u32] {
        match self {
            Outcome::Labels { untrained, .. } => untrained.get(attribute).map_or(&[], Vec::as_slice),
            Outcome::Values { .. } => &[],
        }
    }

    /// Returns the outputs of the model `[samples, outputs]`: probabilities, or the predicted values.
    pub fn outputs(&self) -> &[f32] {
        match self {
            Outcome::Labels { probabilities, .. } => probabilities,
            Outcome::Values { predicted, .. } => predicted,
        }
    }

    /// Returns the time steps of the samples, where each time step has its own class.
    pub fn steps(&self) -> Option<&TargetSteps> {
        match self {
            Outcome::Labels { steps, .. } => steps.as_ref(),
            Outcome::Values { .. } => None,
        }
    }

    /// Returns true and predicted labels; nothing of values.
    pub fn labels(&self) -> (&[u32], &[u32]) {
        match self {
            Outcome::Labels { truth, predicted, .. } => (truth, predicted),
            Outcome::Values { .. } => (&[], &[]),
        }
    }

    /// Returns true and predicted values `[samples, quantities]`; nothing of labels.
    pub fn values(&self) -> (&[f32], &[f32]) {
        match self {
            Outcome::Values { truth, predicted, .. } => (truth, predicted),
            Outcome::Labels { .. } => (&[], &[]),
        }
    }

    /// Returns the mean loss: the log loss of labels, of several attributes the mean over them; the squared error of
    /// values.
    ///
    /// # Errors
    /// No samples, or labels that do not fit the task.
    pub fn loss(&self, task: &Task) -> Result<f64> {
        match self {
            Outcome::Labels { truth, probabilities, .. } => {
                Levels::of_task(task).log_loss(probabilities, truth)
            }
            Outcome::Values { truth, predicted, .. } => {
                let squares =
                    predicted.iter().zip(truth).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
                Ok(squares.sum::<f64>() / truth.len().max(1) as f64)
            }
        }
    }

    /// Checks that it holds predictions for `samples` samples of `task`, every label being one of the task's.
    pub fn fits(&self, task: &Task, samples: usize) -> bool {
        match (self, task) {
            (
                Outcome::Labels { truth, predicted, probabilities, steps, .. },
                Task::Classes(_) | Task::Levels(_),
            ) => {
                let sizes: Vec<usize> =
                    task.attributes().iter().map(|attribute| attribute.classes.len()).collect();
                let known = |labels: &[u32]| {
                    let each = labels.iter().zip(sizes.iter().cycle());
                    labels.len() == samples * sizes.len()
                        && each.into_iter().all(|(&label, &size)| (label as usize) < size)
                };
                let timed = steps.as_ref().is_none_or(|at| {
                    at.recordings.len() == samples && at.steps.len() == samples && at.hop > 0
                });
                timed && known(truth) && known(predicted) && probabilities.len() == samples * task.outputs()
            }
            (Outcome::Values { truth, predicted, spread }, Task::Values(quantities)) => {
                let expected = samples * quantities.len();
                let finite = |values: &[f32]| values.iter().all(|v| v.is_finite());
                [truth, predicted].iter().all(|values| values.len() == expected && finite(values))
                    && (spread.is_empty() || spread.len() == 2 * expected && finite(spread))
            }
            _ => false,
        }
    }

    /// Checks whether the true targets are those of `rows`.
    pub fn is_about(&self, targets: &Targets, rows: &[usize]) -> bool {
        match (self, targets) {
            (Outcome::Values { truth, .. }, Targets::Values(values)) => *truth == values.of(rows),
            (Outcome::Labels { truth, .. }, _) => {
                targets.labels().is_some_and(|labels| *truth == labels.of(rows))
            }
            _ => false,
        }
    }
}
