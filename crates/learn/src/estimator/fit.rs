//! A network or baseline trained on all samples: what is shipped.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Fold};

use crate::encoding::{Encoder, Encoding};
use crate::error::Result;
use crate::estimator::candidate::Candidate;
use crate::estimator::train_fold::{FoldJob, train_fold};
use crate::model::Model;
use crate::run::options::RunOptions;
use crate::run::protocol::Protocol;
use crate::training::feature_cache::FeatureCache;
use crate::training::hooks::Hooks;
use crate::training::session::Saver;

/// A training on all samples of a data set.
pub struct Fit<'a> {
    /// The network or baseline.
    pub candidate: &'a Candidate,
    /// Says which samples early stopping and a search keep together when they hold some back: the protocol's groups or
    /// exact copies.
    pub protocol: &'a Protocol,
    /// Seed of every random choice.
    pub seed: u64,
    /// Threads and savings.
    pub options: RunOptions,
    /// Where the training is saved from time to time; a later call goes on from there. Default nowhere.
    pub session: Option<PathBuf>,
}

impl Fit<'_> {
    /// Returns samples times epochs that the training sees at most; 0 for a baseline.
    pub fn samples(&self, dataset: &Dataset) -> usize {
        self.candidate.estimator.samples(&everything(dataset))
    }

    /// Trains on all samples of the encoder's data set; `None` if `cancel` was set. `tick` hears how many
    /// samples each step took.
    ///
    /// # Errors
    /// Samples that cannot be encoded or that the network does not take, training that diverges.
    pub fn run(
        &self,
        encoder: &mut Encoder,
        tick: &mut dyn FnMut(usize),
        cancel: &AtomicBool,
    ) -> Result<Option<Model>> {
        let candidate = self.candidate;
        candidate.check()?;
        encoder.prepare(&candidate.inputs())?;
        let dataset = encoder.dataset();
        if candidate.estimator.as_network().is_some() {
            dataset.refuse_one_class()?;
        }
        candidate.check_samples(dataset.len(), encoder)?;
        candidate.estimator.drawn()?;
        let (fold, cache) = (everything(dataset), FeatureCache::default());
        let job = FoldJob {
            candidate,
            protocol: self.protocol,
            seed: self.seed,
            place: None,
            fold: &fold,
            threads: self.options.threads(),
            teacher: None,
            cache: &cache,
            is_timed: false,
        };
        let mut saver = match &self.session {
            Some(path) => Saver::new(path.clone(), &self.options),
            None => Saver::none(),
        };
        let trained = train_fold(&job, encoder, &mut Hooks { tick, cancel, saver: &mut saver })?;
        Ok(trained.map(|trained| trained.model))
    }
}

/// Trains a network or baseline on all samples, with seed 0 on all cores.
///
/// # Errors
/// As [`Fit::run`].
pub fn fit(candidate: &Candidate, dataset: &Dataset, encoding: &Encoding) -> Result<Model> {
    let protocol = Protocol::default();
    let fit = Fit { candidate, protocol: &protocol, seed: 0, options: RunOptions::default(), session: None };
    let model = fit.run(&mut Encoder::new(encoding, dataset), &mut |_| {}, &AtomicBool::new(false))?;
    #[expect(clippy::expect_used, reason = "nobody has a hand on the flag")]
    Ok(model.expect("a training that is not cancelled ends with a model"))
}

/// Makes a fold of all samples to train on and none to test.
fn everything(dataset: &Dataset) -> Fold {
    Fold { train: (0..dataset.len()).collect(), test: vec![], validation: vec![] }
}
