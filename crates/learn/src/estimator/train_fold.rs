//! One training of one candidate on one fold: the only place where that is done.

use taxel_data::{Dataset, Fold};
use taxel_engine::Precision;

use crate::encoding::{Encoder, Input};
use crate::error::Result;
use crate::estimator::candidate::Candidate;
use crate::estimator::estimator::{Fitted, Trained, TrainingSet};
use crate::estimator::left_out::with_left_out;
use crate::latency::Latency;
use crate::model::marks::marks;
use crate::model::{Card, FORMAT, Model, ModelInput, Ranges, TrainedOn, TrainingPart};
use crate::run::environment::COMMIT;
use crate::run::model_latency::of_model;
use crate::run::protocol::Protocol;
use crate::run::records::{FoldKey, FoldRecord};
use crate::training::feature_cache::FeatureCache;
use crate::training::hooks::Hooks;
use crate::training::part::TrainingKey;
use crate::training::teacher::Teacher;

/// One candidate, one fold.
pub(crate) struct FoldJob<'a> {
    pub candidate: &'a Candidate,
    pub protocol: &'a Protocol,
    pub seed: u64,
    /// Repetition and fold; none for all samples.
    pub place: Option<(usize, usize)>,
    pub fold: &'a Fold,
    pub threads: usize,
    pub teacher: Option<&'a Teacher>,
    pub cache: &'a FeatureCache,
    /// Whether a prediction is timed.
    pub is_timed: bool,
}

/// The result of a fold.
pub(crate) struct TrainedFold {
    pub model: Model,
    pub latency: Option<Latency>,
    pub encoding_ms_per_sample: f64,
    pub trained: Trained,
}

/// Trains a candidate on a fold: encodes, trains, predicts the test part and makes the model; none if cancelled.
///
/// The encoder has prepared the candidate's inputs, and the candidate is checked.
///
/// # Errors
/// Samples that cannot be encoded or that the candidate does not take, training that diverges.
pub(crate) fn train_fold(job: &FoldJob, encoder: &Encoder, hooks: &mut Hooks) -> Result<Option<TrainedFold>> {
    if hooks.is_cancelled() {
        return Ok(None);
    }
    let FoldJob { candidate, protocol, seed, place, fold, threads, teacher, cache, is_timed } = *job;
    let dataset = encoder.dataset();
    let part = match place {
        Some((repetition, fold)) => TrainingKey { seed, repetition, fold },
        None => TrainingKey::everything(seed),
    };
    let inputs = encoder.fit(&candidate.inputs(), &fold.train)?;
    let set = TrainingSet {
        name: &candidate.name,
        dataset,
        inputs: &inputs,
        fold,
        units: protocol.inseparable(dataset)?,
        part,
        threads,
        teacher,
        cache,
    };
    let Some(trained) = candidate.estimator.fit(&set, hooks)? else { return Ok(None) };
    let fitted = trained.fitted.as_ref();
    let mut model = model(job, dataset, fitted, &inputs);
    // A faulty copy of a sample that is left out would stay.
    if place.is_none() && candidate.faults().is_none() && fold.validation.is_empty() {
        model = with_left_out(model, (protocol, job.seed), &set, fitted)?;
    }
    let timed = fold.test.first().filter(|_| is_timed);
    Ok(Some(TrainedFold {
        latency: timed.map(|&row| of_model(&model, dataset, row)).transpose()?,
        model,
        encoding_ms_per_sample: inputs.iter().map(|input| input.ms_per_sample).sum(),
        trained,
    }))
}

impl TrainedFold {
    /// Returns the record of the fold; `model` is the digest of the file that was written.
    ///
    /// # Errors
    /// A checkpoint of another network.
    pub fn record(
        &self,
        key: &FoldKey,
        dataset: &Dataset,
        fold: &Fold,
        model: Option<String>,
    ) -> Result<FoldRecord> {
        let Trained { fitted, outputs, spread, test_loss, .. } = &self.trained;
        let record = FoldRecord::of(key, dataset, fold, outputs.clone(), *test_loss);
        let record = FoldRecord { outcome: record.outcome.clone().with_spread(spread), ..record };
        fitted.complete(FoldRecord { model, ..record })
    }
}

/// Returns the model with all that it says about itself.
fn model(job: &FoldJob, dataset: &Dataset, fitted: &dyn Fitted, inputs: &[Input]) -> Model {
    let candidate = job.candidate;
    let input = |input: &Input| ModelInput { name: input.name.into(), transform: input.transform.clone() };
    let task = dataset.task();
    let card = Card {
        format: FORMAT,
        taxel: env!("CARGO_PKG_VERSION").into(),
        commit: COMMIT.map(String::from),
        name: candidate.name.clone(),
        paper: candidate.paper.clone(),
        kind: fitted.kind(),
        spec: dataset.spec.clone(),
        // The same before all inputs.
        guard: inputs.first().and_then(|input| input.guard.as_deref().cloned()),
        inputs: fitted.inputs(inputs).into_iter().map(input).collect(),
        trained_on: TrainedOn {
            source: dataset.source.clone(),
            digest: dataset.digest.clone(),
            samples: job.fold.train.len(),
            part: match job.place {
                Some((repetition, fold)) => TrainingPart::Fold { repetition, fold },
                None => TrainingPart::Everything,
            },
            seed: job.seed,
            ranges: ranges(dataset, &job.fold.train),
            marks: marks(&dataset.x, job.fold.train.iter().copied()),
            tuned_from: None,
        },
        quantized: None,
        precision: Precision::F32,
        score: None,
        certainty: None,
        intervals: None,
        // Of the tensors: filled in with them.
        tensors: String::new(),
        task,
    };
    let weights = fitted.tensors(&card.task);
    Model::new(card, weights)
}

/// Finds the ranges of the channels of the training samples.
fn ranges(dataset: &Dataset, train: &[usize]) -> Ranges {
    let (x, spec) = (dataset.x.as_standard_layout(), &dataset.spec);
    let each = spec.shape.iter().product::<usize>().max(1);
    let values = x.as_slice().unwrap_or_default();
    let samples = train.iter().filter_map(|row| values.get(row * each..(row + 1) * each));
    Ranges::of(samples, spec.layout, &spec.shape)
}
