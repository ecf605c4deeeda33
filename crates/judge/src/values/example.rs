//! A test sample that is worth a look.

use serde::{Deserialize, Serialize};
use taxel_report::pictures::ArrayPicture;

/// A test sample, what networks see of it and say about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// `fingertip[17]`, or a file.
    pub origin: String,
    /// Its class; with several attributes `elasticity:3, hardness:7`; of values `1.25 N`.
    pub truth: String,
    /// The raw sample first, then each encoding.
    pub pictures: Vec<ArrayPicture>,
    /// Predictions of the networks.
    pub verdicts: Vec<Verdict>,
}

/// Prediction of a network for a sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name in the experiment.
    pub network: String,
    /// Like [`Example::truth`].
    pub predicted: String,
    /// Probability of it, 0 to 1 (of several attributes the smallest); none of values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// Whether it is right; none of values, which are more or less so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<bool>,
}
