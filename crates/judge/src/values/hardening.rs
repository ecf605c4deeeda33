//! Fault-augmented networks beside the same networks trained on clean samples.

use serde::{Deserialize, Serialize};
use taxel_faults::Fault;

/// A fault-augmented row, beside the same one trained on clean samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hardened {
    /// The fault-augmented row.
    pub network: String,
    /// The row that was trained on clean samples.
    pub clean: String,
    /// Primary metric on clean samples: trained clean, fault-augmented.
    #[serde(rename = "accuracy", alias = "scores")]
    pub scores: [f64; 2],
    /// The second less the first.
    #[serde(rename = "accuracy_change", alias = "score_change")]
    pub score_change: Change,
    /// Loss under faults, mean over faults and severities: trained clean, fault-augmented.
    pub loss: [f64; 2],
    /// The second less the first; below 0 if fault augmentation helps.
    pub loss_change: Change,
    /// Seconds of training per fold: clean, under faults.
    pub train_seconds: [f64; 2],
    /// Loss under faults that were left out of its training.
    #[serde(rename = "unmet")]
    pub unseen: Vec<UnseenFault>,
}

/// A paired difference over folds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// In percentage points, or in the metric's unit.
    pub mean: f64,
    /// 95 % interval of the mean (Nadeau & Bengio 2003); none of a single fold.
    pub interval: Option<[f64; 2]>,
}

/// One fault, and three trainings of one network: what it costs, mean over severities.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UnseenFault {
    /// The fault.
    pub fault: Fault,
    /// Trained on clean samples.
    pub clean: f64,
    /// Trained under all faults but this one.
    #[serde(rename = "unmet")]
    pub unseen: f64,
    /// Trained under all faults.
    #[serde(rename = "met")]
    pub seen: f64,
}

impl Hardened {
    /// Counts the faults that cost less after a training without them than after a clean one.
    pub fn helped(&self) -> usize {
        self.unseen.iter().filter(|probe| probe.unseen < probe.clean).count()
    }
}
