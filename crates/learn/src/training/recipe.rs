//! How a network is trained: loss, optimiser, schedule, batch norm, when to stop.
//!
//! The defaults are the recipe of Kaewrakmuk and Srinonchat 2026, Table 1 and section 5.1.

use serde::{Deserialize, Serialize};
use taxel_base::names::hint;
use taxel_data::{Augment, Task};
pub use taxel_engine::{FrozenStatistics, Precision};
use taxel_faults::TrainingFaults;
use taxel_graph::{Loss, Scheme};

use crate::metrics::{Metric, metric_names, metrics};
use crate::problem::{Check, Problem, augment_problem, fault_problem, require, share, within};
use crate::training::optimizer::Optimizer;
use crate::training::schedule::Schedule;

/// Samples of the largest batch.
pub(crate) const LARGEST_BATCH: usize = 65_536;

/// Which statistics batch norm uses once training has ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum BatchNorm {
    /// Mean and variance over the whole training set (MATLAB's; presumably that of the first four of `docs/papers.md`).
    #[default]
    #[serde(rename = "population")]
    Recomputed,
    /// The running averages of training (PyTorch's; presumably that of Zhang et al. 2022).
    #[serde(rename = "moving")]
    Running,
}

impl BatchNorm {
    /// Returns the name in a config.
    pub fn name(self) -> &'static str {
        match self {
            BatchNorm::Recomputed => "population",
            BatchNorm::Running => "moving",
        }
    }
}

/// How much the mistakes on a class count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ClassWeights {
    /// Every sample the same.
    #[default]
    None,
    /// Every class the same: n / (classes × samples of the class) in the training part, as
    /// scikit-learn's `class_weight="balanced"`.
    Balanced,
}

/// The criterion on a validation part: `loss`, or the name of a metric of the task, such as `accuracy`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(from = "String", into = "String")]
pub enum Criterion {
    /// The lowest loss.
    #[default]
    Loss,
    /// The best value of the metric of that name; of equals the lower loss.
    Metric(String),
}

impl From<String> for Criterion {
    fn from(name: String) -> Self {
        if name == LOSS { Criterion::Loss } else { Criterion::Metric(name) }
    }
}

impl From<Criterion> for String {
    fn from(criterion: Criterion) -> Self {
        criterion.name().into()
    }
}

/// Name of [`Criterion::Loss`].
const LOSS: &str = "loss";

impl Criterion {
    /// Returns its name in a config.
    pub fn name(&self) -> &str {
        match self {
            Criterion::Loss => LOSS,
            Criterion::Metric(name) => name,
        }
    }

    /// Returns the metric that is measured for it: the one that it names, or the primary one beside the loss.
    ///
    /// # Errors
    /// A name that no metric of the task has, as the value of `key`.
    pub fn metric(&self, key: &str, task: &Task) -> Result<&'static Metric, Problem> {
        let Criterion::Metric(name) = self else { return Ok(Metric::primary(task)) };
        Metric::named(task, name).ok_or_else(|| {
            let known = std::iter::once(LOSS).chain(metrics(task).iter().map(|metric| metric.name));
            Problem::new(key, format!("{name:?}"), hint(name, known))
        })
    }

    /// Refuses a name that no metric of any task has, as the value of `key`.
    pub(crate) fn check(&self, key: &str) -> Check {
        let Criterion::Metric(name) = self else { return Ok(()) };
        let known = || [LOSS].into_iter().chain(metric_names());
        require(known().any(|metric| metric == name), key, format!("{name:?}"), hint(name, known()))
    }

    /// Checks whether a validation's (loss, value of `metric`) are better than another's.
    pub fn prefers(
        &self,
        metric: &Metric,
        (loss, score): (f64, f64),
        (other_loss, other): (f64, f64),
    ) -> bool {
        match self {
            Criterion::Loss => loss < other_loss,
            Criterion::Metric(_) => metric.prefers(score, other) || score == other && loss < other_loss,
        }
    }
}

