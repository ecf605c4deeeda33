//! The record of one epoch.

use serde::{Deserialize, Serialize};

/// One line of `metrics.jsonl`, less its keys.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// Epoch, from 0.
    pub epoch: usize,
    /// Learning rate.
    pub lr: f64,
    /// Mean loss over the training samples, each as it was seen in this epoch.
    pub train_loss: f64,
    /// The primary metric on them, in its unit.
    #[serde(alias = "train_accuracy")]
    pub train_score: f64,
    /// Mean loss over the validation part after this epoch, where early stopping needs it; without label
    /// smoothing and class weights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation_loss: Option<f64>,
    /// The primary metric on the validation part, in its unit.
    #[serde(default, alias = "validation_accuracy", skip_serializing_if = "Option::is_none")]
    pub validation_score: Option<f64>,
}
