//! Two models, or rows of runs, on the same samples.

use serde::{Deserialize, Serialize};

use super::choice::Test;
use super::primary::Primary;

/// Two models, or rows of runs, on the same samples: `a` and `b`, in this order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SideBySide {
    /// Their names.
    pub names: [String; 2],
    /// The metric of the scores.
    #[serde(default, skip_serializing_if = "Primary::is_accuracy")]
    pub primary: Primary,
    /// Samples that both predicted, each counted once.
    pub samples: usize,
    /// Groups of these samples; none where they are not grouped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub groups: Option<usize>,
    /// Test parts that are compared as wholes; 1 of two models.
    pub parts: usize,
    /// The primary metric of each, mean over the parts.
    pub scores: [f64; 2],
    /// Score of `a` less that of `b`.
    pub difference: f64,
    /// Its 95 % interval.
    pub interval: Option<[f64; 2]>,
    /// Two-sided.
    pub p: Option<f64>,
    /// The test that gave it.
    pub test: Test,
    /// Samples, or groups where whole groups are tested, that would show a difference of this size in four of five cases; none where it is
    /// shown already, and where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deciding: Option<u64>,
    /// Whether these are groups.
    pub deciding_groups: bool,
    /// Samples by who is right; none of values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<Right>,
    /// Which is better where: class by class, of values by parts of their range.
    pub places: Vec<Place>,
    /// Costs of each.
    pub costs: [SideCosts; 2],
}

/// Samples by who is right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Right {
    /// Both.
    pub both: usize,
    /// The first one only, the second one only.
    pub only: [usize; 2],
    /// Neither.
    pub neither: usize,
}

/// A class, or a part of the range of a quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The attribute or quantity; empty where there is one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub of: String,
    /// `cup`, or of values `2.1 to 4.7 N`.
    pub name: String,
    /// Its samples.
    pub samples: usize,
    /// Share of right samples in %, or the mean absolute error in the unit of the quantity.
    pub scores: [f64; 2],
    /// Samples that only one gets right, or that it is closer to.
    pub only: [usize; 2],
}

/// Costs of one of the two.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SideCosts {
    /// Trained values.
    pub parameters: u64,
    /// Bytes of the model's file.
    pub bytes: u64,
    /// Multiply-accumulates of one sample; none of a baseline in a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub macs: Option<u64>,
    /// Median time of one raw sample on one thread, in ms; none where it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ms: Option<f64>,
}
