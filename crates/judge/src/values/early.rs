//! Scores of predictions for windows of which only the start is there.

use serde::{Deserialize, Serialize};
use taxel_data::Padding;

/// Every network on the starts of test samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Early {
    /// Test samples behind every score, over all folds of the first repetition.
    pub samples: usize,
    /// Test samples that there are; more than `samples` where some were left out for time.
    pub of: usize,
    /// Readings of a sample along time.
    pub ticks: usize,
    /// How starts are filled up to whole samples.
    pub padding: Padding,
    /// In the order of the run.
    pub networks: Vec<EarlyNetwork>,
}

/// One network on the starts of test samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EarlyNetwork {
    /// Name in the experiment.
    pub network: String,
    /// By the share of the sample that is there.
    pub points: Vec<EarlyPoint>,
    /// By the confidence at which it decides; empty of values, which have no probability.
    pub decisions: Vec<EarlyDecisions>,
}

/// Predictions for starts of samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EarlyPoint {
    /// Share of the sample that is there, in %: 10 to 100.
    pub seen: u8,
    /// The primary metric, in its unit.
    #[serde(rename = "accuracy", alias = "score")]
    pub score: f64,
    /// Starts that an encoding refused; they count as wrong, of values as the mean.
    pub refused: usize,
}

/// Predictions at the first start of each sample that the network is confident about, else at its end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EarlyDecisions {
    /// The least probability of the likeliest class, of every attribute, 0 to 1.
    pub confidence: f64,
    /// Accuracy in %.
    #[serde(rename = "accuracy", alias = "score")]
    pub score: f64,
    /// Share of the samples that was there, in %, mean over samples.
    pub seen: f64,
    /// Share of samples decided before their end, in %.
    pub early: f64,
}
