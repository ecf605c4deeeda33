//! Networks in eight bits beside the same in floats.

use serde::{Deserialize, Serialize};

/// Test samples of the first repetition whose prediction differs between a network in floats and the same in eight bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Changed {
    /// The row in eight bits.
    pub network: String,
    /// The row in floats.
    pub floats: String,
    /// Samples that both predicted.
    pub samples: u64,
    /// Samples with another prediction, right or wrong.
    pub differ: u64,
    /// Samples that only the row in floats predicts rightly, and only the one in eight bits; of several attributes all
    /// count. Of values samples that the one or the other comes nearer to.
    pub only: [u64; 2],
}

/// A network in eight bits beside the same in floats; pairs are floats, eight bits.
#[derive(Debug, Clone, PartialEq)]
pub struct EightBits {
    /// The row in floats.
    pub network: String,
    /// Primary metric, mean over folds.
    pub scores: [f64; 2],
    /// Predictions that differ, sample by sample.
    pub changed: Changed,
    /// Exact McNemar test of that.
    pub p: f64,
    /// Loss under faults, mean over faults and severities; none without a stress test.
    pub loss: Option<[f64; 2]>,
    /// Median time of a prediction, encoding included, in ms; none where it was not measured.
    pub latency: Option<[f64; 2]>,
    /// Bytes of parameters and batch-norm statistics.
    pub bytes: [u64; 2],
}
