//! Which parts of a run are used, how many trainings that is, and the whole on all of them.

use std::cell::OnceCell;

use taxel_data::Fold;
use taxel_judge::Case;
use taxel_learn::{FoldRecord, Model, inner_folds, sensor};
use taxel_trainer::Variant;

use crate::cache::{Cache, Request};
use crate::curves::{Context, Outer, TrainingPart, inner_place};
use crate::error::{Error, Result};
use crate::ladder::Ladder;
use crate::options::ShrinkOptions;
use crate::ranking::ranking;

/// Test parts that a quick look uses.
const QUICK_PARTS: usize = 2;

/// Number of trainings and time that are to come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Trainings at most, the knees together left out.
    pub trainings: usize,
    /// Seconds, as fast as the run was and if every setting took as long as the whole; none where nobody timed it.
    pub seconds: Option<f64>,
}

/// The folds of a run that are used, each with inner folds of its training part.
pub struct Division {
    parts: Vec<Planned>,
    /// Settings of all axes.
    steps: usize,
}

/// A fold of the run, its record, and the inner folds of its training part.
struct Planned {
    record: FoldRecord,
    fold: Fold,
    inner: Vec<Fold>,
}

impl Division {
    /// Collects the folds of a run, divided again as it was divided.
    ///
    /// # Errors
    /// A run of another split, a training part that cannot be divided.
    pub fn new(case: &Case, context: &Context, ladders: &[Ladder], options: &ShrinkOptions) -> Result<Self> {
        let (dataset, protocol, seed) = (context.dataset, &context.protocol, context.seed);
        let most = if options.quick { QUICK_PARTS } else { usize::MAX };
        let mut parts = vec![];
        for record in case.records(context.name).take(most) {
            let (repetition, number) = (record.key.repetition, record.key.fold);
            let all = protocol.folds(dataset, seed, repetition)?;
            let same = |fold: &&Fold| fold.test == record.index;
            let Some(fold) = all.get(number).filter(same).cloned() else {
                let reason = format!("fold {} is of another split; run it again", record.key);
                return Err(Error::file(case.folder.path(), reason));
            };
            let inner = inner_folds(protocol, dataset, &fold, options.inner, seed, repetition)?;
            parts.push(Planned { record: record.clone(), fold, inner });
        }
        Ok(Division { parts, steps: ladders.iter().map(|ladder| ladder.steps.len()).sum() })
    }

    /// Estimates trainings and time, by the times of the run.
    pub fn estimate(&self, case: &Case, context: &Context) -> Estimate {
        let (inner, outer) = self.trainings(context);
        let timings = case.folder.timings().unwrap_or_default();
        let of_network = timings.iter().filter(|timing| timing.key.network == context.name);
        let (seconds, seen) =
            of_network.fold((0.0, 0), |(sum, n), timing| (sum + timing.train_seconds, n + timing.samples));
        let per_sample = (seen > 0).then(|| seconds / seen as f64);
        let seconds = per_sample.map(|seconds| seconds * self.samples(case, context) as f64);
        Estimate { trainings: inner + outer, seconds }
    }

    /// Counts the trainings on inner folds and on whole training parts.
    fn trainings(&self, context: &Context) -> (usize, usize) {
        let inner: usize = self.parts.iter().map(|part| part.inner.len()).sum();
        let again = usize::from(context.epochs.is_some());
        (inner * (self.steps + 1), self.parts.len() * (self.steps + again))
    }

    /// Returns the samples times epochs of all trainings, as long as the run's.
    pub fn samples(&self, case: &Case, context: &Context) -> u64 {
        let (inner, outer) = self.trainings(context);
        let mean = |rows: Vec<usize>| rows.iter().sum::<usize>() as f64 / rows.len().max(1) as f64;
        let folds = self.parts.iter().flat_map(|part| &part.inner);
        let of_inner = mean(folds.map(|fold| fold.train.len()).collect());
        let of_outer = mean(self.parts.iter().map(|part| part.fold.train.len()).collect());
        let recorded = case.records(context.name).map(|record| record.epochs.len()).max().unwrap_or(1).max(1);
        let epochs = context.epochs.unwrap_or(recorded);
        ((inner as f64 * of_inner + outer as f64 * of_outer) * epochs as f64) as u64
    }

    /// Trains the whole on all folds, and finds for each training part the ranking of sensors, where it is needed, and the
    /// range.
    ///
    /// # Errors
    /// An error that ends the shrinking.
    pub fn outers(self, context: &Context, cache: &mut Cache, ranked: bool) -> Result<Vec<Outer>> {
        self.parts.into_iter().map(|part| outer(context, cache, part, ranked)).collect()
    }
}

fn outer(context: &Context, cache: &mut Cache, planned: Planned, ranked: bool) -> Result<Outer> {
    let Planned { record, fold, inner } = planned;
    let place = (record.key.repetition, record.key.fold);
    let changes = Variant { epochs: context.epochs, ..Variant::default() };
    let request = |place, fold| Request {
        name: context.name,
        label: "whole",
        changes: &changes,
        place,
        fold,
        teacher: None,
    };
    let requests: Vec<Request> =
        inner.iter().enumerate().map(|(at, fold)| request(inner_place(place, at), fold)).collect();
    let ranking = if ranked { ranked_by(context, cache, &requests)? } else { vec![] };
    let inner_whole = requests.iter().map(|request| cache.predictions(*request)).collect::<Result<_>>()?;
    let whole = match context.epochs {
        Some(_) => cache.predictions(request(place, &fold))?,
        None => record,
    };
    let facts = sensor(context.dataset, &fold.train).sensor;
    let part = TrainingPart { ranking, range: [facts.low, facts.high] };
    Ok(Outer { place, fold, inner, whole, inner_whole, part, teacher: OnceCell::new() })
}

/// Returns the ranking of the sensors by networks on inner folds: a kept one, or these are trained.
fn ranked_by(context: &Context, cache: &mut Cache, requests: &[Request]) -> Result<Vec<usize>> {
    let Some(first) = requests.first() else { return Ok(vec![]) };
    let of = cache.following(first, &format!("ranking of {} inner folds", requests.len()))?;
    if let Some(ranking) = cache.kept(&of)? {
        return Ok(ranking);
    }
    let mut models: Vec<(Model, &Fold)> = vec![];
    for request in requests {
        models.push((cache.train(*request)?.model, request.fold));
    }
    let ranking = ranking(&models, context.dataset, &context.sensors, cache.threads)?;
    cache.keep(&of, &ranking)?;
    Ok(ranking)
}
