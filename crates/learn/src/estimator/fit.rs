//! A network or baseline trained on all samples: what is shipped.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Fold};

use crate::encoding::{Encoder, Encoding};
use crate::error::{Error, Result};
use crate::estimator::baseline::{FittedBaseline, Lesson};
use crate::estimator::candidate::{Candidate, Estimator};
use crate::estimator::making::{Origin, baseline_model, network_model};
use crate::model::Model;
use crate::run::options::RunOptions;
use crate::run::protocol::Protocol;
use crate::training::feature_cache::Stills;
use crate::training::hooks::Hooks;
use crate::training::network::Training;
use crate::training::part::{Part, pool};
use crate::training::session::Saver;

/// A training on all samples of a data set.
pub struct Fit<'a> {
    /// The network or baseline.
    pub candidate: &'a Candidate,
    /// What early stopping and a search may not tear apart when they hold samples back: the protocol's
    /// groups or exact copies.
    pub protocol: &'a Protocol,
    /// Seed of every random choice.
    pub seed: u64,
    /// Threads and savings.
    pub options: RunOptions,
    /// Where the training is saved from time to time; a later call goes on from there. Default nowhere.
    pub session: Option<PathBuf>,
}

impl Fit<'_> {
    /// Samples times epochs that the training sees at most; 0 for a baseline.
    pub fn samples(&self, dataset: &Dataset) -> usize {
        match &self.candidate.estimator {
            Estimator::Network(network) => Training::samples(network, &everything(dataset)),
            Estimator::Baseline { .. } => 0,
        }
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
        crate::run::plan::check_faults(candidate, encoder.dataset())?;
        encoder.prepare(&candidate.inputs())?;
        let dataset = encoder.dataset();
        let (fold, part) = (everything(dataset), Part::everything(self.seed));
        let inputs = encoder.fit(&candidate.inputs(), &fold.train)?;
        let origin = Origin { dataset, samples: dataset.len(), fold: None, seed: self.seed };
        match &candidate.estimator {
            Estimator::Network(network) => {
                dataset.refuse_one_class()?;
                crate::run::plan::check_network(candidate, network, encoder)?;
                network.drawn()?;
                let training = Training {
                    name: &candidate.name,
                    network,
                    part,
                    threads: self.options.threads(),
                    dataset,
                    units: self.protocol.inseparable(dataset)?,
                    inputs: &inputs,
                    fold: &fold,
                    teacher: None,
                    stills: &Stills::default(),
                };
                let mut saver = match &self.session {
                    Some(path) => Saver::new(path.clone(), &self.options),
                    None => Saver::none(),
                };
                let trained = training.run(&mut Hooks { tick, cancel, saver: &mut saver })?;
                Ok(trained.map(|trained| network_model(candidate, network, &inputs, &trained, &origin)))
            }
            Estimator::Baseline { method, faults } => {
                let length = inputs[0].encoded.shape().last().copied().unwrap_or(0);
                if let Some(reason) = method.unfit(dataset.len(), length) {
                    let (network, input) = (candidate.name.clone(), "series".into());
                    return Err(Error::Input { network, input, reason });
                }
                let faults = faults.as_deref();
                let lesson = Lesson { dataset, series: &inputs[0], rows: &fold.train, faults, part };
                let fitted =
                    pool(self.options.threads())?.install(|| FittedBaseline::fit(*method, &lesson))?;
                Ok(Some(baseline_model(candidate, &fitted, &inputs, &origin)))
            }
        }
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

/// All samples to train on, none to test.
fn everything(dataset: &Dataset) -> Fold {
    Fold { train: (0..dataset.len()).collect(), test: vec![], validation: vec![] }
}
