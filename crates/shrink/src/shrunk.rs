//! How little of the sensing and of a network suffices.

use serde::{Deserialize, Serialize};
use taxel_judge::{Contrast, Primary};

/// One setting of a curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveStep {
    /// The rest, in words: `3 of 5 channels`.
    pub label: String,
    /// The same for an axis of a chart: `3`.
    pub short: String,
    /// Sensors kept, where folds choose for themselves: one entry per outer fold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kept: Vec<String>,
    /// On inner folds of the training parts: by this the knee is found.
    pub inner: Option<Contrast>,
    /// On the test parts, each predicted once: by this the knee is reported.
    pub outer: Option<Contrast>,
    /// That it could not be trained or was not tried, and why, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

/// Less and less of one thing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// The quantity that is reduced: `sensors`, `rate`, …
    pub axis: String,
    /// The same as a heading.
    pub title: String,
    /// The unreduced quantity, in words: `5 channels`.
    pub whole: String,
    /// The same for an axis of a chart.
    pub short: String,
    /// From the largest to the smallest.
    #[serde(rename = "rungs")]
    pub steps: Vec<CurveStep>,
    /// The smallest that suffices, by position; none where all is needed.
    pub knee: Option<usize>,
    /// The knee in a sentence, with its evidence.
    #[serde(default)]
    pub words: String,
}

/// Reads, scores and costs of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelSummary {
    /// Which of the two.
    pub name: String,
    /// Part of a recording that it reads, in words.
    pub reads: String,
    /// Values of a raw sample that it reads.
    pub readings: usize,
    /// Primary metric of its recipe on the test parts, in its unit.
    #[serde(rename = "accuracy", alias = "score")]
    pub score: f64,
    /// 95 % interval of it.
    #[serde(rename = "accuracy_interval", alias = "score_interval")]
    pub score_interval: Option<[f64; 2]>,
    /// Trained values.
    pub parameters: u64,
    /// Multiply-accumulates of one prediction.
    pub macs: u64,
    /// Bytes of parameters and batch-norm statistics in f32.
    pub bytes: u64,
}

/// Time of a prediction by each model, from raw recording to prediction, on one thread: it differs from machine to
/// machine, and is kept apart from the rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SmallSpeed {
    /// Half of the predictions of the whole took no longer, in ms.
    pub whole_p50_ms: f64,
    /// 95 % did not.
    pub whole_p95_ms: f64,
    /// Half of those of the smaller model took no longer, in ms.
    pub small_p50_ms: f64,
    /// 95 % did not.
    pub small_p95_ms: f64,
}

/// All knees together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Combined {
    /// The rest on each axis, in words.
    pub parts: Vec<String>,
    /// Combinations that were tried before on inner folds and lost too much, in words.
    pub loosened: Vec<String>,
    /// On inner folds.
    pub inner: Option<Contrast>,
    /// On the test parts.
    pub outer: Contrast,
}

/// How little of the sensing and of a network suffices, by one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shrunk {
    /// Name of the run.
    pub run: String,
    /// The network or baseline.
    pub network: String,
    /// `simulated: ..` or `real: ..`.
    pub source: String,
    /// Samples.
    pub samples: usize,
    /// How the run was divided, in words.
    pub protocol: String,
    /// Test parts that were used.
    pub parts: usize,
    /// Inner folds of each training part.
    pub inner: usize,
    /// The metric of the scores.
    #[serde(default, skip_serializing_if = "Primary::is_accuracy")]
    pub primary: Primary,
    /// A loss that would matter, in percentage points or in the metric's unit.
    pub margin: f64,
    /// Level of significance over a curve.
    pub alpha: f64,
    /// Where time was saved, and combinations that could not be trained, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The whole on the test parts: primary metric, and its 95 % interval.
    pub whole: (f64, Option<[f64; 2]>),
    /// One curve per axis.
    pub curves: Vec<Curve>,
    /// Axes that were left out, and why.
    pub left_out: Vec<(String, String)>,
    /// The knees together; none where nothing may go.
    pub combined: Option<Combined>,
    /// The whole and the smaller model; empty where nothing may go.
    pub models: Vec<ModelSummary>,
    /// The result in sentences.
    pub words: Vec<String>,
}
