//! True targets of test samples beside what was predicted.

use serde::{Deserialize, Serialize};
use taxel_data::{Targets, Task};

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
    },
    /// Values, each in its unit.
    Values {
        /// `[samples, quantities]`, row-major.
        #[serde(rename = "true")]
        truth: Vec<f32>,
        /// The same of the predicted ones.
        predicted: Vec<f32>,
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
            },
            Targets::Values(values) => Outcome::Values { truth: values.of(rows), predicted: outputs },
        }
    }

    /// Returns the outputs of the model `[samples, outputs]`: probabilities, or the predicted values.
    pub fn outputs(&self) -> &[f32] {
        match self {
            Outcome::Labels { probabilities, .. } => probabilities,
            Outcome::Values { predicted, .. } => predicted,
        }
    }

    /// Returns true and predicted labels; nothing of values.
    pub fn labels(&self) -> (&[u32], &[u32]) {
        match self {
            Outcome::Labels { truth, predicted, .. } => (truth, predicted),
            Outcome::Values { .. } => (&[], &[]),
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
            Outcome::Values { truth, predicted } => {
                let squares =
                    predicted.iter().zip(truth).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
                Ok(squares.sum::<f64>() / truth.len().max(1) as f64)
            }
        }
    }

    /// Checks that it holds predictions for `samples` samples of `task`, every label being one of the task's.
    pub fn fits(&self, task: &Task, samples: usize) -> bool {
        match (self, task) {
            (Outcome::Labels { truth, predicted, probabilities }, Task::Classes(_) | Task::Levels(_)) => {
                let sizes: Vec<usize> =
                    task.attributes().iter().map(|attribute| attribute.classes.len()).collect();
                let known = |labels: &[u32]| {
                    let each = labels.iter().zip(sizes.iter().cycle());
                    labels.len() == samples * sizes.len()
                        && each.into_iter().all(|(&label, &size)| (label as usize) < size)
                };
                known(truth) && known(predicted) && probabilities.len() == samples * task.outputs()
            }
            (Outcome::Values { truth, predicted }, Task::Values(quantities)) => {
                [truth, predicted].iter().all(|values| {
                    values.len() == samples * quantities.len() && values.iter().all(|v| v.is_finite())
                })
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
