//! How a training is made: threads, savings, resuming.

use crate::environment::cores;

/// Seconds between two savings of a fold in training, where nothing else is said.
const SAVE_EVERY: f64 = 10.0;

/// How a run is made; none of it changes a result.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunOptions {
    /// Whether the folder may hold the same run already: its finished folds are kept, and a fold in training
    /// goes on where it was saved.
    pub resume: bool,
    /// Worker threads. Default one per core.
    pub threads: Option<usize>,
    /// Seconds between two savings of a fold in training. Default 10; never more than a twentieth of the
    /// time is spent on it.
    pub save_every: Option<f64>,
}

/// So many worker threads as are asked for, else one per core; at least one.
pub fn threads(asked: Option<usize>) -> usize {
    asked.unwrap_or_else(cores).max(1)
}

impl RunOptions {
    /// Worker threads, at least one.
    pub fn threads(&self) -> usize {
        threads(self.threads)
    }

    /// Seconds between two savings.
    pub fn save_every(&self) -> f64 {
        self.save_every.unwrap_or(SAVE_EVERY)
    }
}
