//! The work of a stress test: parts of the data, jobs, and the threads that do them.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use ndarray::{ArrayD, Axis};
use taxel_scenes::faults::{Fault, Sensor};
use taxel_trainer::{FoldKey, Predictor};

use crate::case::Case;
use crate::error::{Error, Result};

/// Samples that a network answers at a time.
const BATCH: usize = 64;

/// Rows of the data set that a fold tests, with the models that have not seen them.
pub(super) struct Part {
    pub fold: usize,
    pub rows: Vec<usize>,
    pub truth: Vec<u32>,
    keys: Vec<FoldKey>,
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
    pub broken: Option<(Fault, u8)>,
    pub truth: Vec<u32>,
    pub probabilities: Vec<f32>,
    pub predicted: Vec<u32>,
    pub refused: usize,
}

/// The test parts of the first repetition, thinned out evenly to `most` samples; and how many there are.
pub(super) fn parts(case: &Case, names: &[&str], most: usize) -> Result<(Vec<Part>, usize)> {
    let mut records = vec![];
    for name in names {
        records.extend(case.first_repetition(name)?);
    }
    let sizes = names
        .iter()
        .map(|name| records.iter().filter(|r| r.key.network == **name).map(|r| r.index.len()).sum::<usize>());
    let of = sizes.max().unwrap_or(0);
    let every = of.div_ceil(most.max(1)).max(1);
    let mut parts: Vec<Part> = vec![];
    for record in records {
        let rows: Vec<usize> = record.index.into_iter().step_by(every).collect();
        let (fold, key) = (record.key.fold, record.key);
        match parts.iter_mut().find(|part| part.fold == fold && part.rows == rows) {
            Some(part) => part.keys.push(key),
            None => {
                let truth = case.samples.labels.of(&rows);
                parts.push(Part { fold, rows, truth, keys: vec![key] });
            }
        }
    }
    Ok((parts, of))
}

/// Does the jobs on `threads` threads; each takes the next one that is free and keeps the models of its
/// part. Answers are in the order of the jobs.
pub(super) fn all(
    case: &Case,
    sensor: &Sensor,
    parts: &[Part],
    jobs: &[Job],
    threads: usize,
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Answer>> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, Vec<Answer>)>> = Mutex::new(vec![]);
    let worker = || -> Result<()> {
        let mut open: Option<(usize, Vec<Predictor>)> = None;
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(number) else { return Ok(()) };
            let part = &parts[job.part];
            let mut models = match open.take() {
                Some((at, models)) if at == job.part => models,
                _ => part.keys.iter().map(|key| case.predictor(key, BATCH, 1)).collect::<Result<_>>()?,
            };
            let answers = answers(case, sensor, part, job, &mut models)?;
            open = Some((job.part, models));
            done.lock().unwrap_or_else(PoisonError::into_inner).push((number, answers));
            tick();
        }
    };
    // Baselines spread over the threads of their pool: here each worker has one.
    let alone = || match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(worker),
        Err(_) => worker(),
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(alone)).collect();
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
    models: &mut [Predictor],
) -> Result<Vec<Answer>> {
    let clean = case.samples.x.select(Axis(0), &part.rows);
    let broken = match job.broken {
        Some((fault, severity)) => corrupt(case, sensor, &clean, part, fault, severity)?,
        None => clean.clone(),
    };
    let width = part.truth.len() / part.len().max(1);
    let mut answers = vec![];
    for (model, key) in models.iter_mut().zip(&part.keys) {
        let (probabilities, refused) = ask(model, &clean, &broken, &case.samples.source)?;
        let mut predicted = model.predicted(&probabilities);
        for &row in &refused {
            // No class: never right.
            predicted[row * width..(row + 1) * width].fill(u32::MAX);
        }
        answers.push(Answer {
            network: key.network.clone(),
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
    for (mut sample, &row) in x.axis_iter_mut(Axis(0)).zip(&part.rows) {
        // A sample [F] is one channel.
        let sample = match case.is_flat() {
            true => sample.insert_axis(Axis(0)),
            false => sample.view_mut(),
        };
        fault
            .apply(sample, sensor, severity, case.results.seed, row)
            .map_err(|source| Error::Fault { source_label: case.samples.source.clone(), source })?;
    }
    Ok(x)
}

/// Probabilities of `broken` samples, and which of them cannot be encoded; the clean ones stand in for
/// those, so that the others still make a batch.
fn ask(
    model: &mut Predictor,
    clean: &ArrayD<f32>,
    broken: &ArrayD<f32>,
    source: &str,
) -> Result<(Vec<f32>, Vec<usize>)> {
    if let Ok(inputs) = model.encode(broken, source) {
        return Ok((model.answer(&inputs)?, vec![]));
    }
    let mut mended = broken.clone();
    let mut refused = vec![];
    for row in 0..broken.len_of(Axis(0)) {
        let one = broken.select(Axis(0), &[row]);
        if model.encode(&one, source).is_err() {
            mended.index_axis_mut(Axis(0), row).assign(&clean.index_axis(Axis(0), row));
            refused.push(row);
        }
    }
    Ok((model.predict(&mended, source)?, refused))
}
