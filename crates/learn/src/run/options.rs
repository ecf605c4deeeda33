//! How a training is made: threads, savings, resuming, which folds.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::run::environment::cores;
use crate::run::records::FoldKey;

/// Seconds between two savings of a fold in training, where nothing else is said.
const SAVE_EVERY: f64 = 10.0;

/// How a run is made; none of it changes a score.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// Whether the folder may hold the same run already: its finished folds are kept, and a fold in training
    /// goes on where it was saved.
    pub resume: bool,
    /// Whether the predictions of finished folds are timed once more, on this machine as it is now, such as one that was
    /// busy before.
    pub time_again: bool,
    /// Worker threads, at most one per core, however many are asked for. Default one per core.
    pub threads: Option<usize>,
    /// Seconds between two savings of a fold in training. Default 10; never more than a twentieth of the
    /// time is spent on it.
    pub save_every: Option<f64>,
    /// The folds to train and test; the others stay missing. Default all.
    pub only: Option<Vec<FoldKey>>,
    /// Set from outside to end the run as soon as the epoch under way is over and saved. A set `cancel` does not
    /// wait for that. Default never.
    pub stop: Option<Arc<AtomicBool>>,
}

/// Returns the number of worker threads: as many as are asked for, at most one per core, at least one; without a
/// word one per core.
pub fn threads(wanted: Option<usize>) -> usize {
    wanted.unwrap_or(usize::MAX).clamp(1, cores())
}

impl RunOptions {
    /// Returns the number of worker threads, from one to one per core.
    pub fn threads(&self) -> usize {
        threads(self.threads)
    }

    /// Seconds between two savings.
    pub fn save_every(&self) -> f64 {
        self.save_every.unwrap_or(SAVE_EVERY)
    }

    /// Checks whether a fold is to be trained and tested.
    pub(crate) fn wants(&self, key: &FoldKey) -> bool {
        self.only.as_ref().is_none_or(|only| only.contains(key))
    }

    /// Checks whether the run is to end after its next saving.
    pub(crate) fn is_stopping(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_from_one_to_one_per_core() {
        assert_eq!([None, Some(99_999), Some(cores())].map(threads), [cores(); 3]);
        assert_eq!([Some(0), Some(1)].map(threads), [1; 2]);
        let options = RunOptions { threads: Some(99_999), ..RunOptions::default() };
        assert_eq!(options.threads(), cores());
    }
}
