//! The `[train]` table: loss, optimiser, schedule, batch norm, when to stop.

use serde::{Deserialize, Serialize};
use taxel_data::Augment;
use taxel_graph::{Loss, Scheme};

/// The kinds of optimiser.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OptimizerName {
    /// Stochastic gradient descent with momentum (`torch.optim.SGD`).
    #[default]
    Sgdm,
    /// `torch.optim.Adam`: the penalty is part of the gradient.
    Adam,
    /// `torch.optim.AdamW`: the penalty shrinks the weights.
    Adamw,
}

/// `train.optimizer`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Optimizer {
    /// The kind of optimiser.
    pub name: OptimizerName,
    /// Learning rate, above 0. Default 0.01.
    pub lr: f64,
    /// SGDM: share of the last step that is kept, `[0, 1)`. Default 0.9.
    pub momentum: f64,
    /// L2 penalty, `[0, 1]`. Default 0.
    pub weight_decay: f64,
    /// Adam, AdamW: decay of the first and second moment, each in `[0, 1)`. Default `[0.9, 0.999]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub betas: Option<[f64; 2]>,
    /// Adam, AdamW: added to the root of the second moment, above 0. Default 1e-8.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eps: Option<f64>,
}

impl Default for Optimizer {
    fn default() -> Self {
        Optimizer {
            name: OptimizerName::Sgdm,
            lr: 0.01,
            momentum: 0.9,
            weight_decay: 0.0,
            betas: None,
            eps: None,
        }
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
    /// Half a cosine from the rate down to `floor` times the rate (PyTorch's `CosineAnnealingLR` over all
    /// epochs).
    Cosine,
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
    /// Cosine: the last rate as a share of the first, `[0, 1)`. Default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<f64>,
}

/// Which statistics batch norm uses once training has ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BatchNorm {
    /// Mean and variance over the whole training set (MATLAB's; the reading for papers 000 to 003).
    #[default]
    Population,
    /// The running averages of training (PyTorch's; the reading for paper 004).
    Moving,
}

impl BatchNorm {
    /// The name in a config.
    pub fn name(self) -> &'static str {
        match self {
            BatchNorm::Population => "population",
            BatchNorm::Moving => "moving",
        }
    }
}

/// How much the mistakes on a class count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClassWeights {
    /// Every sample the same.
    #[default]
    None,
    /// Every class the same: n / (classes × samples of the class) in the training part, as
    /// scikit-learn's `class_weight="balanced"`.
    Balanced,
}

/// What a validation part is judged by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum By {
    /// The lowest loss.
    #[default]
    Loss,
    /// The highest accuracy; of equals the lower loss.
    Accuracy,
}

/// `train.early_stopping`: keeps the weights of the best epoch and stops once they have been the best for
/// long. The validation part is the protocol's, or held back from the training part of each fold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EarlyStopping {
    /// Epochs without a better one before training stops, 1 to 100,000. Default 10.
    pub patience: usize,
    /// Share of the training part that is held back where the protocol has no validation part, (0, 1).
    /// Default 0.1.
    pub validation: f64,
    /// `loss` (default) or `accuracy`.
    pub by: By,
}

impl Default for EarlyStopping {
    fn default() -> Self {
        EarlyStopping { patience: 10, validation: 0.1, by: By::Loss }
    }
}

/// The `[choose]` table: settings that each fold chooses by a validation part, never by its test part.
///
/// Every combination of `grid` is trained on what is left of the training part and scored on what is held
/// back (or on the protocol's validation part); the best one is trained on the whole training part and
/// tested.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choose {
    /// Keys below `[train]` and the values to try: `"optimizer.lr" = [0.01, 0.001]`.
    pub grid: std::collections::BTreeMap<String, Vec<toml::Value>>,
    /// Share of the training part that is held back where the protocol has no validation part, (0, 1).
    /// Default 0.2.
    #[serde(default = "fifth")]
    pub validation: f64,
    /// `loss` (default) or `accuracy`.
    #[serde(default)]
    pub by: By,
}

fn fifth() -> f64 {
    0.2
}

