//! The work of a stress test: parts of the data, jobs, and the threads that do them.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use ndarray::{ArrayD, Axis};
use taxel_data::{Dataset, Targets};
use taxel_faults::{Fault, Sensor};
use taxel_learn::guard::{Found, Guard};
use taxel_learn::metrics::Outcome;
use taxel_learn::{FoldKey, FoldRecord, Model, Predictor, mended};

use super::chance::means;
use super::guarding::guard;
use super::threads::alone;
use crate::case::Case;
use crate::error::{Error, Result};
use crate::values::Alarms;

/// Samples that a network answers at a time.
pub(super) const BATCH: usize = 64;

/// Rows of the data set that a fold tests, with the models that have not seen them.
pub(super) struct Part {
    pub fold: usize,
    pub rows: Vec<usize>,
    pub keys: Vec<FoldKey>,
}

impl Part {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.rows.len()
    }
}

/// One part, unbroken or under one fault.
pub(super) struct Job {
    pub part: usize,
    pub broken: Option<(Fault, u8)>,
}

/// What one network says about a part.
pub(super) struct Answer {
    pub network: String,
    pub fold: usize,
    pub broken: Option<(Fault, u8)>,
    pub outcome: Outcome,
    pub refused: usize,
}

/// The test parts of the first repetition, thinned out evenly to `most` samples; and how many there are.
pub(super) fn parts(case: &Case, names: &[&str], most: usize) -> Result<(Vec<Part>, usize)> {
    let records = || names.iter().flat_map(|name| case.first_repetition(name));
    let size = |name: &&str| case.first_repetition(name).map(|r| r.index.len()).sum::<usize>();
    let of = names.iter().map(size).max().unwrap_or(0);
    let every = of.div_ceil(most.max(1)).max(1);
    let mut parts: Vec<Part> = vec![];
    for FoldRecord { key, index, .. } in records() {
        let rows: Vec<usize> = index.iter().copied().step_by(every).collect();
        match parts.iter_mut().find(|part| part.fold == key.fold && part.rows == rows) {
            Some(part) => part.keys.push(key.clone()),
            None => parts.push(Part { fold: key.fold, rows, keys: vec![key.clone()] }),
        }
    }
    Ok((parts, of))
}

/// Models of a part, and the guard of its fold.
#[derive(Clone)]
struct Shelved {
    models: Arc<Vec<Model>>,
    guard: Option<Arc<Guard>>,
}

/// The models of the part that is being worked on, read once for all threads.
struct Shelf {
    /// Whether a fold without a guard gets one.
    guard: bool,
    newest: Mutex<Option<(usize, Shelved)>>,
}

impl Shelf {
    /// The models of part number `at`.
    fn models(&self, case: &Case, parts: &[Part], at: usize) -> Result<Shelved> {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        match &*newest {
            Some((own, shelved)) if *own == at => Ok(shelved.clone()),
            _ => {
                let keys = &parts[at].keys;
                let models = keys.iter().map(|key| case.model(key)).collect::<Result<Vec<_>>>()?;
                let guard = guard(case, keys, &models, self.guard)?;
                let shelved = Shelved { models: Arc::new(models), guard };
                *newest = Some((at, shelved.clone()));
                Ok(shelved)
            }
        }
    }
}

/// Predictors of a part without a guard, whether each model has one, and the guard.
struct Bench {
    predictors: Vec<(Predictor, bool)>,
    guard: Option<Arc<Guard>>,
    /// Whether each is asked with the guard and without.
    both: bool,
}

impl Bench {
    fn new(shelved: &Shelved, both: bool) -> Result<Self> {
        let own = |model: &Model| -> Result<(Predictor, bool)> {
            Ok((model.predictor(BATCH, 1)?.guarded(None)?, model.card().guard.is_some()))
        };
        let predictors = shelved.models.iter().map(own).collect::<Result<_>>()?;
        Ok(Bench { predictors, guard: shelved.guard.clone(), both })
    }
}