/// Keeps the weights of the best epoch and stops once they have been the best for long. The validation part
/// is the protocol's, or held back from the training part of each fold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct EarlyStopping {
    /// Epochs without a better one before training stops, 1 to 100,000. Default 10.
    pub patience: usize,
    /// Share of the training part that is held back where the protocol has no validation part, (0, 1).
    /// Default 0.1.
    pub validation: f64,
    /// `loss` (default), or a metric of the task: `accuracy`.
    pub by: Criterion,
}

impl Default for EarlyStopping {
    fn default() -> Self {
        EarlyStopping { patience: 10, validation: 0.1, by: Criterion::Loss }
    }
}

/// How a network is trained; [`Recipe::default`] is that of Kaewrakmuk and Srinonchat 2026.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Recipe {
    /// Passes over the training set, 1 to 100,000. Default 100.
    pub epochs: usize,
    /// Samples per step, 1 to 65,536; a smaller rest is a step too. Default 64.
    pub batch_size: usize,
    /// Steps that a training takes at least, 1 to 10,000,000: few samples get more epochs. Default no such number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_steps: Option<usize>,
    /// Batches that few samples are still cut into, 1 to 65,536, each of at least 8 samples. Default no such
    /// number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_batches: Option<usize>,
    /// Of classes `softmax-cross-entropy` (default), of several attributes `multi-label-soft-margin` (default; Zhang et al. 2022,
    /// Eq. 7), of both `mean-squared-error` and `hinge`, which with an L2 penalty makes the last layer a linear support vector
    /// machine. Of values `huber` (default), `mean-squared-error`, `gaussian-likelihood` or `quantiles`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loss: Option<Loss>,
    /// The optimiser.
    pub optimizer: Optimizer,
    /// How the learning rate changes over the epochs.
    pub schedule: Schedule,
    /// Share of the epochs, `[0, 1)`, over which the rate rises evenly to the first of the schedule, which takes
    /// the rest. Default 0.
    #[serde(skip_serializing_if = "crate::json_file::is_default")]
    pub warm_up: f64,
    /// Which statistics batch norm uses once training has ended.
    pub batch_norm: BatchNorm,
    /// How fresh weights are drawn: `pytorch` (default), `glorot`, `he`.
    pub init: Scheme,
    /// Share of every target that is spread evenly over all classes, `[0, 1)`. Default 0.
    pub label_smoothing: f64,
    /// How much the mistakes on a class count. Default all samples the same.
    pub class_weights: ClassWeights,
    /// Largest norm of all gradients together; longer ones are shortened. Default no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<f64>,
    /// When to stop before the last epoch. Default never.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub early_stopping: Option<EarlyStopping>,
    /// Nodes that training leaves as they are, by name or a name's first parts: `["features"]`.
    pub frozen: Vec<String>,
    /// Treatment of the batch-norm statistics of frozen nodes: `kept` (default) or `renewed`.
    #[serde(skip_serializing_if = "crate::json_file::is_default")]
    pub frozen_statistics: FrozenStatistics,
    /// Numbers that products of training are made of: `f32` (default), or `bf16` where the processor has AVX512-BF16.
    /// Predictions are made in f32 either way.
    #[serde(skip_serializing_if = "crate::json_file::is_default")]
    pub precision: Precision,
    /// Random changes to training images, tensors and readings, anew in every epoch. Default nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub augment: Option<Augment>,
    /// Faults that training samples meet, drawn anew in every epoch, before any encoding. Default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faults: Option<TrainingFaults>,
}

impl Default for Recipe {
    fn default() -> Self {
        Recipe {
            epochs: 100,
            batch_size: 64,
            least_steps: None,
            least_batches: None,
            loss: None,
            optimizer: Optimizer::default(),
            schedule: Schedule::default(),
            warm_up: 0.0,
            batch_norm: BatchNorm::default(),
            init: Scheme::default(),
            label_smoothing: 0.0,
            class_weights: ClassWeights::default(),
            clip: None,
            early_stopping: None,
            frozen: vec![],
            frozen_statistics: FrozenStatistics::default(),
            precision: Precision::default(),
            augment: None,
            faults: None,
        }
    }
}

/// Samples of the smallest batch that [`Recipe::least_batches`] makes.
const SMALLEST_BATCH: usize = 8;