/// The `[train]` table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Train {
    /// Passes over the training set, 1 to 100,000. Default 100.
    pub epochs: usize,
    /// Samples per step, 1 to 65,536; a smaller rest is a step too. Default 64.
    pub batch_size: usize,
    /// `softmax-cross-entropy` (default), or for several attributes `multi-label-soft-margin` (paper 004,
    /// Eq. 7) or `mean-squared-error`.
    pub loss: Loss,
    /// What moves the weights.
    pub optimizer: Optimizer,
    /// How the learning rate changes over the epochs.
    pub schedule: Schedule,
    /// Which statistics batch norm uses once training has ended.
    pub batch_norm: BatchNorm,
    /// How fresh weights are drawn: `pytorch` (default), `glorot`, `he`.
    pub init: Scheme,
    /// Share of every target that is spread evenly over all classes, `[0, 1)`. Default 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub label_smoothing: f64,
    /// How much the mistakes on a class count. Default all samples the same.
    #[serde(skip_serializing_if = "is_default")]
    pub class_weights: ClassWeights,
    /// Largest norm of all gradients together; longer ones are shortened. Default no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<f64>,
    /// When to stop before the last epoch. Default never.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub early_stopping: Option<EarlyStopping>,
    /// Nodes that training leaves as they are, by name or a name's first parts: `["features"]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub frozen: Vec<String>,
    /// What happens to training images and tensors at random, anew in every epoch. Default nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub augment: Option<Augment>,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Default for Train {
    fn default() -> Self {
        Train {
            epochs: 100,
            batch_size: 64,
            loss: Loss::default(),
            optimizer: Optimizer::default(),
            schedule: Schedule::default(),
            batch_norm: BatchNorm::default(),
            init: Scheme::default(),
            label_smoothing: 0.0,
            class_weights: ClassWeights::default(),
            clip: None,
            early_stopping: None,
            frozen: vec![],
            augment: None,
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
    pub loss: Option<Loss>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optimizer: Option<OptimizerOverride>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schedule: Option<Schedule>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batch_norm: Option<BatchNorm>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub init: Option<Scheme>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label_smoothing: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub class_weights: Option<ClassWeights>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub early_stopping: Option<EarlyStopping>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frozen: Option<Vec<String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub augment: Option<Augment>,
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub betas: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eps: Option<f64>,
}

impl TrainOverride {
    /// `all` with these values in it.
    pub fn over(&self, all: &Train) -> Train {
        let own = self.clone();
        let optimizer = own.optimizer.unwrap_or_default();
        Train {
            epochs: own.epochs.unwrap_or(all.epochs),
            batch_size: own.batch_size.unwrap_or(all.batch_size),
            loss: own.loss.unwrap_or(all.loss),
            optimizer: Optimizer {
                name: optimizer.name.unwrap_or(all.optimizer.name),
                lr: optimizer.lr.unwrap_or(all.optimizer.lr),
                momentum: optimizer.momentum.unwrap_or(all.optimizer.momentum),
                weight_decay: optimizer.weight_decay.unwrap_or(all.optimizer.weight_decay),
                betas: optimizer.betas.or(all.optimizer.betas),
                eps: optimizer.eps.or(all.optimizer.eps),
            },
            schedule: own.schedule.unwrap_or_else(|| all.schedule.clone()),
            batch_norm: own.batch_norm.unwrap_or(all.batch_norm),
            init: own.init.unwrap_or(all.init),
            label_smoothing: own.label_smoothing.unwrap_or(all.label_smoothing),
            class_weights: own.class_weights.unwrap_or(all.class_weights),
            clip: own.clip.or(all.clip),
            early_stopping: own.early_stopping.or_else(|| all.early_stopping.clone()),
            frozen: own.frozen.unwrap_or_else(|| all.frozen.clone()),
            augment: own.augment.or(all.augment),
        }
    }
}

impl Schedule {
    /// Learning rate in `epoch` (from 0) of `epochs`, for a first rate of `lr`.
    pub fn rate(&self, lr: f64, epoch: usize, epochs: usize) -> f64 {
        let done = epoch as f64 / epochs.max(1) as f64;
        match self.kind {
            ScheduleKind::Constant => lr,
            ScheduleKind::Steps => {
                let steps = self.at.as_deref().unwrap_or_default();
                let passed = steps.iter().filter(|&&share| epoch as f64 >= share * epochs as f64).count();
                lr * self.factor.unwrap_or(0.1).powi(passed as i32)
            }
            ScheduleKind::Cosine => {
                let floor = self.floor.unwrap_or(0.0);
                lr * (floor + (1.0 - floor) * (1.0 + (std::f64::consts::PI * done).cos()) / 2.0)
            }
        }
    }
}

impl Choose {
    /// Every combination of the grid: the keys' values, first key slowest.
    pub fn combinations(&self) -> Vec<Vec<(String, toml::Value)>> {
        let mut found = vec![vec![]];
        for (key, values) in &self.grid {
            found = found
                .iter()
                .flat_map(|before: &Vec<(String, toml::Value)>| {
                    values.iter().map(move |value| {
                        let mut longer = before.clone();
                        longer.push((key.clone(), value.clone()));
                        longer
                    })
                })
                .collect();
        }
        found
    }
}
