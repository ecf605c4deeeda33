//! All that is finished on one page; what is not, by name.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::time::Duration;

use taxel_judge::{Criteria, rank};
use taxel_zoo::Registry;

use crate::collected::{OpenTrial, Sweep};
use crate::error::{Error, Result};
use crate::folder::SweepFolder;
use crate::gather::put_together;
use crate::json;
use crate::lease::{begun, tidy_all, tidy_up};
use crate::manifest::Manifest;
use crate::page::sweep_page;
use crate::record::{Failure, TrialResult, TrialTiming};
use crate::samples::{Loader, TrialSamples};
use crate::tables::ResultTables;
use crate::tally::Tally;
use crate::trial::{Trial, TrialFold};

/// Trials without a result that the page names, failed ones before others; `trials.csv` has all.
const NAMED: usize = 200;
/// Values of a key beyond which it is no axis of the page.
const VALUES: usize = 300;

/// Reads every result once, puts runs whose folds are finished together, and writes the page `index.html` with
/// `trials.csv` and `scores.csv` beside it. A trial counts once, however often the manifest names it.
///
/// # Errors
/// A manifest or result that is damaged, a file that cannot be written.
pub fn collect(
    folder: &SweepFolder,
    name: &str,
    registry: &Registry,
    stale: Duration,
) -> Result<(Sweep, PathBuf)> {
    let out = folder.collected();
    std::fs::create_dir_all(&out).map_err(|e| Error::io(&out, "created", e))?;
    let keys = keys(folder)?;
    let samples = TrialSamples::default();
    let mut collector = Collector {
        folder,
        registry,
        loader: samples.loader(),
        stale,
        begun: begun(folder)?,
        seen: HashSet::new(),
        folds: HashMap::new(),
        tally: Tally::new(),
        sweep: Sweep { name: name.into(), ..Sweep::default() },
        waiting: vec![],
    };
    let mut tables = ResultTables::new(&out, &keys)?;
    for next in Manifest::open(folder, 0)? {
        let (number, trial) = next?;
        collector.trial(number, &trial, &mut tables)?;
    }
    tables.finish()?;
    let sweep = collector.finish()?;
    let page = sweep_page(&sweep, &out)?;
    Ok((sweep, page))
}

/// Returns every key that the manifest varies, in the order of the alphabet.
fn keys(folder: &SweepFolder) -> Result<Vec<String>> {
    let mut keys = HashSet::new();
    for next in Manifest::open(folder, 0)? {
        for key in next?.1.set.keys() {
            if !keys.contains(key) {
                keys.insert(key.clone());
            }
        }
    }
    let mut keys: Vec<String> = keys.into_iter().collect();
    keys.sort();
    Ok(keys)
}

struct Collector<'a> {
    folder: &'a SweepFolder,
    registry: &'a Registry,
    loader: Loader<'a>,
    stale: Duration,
    begun: HashSet<String>,
    seen: HashSet<String>,
    /// Finished folds of runs that are not put together yet.
    folds: HashMap<String, Vec<(String, TrialFold)>>,
    tally: Tally,
    /// The failed ones of the trials without a result stand here first.
    sweep: Sweep,
    /// The first of the others without a result.
    waiting: Vec<OpenTrial>,
}

