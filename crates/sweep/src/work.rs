//! One trial from lease to result.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use taxel_data::Dataset;
use taxel_learn::{RunFolder, RunOptions, Silent, program};
use taxel_trainer::{Experiment, Overrides, Runner};
use taxel_zoo::Registry;

use crate::error::{Error, Result};
use crate::folder::SweepFolder;
use crate::json;
use crate::lease::{Holder, Lease, Taken};
use crate::record::{Failure, TrialResult, TrialTiming};
use crate::samples::Loader;
use crate::trial::{DataOf, Trial};

/// How trials are worked on; none of it changes a result.
#[derive(Debug, Clone)]
pub struct WorkOptions {
    /// Seconds between two savings of a fold in training.
    pub save_every: Option<f64>,
    /// How long a trial whose process is not heard of stays its own.
    pub stale: Duration,
    /// Set from outside to end after the epoch under way, which is saved.
    pub stop: Arc<AtomicBool>,
    /// Set from outside to end at once; what was saved before counts.
    pub cancel: Arc<AtomicBool>,
}

/// The outcome of one trial.
#[derive(Debug, Clone, PartialEq)]
pub enum TrialOutcome {
    /// It is finished now.
    Finished {
        /// Seconds that it took.
        seconds: f64,
    },
    /// It was finished before.
    Before,
    /// Somebody else is at it.
    Held(Holder),
    /// It cannot be run; the reason is kept.
    Failed(String),
    /// Stopped from outside; it is saved.
    Stopped,
}

/// Works on trials of one sweep, one after the other.
pub(crate) struct Worker<'a> {
    pub folder: &'a SweepFolder,
    pub registry: &'a Registry,
    pub options: &'a WorkOptions,
    /// Worker threads of a trial.
    pub threads: usize,
    pub loader: Loader<'a>,
}

/// Why a trial has no result yet.
enum Ended {
    Stopped,
    Failed(Error),
}

impl<E: Into<Error>> From<E> for Ended {
    fn from(error: E) -> Self {
        match error.into() {
            Error::Experiment(taxel_trainer::Error::Learn(taxel_learn::Error::Cancelled { .. })) => {
                Ended::Stopped
            }
            error => Ended::Failed(error),
        }
    }
}

impl Worker<'_> {
    /// Runs a trial, unless it is finished or somebody else is at it.
    ///
    /// # Errors
    /// A sweep folder that cannot be read or written.
    pub fn one(&mut self, trial: &Trial) -> Result<TrialOutcome> {
        let identity = &trial.identity;
        if TrialResult::read(self.folder, identity)?.is_some() {
            return Ok(TrialOutcome::Before);
        }
        let start = Instant::now();
        let lease = match Lease::take(self.folder, identity, self.options.stale)? {
            Taken::Mine(lease) => lease,
            Taken::Held(holder) => return Ok(TrialOutcome::Held(holder)),
        };
        // Another process may have finished it since the check above.
        if TrialResult::read(self.folder, identity)?.is_some() {
            lease.finish()?;
            return Ok(TrialOutcome::Before);
        }
        let out = match &trial.fold {
            None => self.folder.run(&trial.name, identity),
            Some(_) => self.folder.piece(&trial.name, identity),
        };
        // A run folder without a result: its process was killed between the two.
        let ended = if out.is_dir() {
            Ok(())
        } else {
            lease.work().map_err(Ended::from).and_then(|work| self.run(trial, &work, &out))
        };
        match ended {
            Ok(()) => {}
            Err(Ended::Stopped) => {
                lease.release()?;
                return Ok(TrialOutcome::Stopped);
            }
            Err(Ended::Failed(error)) => {
                if let Some(holder) = lease.successor()? {
                    return Ok(TrialOutcome::Held(holder));
                }
                let error = error.to_string();
                let failure = Failure { identity: identity.clone(), error: error.clone() };
                json::write(&self.folder.failure(identity), &failure)?;
                lease.release()?;
                return Ok(TrialOutcome::Failed(error));
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        self.keep(trial, &out, seconds, lease.attempts())?;
        lease.finish()?;
        Ok(TrialOutcome::Finished { seconds })
    }

    /// Trains in `work` and puts the finished run folder at `out`.
    fn run(&mut self, trial: &Trial, work: &Path, out: &Path) -> std::result::Result<(), Ended> {
        let experiment = resolved(trial, self.registry)?;
        let dataset = self.loader.of(&experiment)?;
        self.train(trial, &experiment, &dataset, work)?;
        Ok(publish(work, out)?)
    }

    /// Runs the folds of a trial that are its own in the run folder `work`.
    fn train(&self, trial: &Trial, experiment: &Experiment, dataset: &Dataset, work: &Path) -> Result<()> {
        if dataset.digest != trial.data.digest {
            let reason = format!(
                "was planned on other samples ({} then, {} now); give every machine the same data, or plan again",
                trial.data.digest, dataset.digest
            );
            return Err(Error::Value { key: "trial", value: trial.words(), reason });
        }
        let DataOf { facts, weights, .. } = &trial.data;
        let same = [(facts, dataset.facts().digest()), (weights, experiment.weights_digest()?)];
        if same.iter().any(|(then, now)| !then.is_empty() && *then != now) {
            let reason = "was planned with other facts about the samples (labels.json) or other weights; give every machine \
                          the same files, or plan again";
            return Err(Error::Value { key: "trial", value: trial.words(), reason: reason.into() });
        }
        let run = RunOptions {
            resume: true,
            threads: Some(self.threads),
            save_every: self.options.save_every,
            only: trial.fold.as_ref().map(|piece| vec![piece.key.clone()]),
            stop: Some(Arc::clone(&self.options.stop)),
            ..RunOptions::default()
        };
        let runner = Runner { experiment, registry: self.registry, dataset };
        runner.run(Some(work), &run, &Silent, &self.options.cancel)?;
        Ok(())
    }

    /// Writes the scores of a finished trial.
    fn keep(&self, trial: &Trial, out: &Path, seconds: f64, attempts: u32) -> Result<()> {
        let results = RunFolder::open(out)?.results()?;
        let timing = TrialTiming { seconds, threads: self.threads, host: Holder::host(), attempts };
        timing.write(self.folder, &trial.identity)?;
        let failure = self.folder.failure(&trial.identity);
        if failure.exists() {
            fs::remove_file(&failure).map_err(|e| Error::io(&failure, "removed", e))?;
        }
        // Last: a trial with a result is a finished trial.
        let result = TrialResult::of(&trial.identity, &trial.data, &results);
        json::write(&self.folder.result(&trial.identity), &result)
    }
}

/// Returns the experiment of a trial, as it was planned.
///
/// # Errors
/// A trial that another program has planned.
pub(crate) fn resolved(trial: &Trial, registry: &Registry) -> Result<Experiment> {
    let current = program();
    if trial.program != current {
        let reason = format!(
            "was planned by taxel {}, this is {current}; plan the sweep again, or run it with that one",
            trial.program
        );
        return Err(Error::Value { key: "trial", value: trial.words(), reason });
    }
    Ok(Experiment::parse(&trial.config, &trial.name, &Overrides::default(), registry)?)
}

/// Gives a finished run folder its name; one that somebody else has finished first stays.
pub(crate) fn publish(work: &Path, out: &Path) -> Result<()> {
    match fs::rename(work, out) {
        Ok(()) => taxel_base::files::sync_folder(out).map_err(|e| Error::io(out, "written", e)),
        Err(_) if out.join("results.json").is_file() => Ok(()),
        Err(e) => Err(Error::io(out, "written", e)),
    }
}
