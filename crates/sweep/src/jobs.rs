//! Many trials in one process: jobs take them one by one, in the order of the manifest.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use taxel_zoo::Registry;

use crate::error::{Error, Result};
use crate::folder::SweepFolder;
use crate::manifest::Manifest;
use crate::samples::TrialSamples;
use crate::trial::Trial;
use crate::work::{TrialOutcome, WorkOptions, Worker};

/// Time between two looks at a trial that somebody else is at.
const LOOK: Duration = Duration::from_millis(500);

/// Counts of outcomes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Finished now.
    pub finished: usize,
    /// Finished before.
    pub before: usize,
    /// Could not be run.
    pub failed: usize,
    /// Whether it was stopped from outside with something left to do.
    pub stopped: bool,
}

/// Runs the trials of `range` that are not finished, `jobs` at a time; each job has the threads of its place in
/// `shares`. Trials that others are at are waited for: either they finish, or their lock turns stale.
///
/// `say` hears what came of each trial.
///
/// # Errors
/// A sweep folder that cannot be read or written. What a trial ends with is no error.
pub fn work(
    folder: &SweepFolder,
    range: Range<usize>,
    shares: &[usize],
    options: &WorkOptions,
    registry: &Registry,
    say: &(dyn Fn(usize, &Trial, &TrialOutcome) + Sync),
) -> Result<Tally> {
    folder.make()?;
    let samples = TrialSamples::default();
    let queue = Queue {
        options,
        say,
        open: Mutex::new(Manifest::open(folder, range.start)?.take(range.len())),
        held: Mutex::default(),
        tally: Mutex::default(),
    };
    let ends: Vec<Result<()>> = std::thread::scope(|scope| {
        let jobs: Vec<_> = shares
            .iter()
            .map(|&threads| {
                let mut worker = Worker { folder, registry, options, threads, loader: samples.loader() };
                let queue = &queue;
                scope.spawn(move || queue.empty(&mut worker))
            })
            .collect();
        let panicked = || Err(Error::file(folder.path(), "a job ended before its time; run the sweep again"));
        jobs.into_iter().map(|job| job.join().unwrap_or_else(|_| panicked())).collect()
    });
    ends.into_iter().collect::<Result<()>>()?;
    Ok(queue.tally.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Returns the threads of each of `jobs` jobs, at most one job per thread: together they are `threads`.
pub fn shares(threads: usize, jobs: usize) -> Vec<usize> {
    let threads = threads.max(1);
    let jobs = jobs.clamp(1, threads);
    (0..jobs).map(|job| threads / jobs + usize::from(job < threads % jobs)).collect()
}

struct Held {
    number: usize,
    trial: Trial,
    /// When it was looked at; none where its turn comes for the first time.
    seen: Option<Instant>,
}

struct Queue<'a> {
    options: &'a WorkOptions,
    say: &'a (dyn Fn(usize, &Trial, &TrialOutcome) + Sync),
    open: Mutex<std::iter::Take<Manifest>>,
    /// Trials that other processes worked on, the one that was checked longest ago first.
    held: Mutex<VecDeque<Held>>,
    tally: Mutex<Tally>,
}

impl Queue<'_> {
    fn empty(&self, worker: &mut Worker) -> Result<()> {
        while let Some(next) = self.next() {
            let (number, trial) = next?;
            if self.is_stopped() {
                self.count(|tally| tally.stopped = true);
                return Ok(());
            }
            self.one(worker, Held { number, trial, seen: None })?;
        }
        loop {
            let next = self.held.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
            let Some(held) = next else { return Ok(()) };
            if self.is_stopped() {
                self.count(|tally| tally.stopped = true);
                return Ok(());
            }
            if let Some(seen) = held.seen {
                std::thread::sleep(LOOK.saturating_sub(seen.elapsed()));
            }
            self.one(worker, held)?;
        }
    }

    fn next(&self) -> Option<Result<(usize, Trial)>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner).next()
    }

    /// Works on one trial. That somebody else is at it is news once.
    fn one(&self, worker: &mut Worker, held: Held) -> Result<()> {
        let outcome = worker.one(&held.trial)?;
        if held.seen.is_none() || !matches!(outcome, TrialOutcome::Held(_)) {
            (self.say)(held.number, &held.trial, &outcome);
        }
        self.count(|tally| match &outcome {
            TrialOutcome::Finished { .. } => tally.finished += 1,
            TrialOutcome::Before => tally.before += 1,
            TrialOutcome::Failed(_) => tally.failed += 1,
            TrialOutcome::Stopped => tally.stopped = true,
            TrialOutcome::Held(_) => {}
        });
        if let TrialOutcome::Held(_) = outcome {
            let held = Held { seen: Some(Instant::now()), ..held };
            self.held.lock().unwrap_or_else(PoisonError::into_inner).push_back(held);
        }
        Ok(())
    }

    fn count(&self, add: impl FnOnce(&mut Tally)) {
        add(&mut self.tally.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn is_stopped(&self) -> bool {
        self.options.stop.load(Ordering::Relaxed) || self.options.cancel.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::*;

    #[test]
    fn shares_are_the_threads_together() {
        assert_eq!(shares(8, 3), [3, 3, 2]);
        assert_eq!(shares(2, 2), [1, 1]);
        assert_eq!(shares(2, 5), [1, 1], "more jobs than threads would stand in each other's way");
        assert_eq!(shares(4, 0), [4]);
    }

    /// Checks that a signal between two trials does not look like the end of the work.
    #[test]
    fn what_is_stopped_before_a_trial_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let folder = SweepFolder::at(dir.path());
        let line = r#"{"identity":"0123456789abcdef0","name":"t","program":"","config":"",
            "data":{"source":"","digest":"","set":""}}"#;
        std::fs::write(folder.manifest(), format!("{}\n", line.replace('\n', " "))).unwrap();
        let options = |stop| WorkOptions {
            save_every: None,
            stale: Duration::from_secs(60),
            stop: Arc::new(AtomicBool::new(stop)),
            cancel: Arc::default(),
        };
        let tally = |stop| {
            let registry = Registry::built_in();
            work(&folder, 0..usize::MAX, &[1, 1], &options(stop), &registry, &|_, _, _| {}).unwrap()
        };
        assert_eq!(tally(true), Tally { stopped: true, ..Tally::default() });
        assert_eq!(tally(false).failed, 1, "planned by another program");
    }
}
