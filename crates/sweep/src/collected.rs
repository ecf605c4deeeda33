//! Results of many trials, ready to be shown.

use serde::{Deserialize, Serialize};

use taxel_judge::{Across, Primary};

/// Many trials of one study.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Name of the study.
    pub name: String,
    /// How far it is.
    pub progress: SweepProgress,
    /// Each network with each of its settings on each data set, the best of a data set first.
    pub settings: Vec<Setting>,
    /// Effects of the varied keys.
    pub axes: Vec<KeyEffect>,
    /// The first trials without a result, failed ones before others; [`SweepProgress::open`] says how many there are.
    pub open: Vec<OpenTrial>,
    /// Networks with their settings ranked over data sets, where there are enough of both.
    pub across: Option<Across>,
    /// Notes for the reader, in sentences.
    pub notes: Vec<String>,
}

/// How far a sweep is. Each trial counts once, however often the manifest names it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepProgress {
    /// Trials of the manifest.
    pub planned: usize,
    /// With a result.
    pub finished: usize,
    /// That could not be run.
    pub failed: usize,
    /// That somebody took up.
    pub begun: usize,
    /// That nobody took up yet.
    pub missing: usize,
    /// Lines of the manifest that name a trial again.
    pub duplicates: usize,
    /// Seconds of the finished trials together.
    pub seconds: f64,
}

impl SweepProgress {
    /// Counts the trials without a result.
    pub fn open(&self) -> usize {
        self.failed + self.begun + self.missing
    }
}

/// One network with its settings on one data set, over all seeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// The samples.
    pub source: String,
    /// The network or baseline.
    pub network: String,
    /// Varied keys and their values, the seed left out.
    pub set: String,
    /// The metric of the scores.
    #[serde(default, skip_serializing_if = "Primary::is_accuracy")]
    pub primary: Primary,
    /// That metric over its trials.
    #[serde(rename = "accuracy", alias = "score")]
    pub score: ScoreSpread,
}

/// Several values of one thing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScoreSpread {
    /// How many.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// Sample standard deviation (n - 1); none of one value.
    pub sd: Option<f64>,
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub most: f64,
}

/// Effect of one varied key, averaged over everything else.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeyEffect {
    /// The dotted key.
    pub key: String,
    /// The metric of the scores.
    #[serde(default, skip_serializing_if = "Primary::is_accuracy")]
    pub primary: Primary,
    /// Network, value, score; networks in the order of the configs, values in that of the plan.
    pub rows: Vec<(String, String, ScoreSpread)>,
}

/// A trial without a result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenTrial {
    /// Position in the manifest, from 0.
    pub number: usize,
    /// Name, settings and fold.
    pub trial: String,
    /// `failed`, `begun` or `missing`.
    pub state: String,
    /// Why it failed.
    pub reason: String,
}
