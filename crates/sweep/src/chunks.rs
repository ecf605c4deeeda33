//! Missing trials, cut into tasks that are long enough for a scheduler.

use std::collections::HashSet;

use crate::error::{Error, Result};
use crate::folder::SweepFolder;
use crate::manifest::Manifest;
use crate::record::TrialTiming;

/// Finished trials whose times are averaged.
const ASKED: usize = 200;
/// Seconds of a task, where nothing else is said: a minute is the least that schedulers are made for.
const TASK_SECONDS: f64 = 120.0;

/// How trials are put together to tasks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Chunking {
    /// Trials of a task. Default as many as take `task_seconds`.
    pub count: Option<usize>,
    /// Seconds of a trial. Default as long as finished trials took.
    pub seconds_per_trial: Option<f64>,
    /// Seconds of a task. Default 120.
    pub task_seconds: Option<f64>,
}

/// A task: trials from `first` on. Finished ones among them are passed over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Task {
    /// Position of its first trial.
    pub first: usize,
    /// Number of trials.
    pub count: usize,
}

/// Tasks with all that is missing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tasks {
    /// In the order of the manifest.
    pub tasks: Vec<Task>,
    /// Trials of the manifest.
    pub planned: usize,
    /// Trials without a result.
    pub missing: usize,
    /// Trials without a result in each task but the last.
    pub each: usize,
}

/// Cuts the trials without a result into tasks.
///
/// # Errors
/// Seconds or counts out of range, or nothing that says how long a trial takes.
pub fn tasks(folder: &SweepFolder, chunking: &Chunking) -> Result<Tasks> {
    let (mut planned, mut open, mut timed) = (0, vec![], vec![]);
    let mut seen = HashSet::new();
    for next in Manifest::open(folder, 0)? {
        let (number, trial) = next?;
        planned += 1;
        if !folder.result(&trial.identity).is_file() {
            if seen.insert(trial.identity.clone()) {
                open.push(number);
            }
        } else if timed.len() < ASKED {
            timed.extend(TrialTiming::read(folder, &trial.identity)?.map(|timing| timing.seconds));
        }
    }
    let each = each(folder, chunking, &timed, open.len())?;
    let task =
        |numbers: &[usize]| Task { first: numbers[0], count: numbers[numbers.len() - 1] - numbers[0] + 1 };
    Ok(Tasks { tasks: open.chunks(each).map(task).collect(), planned, missing: open.len(), each })
}

fn each(folder: &SweepFolder, chunking: &Chunking, timed: &[f64], open: usize) -> Result<usize> {
    let positive = |key: &'static str, value: Option<f64>| match value {
        Some(value) if value <= 0.0 || !value.is_finite() => {
            Err(Error::Value { key, value: value.to_string(), reason: "must be more than 0".into() })
        }
        value => Ok(value),
    };
    let given = positive("seconds per trial", chunking.seconds_per_trial)?;
    let wanted = positive("seconds of a task", chunking.task_seconds)?.unwrap_or(TASK_SECONDS);
    if let Some(count) = chunking.count {
        let reason = "must be at least 1";
        let refused = || Error::Value { key: "trials of a task", value: "0".into(), reason: reason.into() };
        return if count == 0 { Err(refused()) } else { Ok(count) };
    }
    let mean = (!timed.is_empty()).then(|| timed.iter().sum::<f64>() / timed.len() as f64);
    match given.or(mean) {
        Some(seconds) => Ok(((wanted / seconds.max(1e-3)).ceil() as usize).clamp(1, open.max(1))),
        None if open == 0 => Ok(1),
        None => Err(Error::file(
            folder.path(),
            "no trial is finished that says how long one takes; tell the seconds of a trial or the trials of a \
             task, or run one trial first",
        )),
    }
}
