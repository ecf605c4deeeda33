//! What happened in one epoch.

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
    /// Share of them that was right, in %.
    pub train_accuracy: f64,
    /// Mean loss over the validation part after this epoch, where early stopping needs it; without label
    /// smoothing and class weights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation_loss: Option<f64>,
    /// Share of the validation part that was right, in %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation_accuracy: Option<f64>,
}
