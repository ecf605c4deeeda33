//! How far the probabilities of a row can be believed.

use serde::{Deserialize, Serialize};
use taxel_learn::certainty::{Certainty, Reliability};

/// One row: what is fitted to its test parts, and what it does with classes that it has not learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RowCertainty {
    /// Name in the experiment.
    pub network: String,
    /// As a model that is fitted from this run bears it, without its gate.
    pub certainty: Certainty,
    /// Answers sorted by how sure they are, each part at the temperature of the others.
    pub reliability: Reliability,
    /// Where the run was tried on classes that were not learned: means over the draws.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unknown: Option<UnknownMeans>,
}

/// Means over draws of classes that a row was trained without.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UnknownMeans {
    /// Number of draws.
    pub draws: usize,
    /// Probability that a sample of an unknown class is farther than one of a known class, 0..1.
    pub auroc: f64,
    /// The same of the highest probability alone, 0..1.
    pub auroc_softmax: f64,
    /// Share of the samples of unknown classes that are answered as unknown, 0..1.
    pub refused: f64,
    /// Share of the samples of known classes that are, 0..1.
    pub false_alarms: f64,
}