/// What all networks say.
#[derive(Default)]
pub(super) struct Answered {
    /// With a guard where their models have one.
    pub own: Vec<Answer>,
    /// The other way, where that was asked for.
    pub other: Vec<Answer>,
    /// In unbroken samples; none without a guard.
    pub alarms: Option<Alarms>,
}

/// Does the jobs on `threads` threads; each takes the next one that is free and keeps the predictors of its
/// part. Answers are in the order of the jobs.
pub(super) fn answer(
    case: &Case,
    sensor: &Sensor,
    parts: &[Part],
    jobs: &[Job],
    (is_guarded, threads): (bool, usize),
    tick: &(dyn Fn() + Sync),
) -> Result<Answered> {
    let (next, shelf) = (AtomicUsize::new(0), Shelf { guard: is_guarded, newest: Mutex::default() });
    let done: Mutex<Vec<(usize, Answered)>> = Mutex::new(vec![]);
    let worker = || -> Result<()> {
        let mut open: Option<(usize, Bench)> = None;
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(number) else { return Ok(()) };
            let bench = match open.take() {
                Some((at, bench)) if at == job.part => bench,
                _ => Bench::new(&shelf.models(case, parts, job.part)?, is_guarded)?,
            };
            let answers = answers(case, sensor, &parts[job.part], job, &bench)?;
            open = Some((job.part, bench));
            done.lock().unwrap_or_else(PoisonError::into_inner).push((number, answers));
            tick();
        }
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(|| alone(worker))).collect();
        let ends = workers.into_iter().map(|w| w.join().unwrap_or_else(|p| std::panic::resume_unwind(p)));
        ends.collect::<Result<Vec<()>>>()
    })?;
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(number, _)| *number);
    let mut all = Answered::default();
    for (_, Answered { own, other, alarms }) in done {
        all.own.extend(own);
        all.other.extend(other);
        all.alarms = match (all.alarms, alarms) {
            (Some(before), Some(alarms)) => Some(before.and(alarms)),
            (before, alarms) => before.or(alarms),
        };
    }
    Ok(all)
}

fn answers(case: &Case, sensor: &Sensor, part: &Part, job: &Job, bench: &Bench) -> Result<Answered> {
    let clean = case.dataset.x.select(Axis(0), &part.rows);
    let broken = match job.broken {
        Some((fault, severity)) => corrupt(case, sensor, &clean, part, fault, severity)?,
        None => clean.clone(),
    };
    let behind = bench.guard.as_ref().map(|guard| mended(guard, &broken));
    let alarms = match (&bench.guard, &behind, job.broken) {
        (Some(guard), Some((_, found)), None) => Some(Alarms::of(guard, found)),
        _ => None,
    };
    let mut answers = Answered { alarms, ..Answered::default() };
    let probes = case.probes();
    for ((predictor, is_guarded), key) in bench.predictors.iter().zip(&part.keys) {
        // A row that is there for one fault is asked about that one alone.
        let unmet = probes.iter().find(|(name, _)| *name == key.network).map(|(_, fault)| *fault);
        if unmet.zip(job.broken).is_some_and(|(own, (fault, _))| own != fault) {
            continue;
        }
        let without = match bench.both || !is_guarded {
            true => Some(ask(predictor, &clean, &broken)?),
            false => None,
        };
        let with = match &behind {
            Some((x, found)) if bench.both || *is_guarded => {
                Some(ask_behind(predictor, &clean, x, found, without.as_ref())?)
            }
            _ => None,
        };
        let of = |asked: Asked| answer_of(&case.dataset, part, key, job, asked);
        let (own, other) = if *is_guarded { (with, without) } else { (without, with) };
        answers.own.extend(own.map(of));
        answers.other.extend(other.map(of));
    }
    Ok(answers)
}