impl Collector<'_> {
    fn trial(&mut self, number: usize, trial: &Trial, tables: &mut ResultTables) -> Result<()> {
        let progress = &mut self.sweep.progress;
        if !self.seen.insert(trial.identity.clone()) {
            progress.duplicates += 1;
            return Ok(());
        }
        progress.planned += 1;
        let Some(result) = TrialResult::read(self.folder, &trial.identity)? else {
            let (state, reason) = self.state(trial)?;
            self.count(state);
            tables.trial(number, trial, state, &reason, None)?;
            let named = if state == "failed" { &mut self.sweep.open } else { &mut self.waiting };
            if named.len() < NAMED {
                let (trial, state) = (trial.words(), state.into());
                named.push(OpenTrial { number, trial, state, reason });
            }
            return Ok(());
        };
        let timing = TrialTiming::read(self.folder, &trial.identity)?;
        self.sweep.progress.finished += 1;
        self.sweep.progress.seconds += timing.as_ref().map_or(0.0, |timing| timing.seconds);
        tables.trial(number, trial, "finished", "", timing.as_ref())?;
        if self.is_begun(&trial.identity) {
            tidy_up(self.folder, &trial.identity)?;
        }
        match &trial.fold {
            None => self.score(trial, &result, tables),
            Some(piece) => self.fold(trial, piece, tables),
        }
    }

    /// Counts the fold of a run; the last one puts it together.
    fn fold(&mut self, trial: &Trial, piece: &TrialFold, tables: &mut ResultTables) -> Result<()> {
        let folds = self.folds.entry(piece.run.clone()).or_default();
        folds.push((trial.identity.clone(), piece.clone()));
        if folds.len() < piece.of {
            return Ok(());
        }
        let folds = self.folds.remove(&piece.run).unwrap_or_default();
        let with = (self.registry, &mut self.loader);
        match put_together(self.folder, &folds, trial, with, self.stale) {
            Ok(Some(result)) => {
                tidy_up(self.folder, &piece.run)?;
                self.score(&Trial { fold: None, ..trial.clone() }, &result, tables)
            }
            Ok(None) => {
                let note = format!("{}: another process puts its folds together.", trial.name);
                self.sweep.notes.push(note);
                Ok(())
            }
            Err(error) => {
                let note = format!("{}: its folds cannot be put together: {error}", trial.name);
                self.sweep.notes.push(note);
                Ok(())
            }
        }
    }

    fn score(&mut self, trial: &Trial, result: &TrialResult, tables: &mut ResultTables) -> Result<()> {
        self.tally.add(trial, result);
        tables.scores(trial, result, &self.folder.run(&trial.name, &result.identity))
    }

    /// Returns the state of a trial without a result, and why.
    fn state(&self, trial: &Trial) -> Result<(&'static str, String)> {
        let failure: Option<Failure> = json::read(&self.folder.failure(&trial.identity))?;
        if let Some(failure) = failure {
            return Ok(("failed", failure.error));
        }
        Ok((if self.is_begun(&trial.identity) { "begun" } else { "missing" }, String::new()))
    }

    /// Checks whether somebody took it up and has not tidied up yet.
    fn is_begun(&self, identity: &str) -> bool {
        let lease = self.folder.lease(identity, 1);
        self.begun.contains(&*lease.file_stem().unwrap_or_default().to_string_lossy())
    }

    fn count(&mut self, state: &str) {
        let progress = &mut self.sweep.progress;
        match state {
            "failed" => progress.failed += 1,
            "begun" => progress.begun += 1,
            _ => progress.missing += 1,
        }
    }

    fn finish(mut self) -> Result<Sweep> {
        if self.sweep.progress.finished == self.sweep.progress.planned {
            tidy_all(self.folder)?;
        }
        self.sweep.open.append(&mut self.waiting);
        self.sweep.open.truncate(NAMED);
        self.sweep.settings = self.tally.settings();
        self.sweep.axes = self.tally.axes(VALUES);
        match self.tally.contests() {
            Some(contests) => {
                if contests.iter().any(|contest| contest.primary != contests[0].primary) {
                    let note = "Data sets are scored by different metrics: no ranks over them.";
                    self.sweep.notes.push(note.into());
                }
                self.sweep.across = rank(&contests, Criteria::default().alpha)?;
            }
            None => self.sweep.notes.push("Too many settings for ranks over data sets.".into()),
        }
        if !self.folds.is_empty() {
            let note = format!("{} runs wait for folds; their scores are not here yet.", self.folds.len());
            self.sweep.notes.push(note);
        }
        let duplicates = self.sweep.progress.duplicates;
        if duplicates > 0 {
            let note = format!("{duplicates} lines of the manifest name a trial again; each counts once.");
            self.sweep.notes.push(note);
        }
        Ok(self.sweep)
    }
}
