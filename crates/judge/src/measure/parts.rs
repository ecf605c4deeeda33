//! The work of a stress test: parts of the data, jobs, and the threads that do them.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use ndarray::{ArrayD, Axis};
use taxel_faults::{Fault, Sensor};
use taxel_learn::{FoldKey, FoldRecord, Model, Predictor};

use super::threads::alone;
use crate::case::Case;
use crate::error::{Error, Result};

/// Samples that a network answers at a time.
pub(super) const BATCH: usize = 64;

/// Rows of the data set that a fold tests, with the models that have not seen them.
pub(super) struct Part {
    pub fold: usize,
    pub rows: Vec<usize>,
    pub truth: Vec<u32>,
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
    pub truth: Vec<u32>,
    pub probabilities: Vec<f32>,
    pub predicted: Vec<u32>,
    pub refused: usize,
}

impl Answer {
    /// In %.
    pub fn accuracy(&self) -> f64 {
        let right = self.truth.iter().zip(&self.predicted).filter(|(truth, predicted)| truth == predicted);
        100.0 * right.count() as f64 / self.truth.len().max(1) as f64
    }
}

/// The test parts of the first repetition, thinned out evenly to `most` samples; and how many there are.
pub(super) fn parts(case: &Case, names: &[&str], most: usize) -> (Vec<Part>, usize) {
    let records = || names.iter().flat_map(|name| case.first_repetition(name));
    let size = |name: &&str| case.first_repetition(name).map(|r| r.index.len()).sum::<usize>();
    let of = names.iter().map(size).max().unwrap_or(0);
    let every = of.div_ceil(most.max(1)).max(1);
    let mut parts: Vec<Part> = vec![];
    for FoldRecord { key, index, .. } in records() {
        let rows: Vec<usize> = index.iter().copied().step_by(every).collect();
        match parts.iter_mut().find(|part| part.fold == key.fold && part.rows == rows) {
            Some(part) => part.keys.push(key.clone()),
            None => {
                let truth = case.dataset.labels.of(&rows);
                parts.push(Part { fold: key.fold, rows, truth, keys: vec![key.clone()] });
            }
        }
    }
    (parts, of)
}

/// The models of the part that is being worked on, read once for all threads.
#[derive(Default)]
struct Shelf {
    newest: Mutex<Option<(usize, Arc<Vec<Model>>)>>,
}

impl Shelf {
    /// The models of part number `at`.
    fn models(&self, case: &Case, parts: &[Part], at: usize) -> Result<Arc<Vec<Model>>> {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        match &*newest {
            Some((own, models)) if *own == at => Ok(models.clone()),
            _ => {
                let models = parts[at].keys.iter().map(|key| case.model(key)).collect::<Result<Vec<_>>>()?;
                let models = Arc::new(models);
                *newest = Some((at, models.clone()));
                Ok(models)
            }
        }
    }
}

/// Does the jobs on `threads` threads; each takes the next one that is free and keeps the predictors of its
/// part. Answers are in the order of the jobs.
pub(super) fn answer(
    case: &Case,
    sensor: &Sensor,
    parts: &[Part],
    jobs: &[Job],
    threads: usize,
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Answer>> {
    let (next, shelf) = (AtomicUsize::new(0), Shelf::default());
    let done: Mutex<Vec<(usize, Vec<Answer>)>> = Mutex::new(vec![]);
    let worker = || -> Result<()> {
        let mut open: Option<(usize, Vec<Predictor>)> = None;
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(number) else { return Ok(()) };
            let predictors = match open.take() {
                Some((at, predictors)) if at == job.part => predictors,
                _ => {
                    let models = shelf.models(case, parts, job.part)?;
                    models.iter().map(|model| Ok(model.predictor(BATCH, 1)?)).collect::<Result<_>>()?
                }
            };
            let answers = answers(case, sensor, &parts[job.part], job, &predictors)?;
            open = Some((job.part, predictors));
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
    Ok(done.into_iter().flat_map(|(_, answers)| answers).collect())
}

fn answers(
    case: &Case,
    sensor: &Sensor,
    part: &Part,
    job: &Job,
    predictors: &[Predictor],
) -> Result<Vec<Answer>> {
    let clean = case.dataset.x.select(Axis(0), &part.rows);
    let broken = match job.broken {
        Some((fault, severity)) => corrupt(case, sensor, &clean, part, fault, severity)?,
        None => clean.clone(),
    };
    let width = part.truth.len() / part.len().max(1);
    let mut answers = vec![];
    let probes = case.probes();
    for (predictor, key) in predictors.iter().zip(&part.keys) {
        // A row that is there for one fault is asked about that one alone.
        let unmet = probes.iter().find(|(name, _)| *name == key.network).map(|(_, fault)| *fault);
        if unmet.zip(job.broken).is_some_and(|(own, (fault, _))| own != fault) {
            continue;
        }
        let (probabilities, refused) = ask(predictor, &clean, &broken)?;
        let mut predicted = predictor.card().levels().predicted(&probabilities);
        for &row in &refused {
            // No class: never right.
            predicted[row * width..(row + 1) * width].fill(u32::MAX);
        }
        answers.push(Answer {
            network: key.network.clone(),
            fold: part.fold,
            broken: job.broken,
            truth: part.truth.clone(),
            probabilities,
            predicted,
            refused: refused.len(),
        });
    }
    Ok(answers)
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

/// Probabilities of `broken` samples, and which of them cannot be encoded; the clean ones stand in for
/// those, so that the others still make a batch.
pub(super) fn ask(
    predictor: &Predictor,
    clean: &ArrayD<f32>,
    broken: &ArrayD<f32>,
) -> Result<(Vec<f32>, Vec<usize>)> {
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
    Ok((predictor.predict(&mended)?.probabilities, refused))
}