/// What a network says, for scores.
fn answer_of(dataset: &Dataset, part: &Part, key: &FoldKey, job: &Job, asked: Asked) -> Answer {
    let (network, fold, broken, refused) = (key.network.clone(), part.fold, job.broken, asked.1.len());
    Answer { network, fold, broken, outcome: outcome(dataset, part, asked), refused }
}

/// Returns outputs beside the true targets of a part. A sample that was refused has no class, which is never right, or
/// the mean of each value.
pub(super) fn outcome(dataset: &Dataset, part: &Part, (outputs, refused): Asked) -> Outcome {
    let mut outcome = Outcome::new(&dataset.targets, &part.rows, outputs);
    match (&mut outcome, &dataset.targets) {
        (Outcome::Values { predicted, .. }, Targets::Values(values)) => {
            let means = means(values);
            for &row in &refused {
                predicted[row * means.len()..][..means.len()].copy_from_slice(&means);
            }
        }
        (Outcome::Labels { predicted, .. }, _) => {
            let width = predicted.len() / part.len().max(1);
            for &row in &refused {
                predicted[row * width..][..width].fill(u32::MAX);
            }
        }
        _ => {}
    }
    outcome
}

/// The samples of a part under one fault.
fn corrupt(
    case: &Case,
    sensor: &Sensor,
    clean: &ArrayD<f32>,
    part: &Part,
    fault: Fault,
    severity: u8,
) -> Result<ArrayD<f32>> {
    let mut x = clean.clone();
    for (sample, &row) in x.axis_iter_mut(Axis(0)).zip(&part.rows) {
        fault.apply(sample, sensor, severity, case.results.seed, row).map_err(|source| {
            let source_label = case.dataset.source.to_string();
            Error::Fault { source_label, source }
        })?;
    }
    Ok(x)
}

/// Outputs, and which samples cannot be encoded.
pub(super) type Asked = (Vec<f32>, Vec<usize>);

/// The answers to samples `x` behind a guard; where it found nothing they are those `without` it.
fn ask_behind(
    predictor: &Predictor,
    clean: &ArrayD<f32>,
    x: &ArrayD<f32>,
    found: &[Vec<Found>],
    without: Option<&Asked>,
) -> Result<Asked> {
    let Some((outputs, refused)) = without else { return ask(predictor, clean, x) };
    let rows: Vec<usize> = (0..found.len()).filter(|row| !found[*row].is_empty()).collect();
    let (mut outputs, mut refused) = (outputs.clone(), refused.clone());
    if rows.is_empty() {
        return Ok((outputs, refused));
    }
    let (own, unread) = ask(predictor, &clean.select(Axis(0), &rows), &x.select(Axis(0), &rows))?;
    let width = own.len() / rows.len();
    for (row, own) in rows.iter().zip(own.chunks_exact(width.max(1))) {
        outputs[row * width..][..width].copy_from_slice(own);
    }
    refused.retain(|row| !rows.contains(row));
    refused.extend(unread.into_iter().map(|at| rows[at]));
    refused.sort_unstable();
    Ok((outputs, refused))
}

/// Outputs for `broken` samples, and which of them cannot be encoded; the clean ones stand in for
/// those, so that the others still make a batch.
pub(super) fn ask(predictor: &Predictor, clean: &ArrayD<f32>, broken: &ArrayD<f32>) -> Result<Asked> {
    if let Ok(inputs) = predictor.encode(broken) {
        return Ok((predictor.answer(&inputs)?, vec![]));
    }
    let mut mended = broken.clone();
    let mut refused = vec![];
    for row in 0..broken.len_of(Axis(0)) {
        if predictor.encode(&broken.select(Axis(0), &[row])).is_err() {
            mended.index_axis_mut(Axis(0), row).assign(&clean.index_axis(Axis(0), row));
            refused.push(row);
        }
    }
    Ok((predictor.predict(&mended)?.outputs, refused))
}
