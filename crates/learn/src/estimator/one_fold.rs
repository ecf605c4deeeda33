//! One training on chosen samples, tested on others; nothing is written.

use std::sync::atomic::{AtomicBool, Ordering};

use taxel_data::{Dataset, Fold};

use crate::encoding::Encoder;
use crate::error::{Error, Result};
use crate::estimator::baseline::{FittedBaseline, Lesson};
use crate::estimator::candidate::{Candidate, Estimator};
use crate::estimator::making::{Origin, baseline_model, network_model};
use crate::metrics::mean_log_loss;
use crate::model::Model;
use crate::run::plan::{check_faults, check_network};
use crate::run::protocol::Protocol;
use crate::run::records::{FoldKey, FoldRecord};
use crate::training::feature_cache::Stills;
use crate::training::hooks::Hooks;
use crate::training::network::Training;
use crate::training::part::{Part, pool};
use crate::training::session::Saver;
use crate::training::teacher::Teacher;

/// One training on chosen samples.
pub struct OneFold<'a> {
    /// The network or baseline.
    pub candidate: &'a Candidate,
    /// What early stopping and a search may not tear apart.
    pub protocol: &'a Protocol,
    /// Seed of every random choice, which depends on repetition and fold of the key too.
    pub seed: u64,
    /// Which training it is; its record bears the name.
    pub key: FoldKey,
    /// Samples to train on, to validate with, and to test; the last may be none.
    pub fold: &'a Fold,
    /// Whose answers it learns from beside the labels; baselines do not listen.
    pub teacher: Option<&'a Teacher>,
    /// Worker threads; results do not depend on them.
    pub threads: usize,
}

/// A finished training.
pub struct Tested {
    /// Its answers to the test samples.
    pub record: FoldRecord,
    /// What was trained.
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
        let dataset = encoder.dataset();
        check_faults(candidate, dataset)?;
        let part = Part { seed, repetition: key.repetition, fold: key.fold };
        let inputs = encoder.fit(&candidate.inputs(), &fold.train)?;
        let place = Some((key.repetition, key.fold));
        let origin = Origin { dataset, samples: fold.train.len(), fold: place, seed };
        match &candidate.estimator {
            Estimator::Network(network) => {
                check_network(candidate, network, encoder)?;
                let training = Training {
                    name: &candidate.name,
                    network,
                    part,
                    threads,
                    dataset,
                    units: protocol.inseparable(dataset)?,
                    inputs: &inputs,
                    fold,
                    teacher,
                    stills: &Stills::default(),
                };
                let mut saver = Saver::none();
                let trained = training.run(&mut Hooks { tick, cancel, saver: &mut saver })?;
                let Some(trained) = trained else { return Ok(None) };
                let model = network_model(candidate, network, &inputs, &trained, &origin);
                let record = FoldRecord {
                    diverged: trained.diverged,
                    chosen: trained.chosen,
                    best_epoch: trained.best_epoch,
                    epochs: trained.epochs,
                    ..FoldRecord::of(key, dataset, fold, trained.probabilities, trained.test_loss)
                };
                Ok(Some(Tested { record, model }))
            }
            Estimator::Baseline { .. } if cancel.load(Ordering::Relaxed) => Ok(None),
            Estimator::Baseline { method, faults } => {
                let length = inputs[0].encoded.shape().last().copied().unwrap_or(0);
                if let Some(reason) = method.unfit(fold.train.len(), length) {
                    let (network, input) = (candidate.name.clone(), "series".into());
                    return Err(Error::Input { network, input, reason });
                }
                let faults = faults.as_deref();
                let lesson = Lesson { dataset, series: &inputs[0], rows: &fold.train, faults, part };
                let threads = pool(threads)?;
                let fitted = threads.install(|| FittedBaseline::fit(*method, &lesson))?;
                let mut test = vec![];
                inputs[0].encoded.gather(&fold.test, &mut test);
                let (mut probabilities, mut loss) = (vec![], 0.0);
                if !fold.test.is_empty() {
                    probabilities = threads.install(|| fitted.scores(&test))?;
                    let labels = &dataset.labels;
                    loss = mean_log_loss(&probabilities, &labels.of(&fold.test), &labels.sizes())?;
                }
                let model = baseline_model(candidate, &fitted, &inputs, &origin);
                let record = FoldRecord::of(key, dataset, fold, probabilities, loss);
                let record = FoldRecord { costs: Some(fitted.costs()), ..record };
                Ok(Some(Tested { record, model }))
            }
        }
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
    let whole = |own: Fold| Fold {
        train: whole(own.train),
        test: whole(own.test),
        validation: whole(own.validation),
    };
    Ok(cut.into_iter().map(whole).collect())
}
