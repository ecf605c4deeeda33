//! The `[train]` table: optimiser, schedule, batch norm.

use serde::{Deserialize, Serialize};
use taxel_graph::Scheme;

/// The kinds of optimiser.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OptimizerName {
    /// Stochastic gradient descent with momentum.
    #[default]
    Sgdm,
}

/// `train.optimizer`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Optimizer {
    /// The kind of optimiser.
    pub name: OptimizerName,
    /// Learning rate, above 0. Default 0.01.
    pub lr: f64,
    /// Share of the last step that is kept, `[0, 1)`. Default 0.9.
    pub momentum: f64,
    /// L2 penalty, `[0, 1]`. Default 0.
    pub weight_decay: f64,
}

impl Default for Optimizer {
    fn default() -> Self {
        Optimizer { name: OptimizerName::Sgdm, lr: 0.01, momentum: 0.9, weight_decay: 0.0 }
    }
}

/// The kinds of learning rate schedule.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScheduleKind {
    /// The same rate in every epoch.
    #[default]
    Constant,
    /// Multiplied by `factor` at each share of the epochs in `at`.
    Steps,
}

/// `train.schedule`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Schedule {
    /// The kind of schedule.
    pub kind: ScheduleKind,
    /// Steps: shares of the epochs, ascending in (0, 1), such as `[0.6, 0.85]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Vec<f64>>,
    /// Steps: multiplies the rate, `(0, 1]`. Default 0.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
}

/// Which statistics batch norm uses once training has ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BatchNorm {
    /// Mean and variance over the whole training set (MATLAB's; the reading for paper 000).
    #[default]
    Population,
    /// The running averages of training (PyTorch's).
    Moving,
}

/// The `[train]` table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Train {
    /// Passes over the training set, 1 to 100,000. Default 100.
    pub epochs: usize,
    /// Samples per step, 1 to 65,536; a smaller rest is a step too. Default 64.
    pub batch_size: usize,
    /// What moves the weights.
    pub optimizer: Optimizer,
    /// How the learning rate changes over the epochs.
    pub schedule: Schedule,
    /// Which statistics batch norm uses once training has ended.
    pub batch_norm: BatchNorm,
    /// How fresh weights are drawn: `pytorch` (default), `glorot`, `he`.
    pub init: Scheme,
}

impl Default for Train {
    fn default() -> Self {
        Train {
            epochs: 100,
            batch_size: 64,
            optimizer: Optimizer::default(),
            schedule: Schedule::default(),
            batch_norm: BatchNorm::default(),
            init: Scheme::default(),
        }
    }
}

/// `networks.N.train`: what one network does otherwise.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the fields of Train")]
pub struct TrainOverride {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epochs: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batch_size: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optimizer: Option<OptimizerOverride>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schedule: Option<Schedule>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batch_norm: Option<BatchNorm>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub init: Option<Scheme>,
}

/// `networks.N.train.optimizer`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the fields of Optimizer")]
pub struct OptimizerOverride {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<OptimizerName>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lr: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub momentum: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight_decay: Option<f64>,
}

impl Schedule {
    /// Learning rate in `epoch` (from 0) of `epochs`, for a first rate of `lr`.
    pub fn rate(&self, lr: f64, epoch: usize, epochs: usize) -> f64 {
        let steps = self.at.as_deref().unwrap_or_default();
        let passed = steps.iter().filter(|&&share| epoch as f64 >= share * epochs as f64).count();
        lr * self.factor.unwrap_or(0.1).powi(passed as i32)
    }
}
