//! Time that the prediction of one sample takes.

use serde::{Deserialize, Serialize};
use taxel_learn::Latency;

/// Times of one sample on one thread, batch 1, and of whole batches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// Encoding alone.
    pub encoding: Latency,
    /// The network alone.
    pub network: Latency,
    /// From raw reading to probabilities.
    pub whole: Latency,
    /// Encoded samples per second, in batches of `batch` on one thread.
    pub samples_per_second: f64,
    /// The batch of training.
    pub batch: usize,
}
