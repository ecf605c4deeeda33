//! Which training of an experiment something random belongs to.

use rand::seq::SliceRandom;

use crate::error::Result;

/// Which training of an experiment: every random choice depends on it and on nothing else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrainingKey {
    /// Seed of the experiment.
    pub seed: u64,
    /// Repetition, from 0.
    pub repetition: usize,
    /// Fold, from 0.
    pub fold: usize,
}

impl TrainingKey {
    /// Returns the key of the training on all samples: no fold has this number.
    pub fn everything(seed: u64) -> Self {
        TrainingKey { seed, repetition: 0, fold: u32::MAX as usize }
    }

    /// Returns the keyed generator's word for a random choice of this training.
    pub fn purpose(&self, what: &str) -> String {
        format!("{what}/r{}/f{}", self.repetition, self.fold)
    }

    /// Returns `rows` in the order in which an epoch visits them.
    pub fn shuffled(&self, rows: &[usize], epoch: usize) -> Vec<usize> {
        self.shuffle(rows, &format!("{}/e{epoch}", self.purpose("shuffle")))
    }

    /// Returns `rows` in an order drawn for `purpose`.
    pub fn shuffle(&self, rows: &[usize], purpose: &str) -> Vec<usize> {
        let mut order = rows.to_vec();
        order.shuffle(&mut taxel_base::seed::rng(self.seed, purpose));
        order
    }
}

/// Returns the order in which an epoch visits the training samples: a function of its arguments alone.
pub fn shuffled(train: &[usize], seed: u64, repetition: usize, fold: usize, epoch: usize) -> Vec<usize> {
    TrainingKey { seed, repetition, fold }.shuffled(train, epoch)
}

/// Threads for what spreads over rayon's.
///
/// # Errors
/// Threads that cannot be started.
pub(crate) fn pool(threads: usize) -> Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| taxel_engine::Error::Threads { threads, reason: e.to_string() }.into())
}