impl Recipe {
    /// Returns the recipe for so many training samples: epochs and batches as the least numbers of steps and batches
    /// ask.
    pub fn for_samples(&self, samples: usize) -> Recipe {
        let mut recipe = self.clone();
        if let Some(batches) = recipe.least_batches.take() {
            recipe.batch_size = recipe.batch_size.min((samples / batches.max(1)).max(SMALLEST_BATCH));
        }
        if let Some(steps) = recipe.least_steps.take() {
            let per_epoch = samples.div_ceil(recipe.batch_size.max(1)).max(1);
            recipe.epochs = recipe.epochs.max(steps.div_ceil(per_epoch));
        }
        recipe
    }

    /// Returns the loss that it trains `task` with: its own, or the default of the task.
    pub fn loss_for(&self, task: &Task) -> Loss {
        self.loss.unwrap_or(match task {
            Task::Classes(_) => Loss::SoftmaxCrossEntropy,
            Task::Levels(_) => Loss::MultiLabelSoftMargin,
            Task::Values(_) => Loss::Huber,
        })
    }

    /// Returns the number of outputs that learn one quantity of `task`; 1 of classes and levels.
    pub fn outputs_per_target(&self, task: &Task) -> usize {
        self.loss_for(task).outputs_per_target()
    }

    /// Returns the recipe with the loss of `task` said.
    pub fn for_task(&self, task: &Task) -> Recipe {
        Recipe { loss: Some(self.loss_for(task)), ..self.clone() }
    }

    /// Returns the learning rate of `epoch`, from 0.
    pub fn rate(&self, epoch: usize) -> f64 {
        let lr = self.optimizer.lr();
        let rising = (self.warm_up * self.epochs as f64).ceil() as usize;
        match epoch.checked_sub(rising) {
            None => lr * (epoch + 1) as f64 / rising as f64,
            Some(epoch) => self.schedule.rate(lr, epoch, self.epochs.saturating_sub(rising)),
        }
    }

    /// Checks all settings.
    ///
    /// # Errors
    /// The first setting outside its range.
    pub fn check(&self) -> Check {
        within("epochs", self.epochs, 1, 100_000)?;
        within("batch_size", self.batch_size, 1, LARGEST_BATCH)?;
        if let Some(steps) = self.least_steps {
            within("least_steps", steps, 1, 10_000_000)?;
        }
        if let Some(batches) = self.least_batches {
            within("least_batches", batches, 1, LARGEST_BATCH)?;
        }
        let reason = "must be a share of the epochs, in [0, 1)";
        require((0.0..1.0).contains(&self.warm_up), "warm_up", self.warm_up, reason)?;
        self.optimizer.check().map_err(|problem| problem.below("optimizer"))?;
        self.schedule.check().map_err(|problem| problem.below("schedule"))?;
        self.check_targets()?;
        if let Err(reason) = taxel_engine::supports(self.precision) {
            require(false, "precision", "\"bf16\"", reason.to_string())?;
        }
        if let Some(augment) = &self.augment {
            augment.check().map_err(augment_problem)?;
        }
        if let Some(faults) = &self.faults {
            faults.check().map_err(fault_problem)?;
        }
        if let Some(clip) = self.clip {
            let positive = (clip as f32) > 0.0 && clip.is_finite();
            require(positive, "clip", clip, "must be positive and finite, usually 0.1 to 10")?;
        }
        if let Some(stopping) = &self.early_stopping {
            within("early_stopping.patience", stopping.patience, 1, 100_000)?;
            share("early_stopping.validation", stopping.validation)?;
            stopping.by.check("early_stopping.by")?;
        }
        Ok(())
    }

    fn check_targets(&self) -> Check {
        let smoothing = self.label_smoothing;
        require((0.0..1.0).contains(&smoothing), "label_smoothing", smoothing, "must be in [0, 1)")?;
        if self.loss.is_none_or(|loss| loss == Loss::SoftmaxCrossEntropy) {
            return Ok(());
        }
        let reason = "works with loss = \"softmax-cross-entropy\" only; leave it out";
        require(smoothing == 0.0, "label_smoothing", smoothing, reason)?;
        require(self.class_weights == ClassWeights::None, "class_weights", "\"balanced\"", reason)
    }
}
