//! Which parts of a run are used, how many trainings that is, and the whole on all of them.

use std::cell::OnceCell;

use taxel_data::Fold;
use taxel_judge::Case;
use taxel_learn::{FoldRecord, Model, inner_folds, sensor};
use taxel_trainer::Variant;

use crate::curves::{Outer, Part, Shared, inner_place};
use crate::desk::{Ask, Desk};
use crate::error::{Error, Result};
use crate::ladder::Ladder;
use crate::options::Options;
use crate::ranking::ranking;

/// Test parts that a quick look uses.
const QUICK_PARTS: usize = 2;

/// What is to come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Trainings at most, the knees together left out.
    pub trainings: usize,
    /// Seconds, as fast as the run was and if every setting took as long as the whole; none where nobody timed it.
    pub seconds: Option<f64>,
}

/// The folds of a run that are used, each with inner folds of its training part.
pub struct Plan {
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

impl Plan {
    /// The folds of a run, divided again as it was divided.
    ///
    /// # Errors
    /// A run of another split, a training part that cannot be divided.
    pub fn new(case: &Case, shared: &Shared, ladders: &[Ladder], options: &Options) -> Result<Self> {
        let (dataset, protocol, seed) = (shared.dataset, &shared.protocol, shared.seed);
        let most = if options.quick { QUICK_PARTS } else { usize::MAX };
        let mut parts = vec![];
        for record in case.records(shared.name).take(most) {
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
        Ok(Plan { parts, steps: ladders.iter().map(|own| own.steps.len()).sum() })
    }

    /// What is to come, by the times of the run.
    pub fn estimate(&self, case: &Case, shared: &Shared) -> Estimate {
        let (inner, outer) = self.trainings(shared);
        let timings = case.folder.timings().unwrap_or_default();
        let own = timings.iter().filter(|own| own.key.network == shared.name);
        let (seconds, seen) = own.fold((0.0, 0), |(sum, n), own| (sum + own.train_seconds, n + own.samples));
        let per_sample = (seen > 0).then(|| seconds / seen as f64);
        let seconds = per_sample.map(|own| own * self.samples(case, shared) as f64);
        Estimate { trainings: inner + outer, seconds }
    }

    /// Trainings on inner folds and on whole training parts.
    fn trainings(&self, shared: &Shared) -> (usize, usize) {
        let inner: usize = self.parts.iter().map(|own| own.inner.len()).sum();
        let again = usize::from(shared.epochs.is_some());
        (inner * (self.steps + 1), self.parts.len() * (self.steps + again))
    }

    /// Samples times epochs of all trainings, as long as the run's.
    pub fn samples(&self, case: &Case, shared: &Shared) -> u64 {
        let (inner, outer) = self.trainings(shared);
        let mean = |rows: Vec<usize>| rows.iter().sum::<usize>() as f64 / rows.len().max(1) as f64;
        let folds = self.parts.iter().flat_map(|own| &own.inner);
        let of_inner = mean(folds.map(|fold| fold.train.len()).collect());
        let of_outer = mean(self.parts.iter().map(|own| own.fold.train.len()).collect());
        let recorded = case.records(shared.name).map(|own| own.epochs.len()).max().unwrap_or(1).max(1);
        let epochs = shared.epochs.unwrap_or(recorded);
        ((inner as f64 * of_inner + outer as f64 * of_outer) * epochs as f64) as u64
    }

    /// The whole on all folds, and what training parts say of sensors, where they are `ranked`, and of the range.
    ///
    /// # Errors
    /// What stops everything.
    pub fn outers(self, shared: &Shared, desk: &mut Desk, ranked: bool) -> Result<Vec<Outer>> {
        self.parts.into_iter().map(|part| outer(shared, desk, part, ranked)).collect()
    }
}

fn outer(shared: &Shared, desk: &mut Desk, planned: Planned, ranked: bool) -> Result<Outer> {
    let Planned { record, fold, inner } = planned;
    let place = (record.key.repetition, record.key.fold);
    let changes = Variant { epochs: shared.epochs, ..Variant::default() };
    let ask = |place, fold| Ask {
        name: shared.name,
        label: "whole",
        changes: &changes,
        place,
        fold,
        teacher: None,
    };
    let asks: Vec<Ask> =
        inner.iter().enumerate().map(|(at, fold)| ask(inner_place(place, at), fold)).collect();
    let ranking = if ranked { ranked_by(shared, desk, &asks)? } else { vec![] };
    let inner_whole = asks.iter().map(|ask| desk.answers(*ask)).collect::<Result<_>>()?;
    let whole = match shared.epochs {
        Some(_) => desk.answers(ask(place, &fold))?,
        None => record,
    };
    let facts = sensor(shared.dataset, &fold.train).sensor;
    let part = Part { ranking, range: [facts.low, facts.high] };
    Ok(Outer { place, fold, inner, whole, inner_whole, part, teacher: OnceCell::new() })
}

/// The ranking of the sensors by networks on inner folds: a kept one, or these are trained.
fn ranked_by(shared: &Shared, desk: &mut Desk, asks: &[Ask]) -> Result<Vec<usize>> {
    let Some(first) = asks.first() else { return Ok(vec![]) };
    let of = desk.following(first, &format!("ranking of {} inner folds", asks.len()))?;
    if let Some(ranking) = desk.kept(&of)? {
        return Ok(ranking);
    }
    let mut models: Vec<(Model, &Fold)> = vec![];
    for ask in asks {
        models.push((desk.train(*ask)?.model, ask.fold));
    }
    let ranking = ranking(&models, shared.dataset, &shared.sensors, desk.threads)?;
    desk.keep(&of, &ranking)?;
    Ok(ranking)
}
