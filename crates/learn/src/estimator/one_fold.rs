//! One training on chosen samples, tested on others; nothing is written.

use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Fold};

use crate::encoding::Encoder;
use crate::error::Result;
use crate::estimator::candidate::Candidate;
use crate::estimator::train_fold::{FoldJob, train_fold};
use crate::model::Model;
use crate::run::protocol::Protocol;
use crate::run::records::{FoldKey, FoldRecord};
use crate::training::feature_cache::FeatureCache;
use crate::training::hooks::Hooks;
use crate::training::session::Saver;
use crate::training::teacher::Teacher;

/// One training on chosen samples.
pub struct OneFold<'a> {
    /// The network or baseline.
    pub candidate: &'a Candidate,
    /// Says which samples early stopping and a search keep together.
    pub protocol: &'a Protocol,
    /// Seed of every random choice, which depends on repetition and fold of the key too.
    pub seed: u64,
    /// Which training it is; its record bears the name.
    pub key: FoldKey,
    /// Samples to train on, to validate with, and to test; the last may be none.
    pub fold: &'a Fold,
    /// Whose predictions it learns from beside the labels; baselines do not listen.
    pub teacher: Option<&'a Teacher>,
    /// Worker threads; results do not depend on them.
    pub threads: usize,
}

/// A finished training.
pub struct Tested {
    /// Its predictions for the test samples.
    pub record: FoldRecord,
    /// The trained model.
    pub model: Model,
}

impl OneFold<'_> {
    /// Trains and tests; `None` if `cancel` was set. The encoder has prepared the candidate's inputs. `tick` hears how
    /// many samples each step took.
    ///
    /// # Errors
    /// Samples that the network does not take, training that diverges.
    pub fn run(
        &self,
        encoder: &Encoder,
        tick: &mut dyn FnMut(usize),
        cancel: &AtomicBool,
    ) -> Result<Option<Tested>> {
        let OneFold { candidate, protocol, seed, ref key, fold, teacher, threads } = *self;
        candidate.check_samples(fold.train.len(), encoder)?;
        let cache = FeatureCache::default();
        let place = Some((key.repetition, key.fold));
        let job = FoldJob {
            candidate,
            protocol,
            seed,
            place,
            fold,
            threads,
            teacher,
            cache: &cache,
            is_timed: false,
        };
        let mut saver = Saver::none();
        let trained = train_fold(&job, encoder, &mut Hooks { tick, cancel, saver: &mut saver })?;
        let Some(trained) = trained else { return Ok(None) };
        let record = trained.record(key, encoder.dataset(), fold, None)?;
        Ok(Some(Tested { record, model: trained.model }))
    }
}

/// Folds of the training part of `outer` alone, by the protocol's own rule: with groups no group is in two parts,
/// elsewhere classes are spread evenly and copies stay together. Rows are those of the whole data set.
///
/// # Errors
/// A training part of a single group, or of too few samples.
pub fn inner_folds(
    protocol: &Protocol,
    dataset: &Dataset,
    outer: &Fold,
    folds: usize,
    seed: u64,
    repetition: usize,
) -> Result<Vec<Fold>> {
    let inner = protocol.inner(folds, dataset, &outer.train)?;
    let cut = inner.folds(&dataset.select(&outer.train), seed, repetition)?;
    let whole = |rows: Vec<usize>| rows.into_iter().map(|row| outer.train[row]).collect();
    let whole = |fold: Fold| Fold {
        train: whole(fold.train),
        test: whole(fold.test),
        validation: whole(fold.validation),
    };
    Ok(cut.into_iter().map(whole).collect())
}
