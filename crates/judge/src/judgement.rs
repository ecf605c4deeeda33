//! What is known about one run, ready to be shown: plain values, written as `judgement.json`.

use serde::{Deserialize, Serialize};
use taxel_trainer::{Environment, NetworkResults, Results};

use crate::speed::Speed;
use crate::stress::Stress;

/// What accuracies were measured on; never mixed with published numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A scene of taxel.
    Simulated,
    /// Recordings.
    Real,
}

/// Everything that a report says about one run folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Protocol, classes, source; `networks` is empty here, scores are in [`Judgement::networks`].
    pub results: Results,
    /// What the scores were measured on.
    pub kind: Kind,
    /// Protocol in words.
    pub protocol: String,
    /// Machine, code and data of the run.
    pub environment: Environment,
    /// Machine and code of this judgement: speeds were measured here.
    pub judged_on: Environment,
    /// Share in % that is right by always naming the commonest class.
    pub chance: f64,
    /// In the order of the config, baselines behind.
    pub networks: Vec<Judged>,
    /// Accuracy under faults; none where it was not asked for.
    pub stress: Option<Stress>,
    /// Some test samples with what networks say about them.
    pub examples: Vec<Example>,
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
    /// Measured here; none for a network without a saved model.
    pub speed: Option<Speed>,
    /// Seconds of training per fold, mean over finished folds.
    pub train_seconds: f64,
    /// Seconds of one epoch, mean over finished folds; none for baselines.
    pub epoch_seconds: Option<f64>,
    /// Expected calibration error over the test parts, 0 to 1, mean over folds.
    pub calibration_error: f64,
    /// Whether no other is at least as accurate and faster, or as fast and more accurate.
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
    /// In %.
    pub train_accuracy: f64,
    /// Mean loss over the validation part, where there is one.
    pub validation_loss: Option<f64>,
    /// In %.
    pub validation_accuracy: Option<f64>,
}

/// A test sample, what networks see of it and say about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// `fingertip[17]`, or a file.
    pub origin: String,
    /// Its class; with several attributes `elasticity:3, hardness:7`.
    pub truth: String,
    /// The raw sample first, then each encoding.
    pub pictures: Vec<Picture>,
    /// What each network says.
    pub verdicts: Vec<Verdict>,
}

/// What a network says about a sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name in the experiment.
    pub network: String,
    /// Like [`Example::truth`].
    pub predicted: String,
    /// Probability of it, 0 to 1 (of several attributes the smallest).
    pub probability: f64,
    /// Whether it is right.
    pub right: bool,
}

/// How [`Picture::values`] are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PictureKind {
    /// `[C, T]`: one line per channel.
    Lines,
    /// `[H, W]`: one grey or coloured image; scaled from its least to its largest value.
    Grey,
    /// `[3, H, W]`: red, green, blue.
    Colour,
    /// `[K, H, W]`: some frames of a sequence, from early to late.
    Frames,
}

/// An array to be drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// `reading`, or the name of an input.
    pub name: String,
    /// How it is drawn.
    pub kind: PictureKind,
    /// As `kind` says.
    pub shape: Vec<usize>,
    /// Row-major.
    pub values: Vec<f32>,
}
