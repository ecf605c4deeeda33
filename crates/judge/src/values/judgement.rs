//! Everything measured about one run, ready to be shown: plain values, written as `judgement.json`.

use serde::{Deserialize, Serialize};
use taxel_data::SourceKind;
use taxel_learn::{Environment, NetworkResults, Results};

use super::certainty::RowCertainty;
use super::early::Early;
use super::eight_bits::Changed;
use super::errors::RowErrors;
use super::example::Example;
use super::importance::Importance;
use super::learning_curve::LearningCurve;
use super::primary::Primary;
use super::speed::Speed;
use super::stress::Stress;

/// Everything that a report says about one run folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Protocol, classes, source; `networks` is empty here, scores are in [`Judgement::networks`].
    pub results: Results,
    /// Protocol in words.
    pub protocol: String,
    /// Machine, code and data of the run.
    pub environment: Environment,
    /// Machine and code of this judgement: speeds were measured here.
    pub judged_on: Environment,
    /// Primary metric of always naming the commonest class, or of always giving the mean.
    pub chance: f64,
    /// In the order of the config, baselines behind.
    pub networks: Vec<Judged>,
    /// Rows that were trained under all faults but one, for the scores under unseen faults ([`Stress::unseen`]).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probes: Vec<NetworkResults>,
    /// Predictions that eight bits change, one value for each row in eight bits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changed: Vec<Changed>,
    /// Scores under faults; none without a stress test.
    pub stress: Option<Stress>,
    /// Scores on the starts of samples; none where samples have no time, or where it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub early: Option<Early>,
    /// How far probabilities can be believed, row by row; empty of values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub certainty: Vec<RowCertainty>,
    /// How far values lie from the true ones, row by row; empty of classes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<RowErrors>,
    /// The parts that the decisions of the best row rest on; none in judgements of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub importance: Option<Importance>,
    /// The gain of more training recordings; none where nobody asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learning_curve: Option<LearningCurve>,
    /// Some test samples with what networks say about them.
    pub examples: Vec<Example>,
}

impl Judgement {
    /// Returns whether scores were measured on simulated or on real samples; never mixed with published numbers.
    pub fn kind(&self) -> SourceKind {
        self.results.source.kind
    }

    /// Returns the metric that networks are compared by.
    pub fn primary(&self) -> Primary {
        Primary::of(&self.results.task)
    }

    /// Counts the folds that resuming the run would finish: missing, and not because their training diverged.
    pub fn unfinished(&self) -> usize {
        let stopped = self.networks.iter().map(|network| network.results.stopped()).sum();
        self.results.missing.len().saturating_sub(stopped)
    }

    /// Returns the row that was trained as this one, but on clean samples: it is as fast, whatever clocks say.
    pub fn clean_twin(&self, row: &Judged) -> Option<&Judged> {
        self.network(row.results.hardening.as_ref()?.clean.as_deref()?)
    }

    /// Returns the network or baseline of that name.
    pub fn network(&self, name: &str) -> Option<&Judged> {
        self.networks.iter().find(|network| network.results.network == name)
    }
}

impl Judged {
    /// Returns the primary metric, mean over folds; none without a finished fold.
    pub fn score(&self) -> Option<f64> {
        self.results.primary()
    }
}

/// One network or baseline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Scores, costs, confusion, published numbers.
    #[serde(flatten)]
    pub results: NetworkResults,
    /// Whether it is a baseline and no network.
    pub baseline: bool,
    /// Names of the inputs that it reads: `signal`, `image`, `tensor`; `series` for baselines.
    pub inputs: Vec<String>,
    /// Nodes whose weights training left as they were.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frozen: Vec<String>,
    /// Measured here; none for the smaller rows of a learning curve.
    pub speed: Option<Speed>,
    /// Seconds of training per fold, mean over finished folds.
    pub train_seconds: f64,
    /// Seconds of one epoch, mean over finished folds; none for baselines.
    pub epoch_seconds: Option<f64>,
    /// Expected calibration error over the test parts, 0 to 1, mean over folds; none of values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration_error: Option<f64>,
    /// Whether no other is at least as good and faster, or as fast and better.
    pub on_front: bool,
    /// Mean over folds, epoch by epoch; empty for baselines.
    pub training: Vec<EpochPoint>,
}

/// One epoch, mean over the folds that got so far.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EpochPoint {
    /// From 0.
    pub epoch: usize,
    /// Mean loss over the training samples.
    pub train_loss: f64,
    /// The primary metric, in its unit.
    #[serde(rename = "train_accuracy", alias = "train_score")]
    pub train_score: f64,
    /// Mean loss over the validation part, where there is one.
    pub validation_loss: Option<f64>,
    /// The metric of early stopping, in its unit.
    #[serde(rename = "validation_accuracy", alias = "validation_score")]
    pub validation_score: Option<f64>,
}
