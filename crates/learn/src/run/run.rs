//! A run from start to end: every row on every fold, into a run folder or into memory.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use taxel_data::{Dataset, Facts};

use crate::error::{Error, Result};
use crate::estimator::candidate::Candidate;
use crate::estimator::train_fold::{FoldJob, train_fold};
use crate::json_file::write_json;
use crate::model::Model;
use crate::progress::Progress;
use crate::run::assemble::{assemble, fill};
use crate::run::environment::Environment;
use crate::run::folder::{ENVIRONMENT, RunFolder};
use crate::run::model_latency::of_model;
use crate::run::options::RunOptions;
use crate::run::plan::{RunPlan, shortcut};
use crate::run::quantized_run::kept;
use crate::run::records::{FoldKey, FoldRecord, Timing};
use crate::run::results::Results;
#[cfg(feature = "tensorboard")]
use crate::run::tensorboard;
use crate::training::feature_cache::FeatureCache;
use crate::training::hooks::Hooks;
use crate::training::session::Saver;

/// A run that is under way.
pub(crate) struct ActiveRun<'a> {
    plan: RunPlan<'a>,
    folder: Option<RunFolder>,
    options: &'a RunOptions,
    records: Vec<FoldRecord>,
    timings: Vec<Timing>,
    /// Folds whose training left the finite numbers.
    stopped: Vec<FoldKey>,
    cache: FeatureCache,
}

/// The record and the timing of a finished fold.
struct Finished {
    record: FoldRecord,
    timing: Timing,
}

impl<'a> ActiveRun<'a> {
    /// Makes a run that writes to `folder`, or keeps its records in memory.
    pub fn new(mut plan: RunPlan<'a>, options: &'a RunOptions, folder: Option<RunFolder>) -> Self {
        plan.results.shortcut = shortcut(plan.dataset);
        ActiveRun {
            plan,
            folder,
            options,
            records: vec![],
            timings: vec![],
            stopped: vec![],
            cache: FeatureCache::default(),
        }
    }

    /// Takes over what an earlier run of the folder has finished.
    ///
    /// # Errors
    /// A folder that was run on other data, or a fold of another split; times that would stand beside those of another
    /// machine.
    pub fn begin(&mut self, progress: &dyn Progress) -> Result<()> {
        let Some(folder) = self.folder.clone() else { return Ok(()) };
        let dataset = self.plan.dataset;
        let threads = self.options.threads();
        let now = Environment::now(threads, self.plan.seed, &dataset.source, &dataset.digest);
        let now = Environment { facts: Some(dataset.facts()), ..now };
        let environment: Option<Environment> = folder.read(ENVIRONMENT)?;
        if let Some(before) = &environment {
            let then = before.facts.as_ref().map(Facts::digest);
            folder.same_data(ENVIRONMENT, &before.data_digest, then.as_deref(), dataset)?;
        }
        let moved = environment.as_ref().and_then(|before| before.another_machine(&now));
        if let (Some(moved), true) = (&moved, self.options.time_again) {
            let way = "a table has the times of one machine; run the experiment here into another folder";
            return Err(Error::folder(folder.path(), format!("{moved}: {way}")));
        }
        let before = if folder.file("results.json").is_file() { Some(folder.results()?) } else { None };
        if let Some(before) = &before {
            folder.same_data("results.json", &before.data_digest, before.data_facts.as_deref(), dataset)?;
        }
        for key in &self.plan.keys {
            let Some(record) = folder.record(key)? else { continue };
            if let Some(data) = &record.data {
                folder.same_data(&format!("folds/{key}.json"), data, record.facts.as_deref(), dataset)?;
            }
            Saver::remove(&folder.session_path(key))?;
            if record.key != *key || Some(&record.index) != self.plan.fold(key).map(|fold| &fold.test) {
                let reason = "belongs to another split; give another folder, or delete the run folder";
                return Err(Error::damaged(&folder.record_path(key), reason));
            }
            let network = self.candidate(key).and_then(Candidate::network_digest);
            if record.facts.is_some() && record.network_digest != network {
                let reason = "was trained with another network or from other weights than the files that the config names \
                              hold now (`weights`, `file`, `onnx`); bring them back, or run it again in another folder";
                return Err(Error::damaged(&folder.record_path(key), reason));
            }
            folder.check(&record, key, dataset)?;
            self.timings.extend(timed(&folder, &record, dataset, self.options.time_again)?);
            self.records.push(self.completed(&folder, record)?);
        }
        if let (Some(moved), Some(_)) = (&moved, self.open().next()) {
            let folder = self.folder_name();
            progress.say(&format!("{folder}: {moved}: what is trained now may end a little elsewhere"));
        }
        if let Some(before) = before {
            self.keep_eight_bits(&folder, before)?;
        }
        if environment.is_none() {
            write_json(&folder.file(ENVIRONMENT), &now, true)?;
        }
        self.assemble()
    }

    /// Takes over the rows that `taxel quantize` has put beside finished networks.
    fn keep_eight_bits(&mut self, folder: &RunFolder, before: Results) -> Result<()> {
        let (dataset, again) = (self.plan.dataset, self.options.time_again);
        for (row, records) in kept(folder, before, &self.records, dataset)? {
            let RunPlan { results, keys, .. } = &mut self.plan;
            let float = row.quantized.as_deref();
            let beside = results.networks.iter().position(|row| Some(row.network.as_str()) == float);
            let after = keys.iter().rposition(|key| Some(key.network.as_str()) == float);
            let (Some(beside), Some(after)) = (beside, after) else { continue };
            results.networks.insert(beside + 1, row);
            for (place, record) in (after + 1..).zip(records) {
                keys.insert(place, record.key.clone());
                self.timings.extend(timed(folder, &record, dataset, again)?);
                self.records.push(record);
            }
        }
        Ok(())
    }

    /// Returns a record with its digests; those of an older version are added, if its model file is that of the fold.
    fn completed(&self, folder: &RunFolder, record: FoldRecord) -> Result<FoldRecord> {
        if record.data.is_some() && record.model.is_some() {
            return Ok(record);
        }
        let (key, data, seed) = (&record.key, &self.plan.dataset.digest, self.plan.seed);
        let network = self.candidate(key).map_or("", |candidate| candidate.name.as_str());
        let model = Some(folder.older_model(key, network, data, seed)?);
        let path = folder.record_path(key);
        write_json(&path, &FoldRecord { data: Some(data.clone()), model, ..record }, false)
    }

    /// Folds that are to be trained and are not finished yet.
    fn open(&self) -> impl Iterator<Item = &FoldKey> {
        let is_finished = |key: &FoldKey| self.records.iter().any(|record| record.key == *key);
        self.plan.keys.iter().filter(move |key| self.options.wants(key) && !is_finished(key))
    }

    /// Trains and tests what is not finished yet. In a folder a training that diverges is left aside, and the
    /// others go on.
    ///
    /// # Errors
    /// An error of a training; [`Error::Unfinished`] if some diverged, [`Error::Cancelled`] if `cancel` was set.
    pub fn all(&mut self, progress: &dyn Progress, cancel: &AtomicBool) -> Result<()> {
        let open: Vec<FoldKey> = self.open().cloned().collect();
        progress.start(open.iter().map(|key| self.work(key)).sum());
        let (begin, mut assembling) = (Instant::now(), 0.0);
        let (before, count, mut errors) = (self.records.len(), open.len(), vec![]);
        for (done, key) in open.into_iter().enumerate() {
            progress.fold(&key, before + done + 1, self.plan.keys.len());
            let finished =
                if self.options.is_stopping() { Ok(None) } else { self.one(&key, progress, cancel) };
            match finished {
                Ok(Some(Finished { record, timing })) => self.keep(record, timing)?,
                Ok(None) => {
                    let (done, total) = (self.records.len(), self.plan.keys.len());
                    return Err(Error::Cancelled { done, total, folder: self.folder_name() });
                }
                Err(error) if error.is_divergence() && self.folder.is_some() => {
                    progress.say(&format!("{error}; the other folds go on"));
                    self.set_aside(key)?;
                    errors.push(error);
                }
                Err(error) => return Err(error),
            }
            // After every fold but the last, whose caller assembles in any case, unless that would take a share of
            // the time worth mentioning.
            if self.folder.is_some() && done + 1 < count && assembling * 20.0 <= begin.elapsed().as_secs_f64()
            {
                let start = Instant::now();
                self.assemble()?;
                assembling += start.elapsed().as_secs_f64();
            }
        }
        if errors.is_empty() {
            Ok(())
        } else {
            let (total, folder) = (self.plan.keys.len(), self.folder_name());
            Err(Error::Unfinished { folds: errors, total, folder })
        }
    }

    /// Returns the path of the folder as text; empty where nothing is written.
    fn folder_name(&self) -> String {
        self.folder.as_ref().map_or(String::new(), |folder| folder.path().display().to_string())
    }

    /// Leaves a fold unfinished; what was saved of it would only diverge again.
    fn set_aside(&mut self, key: FoldKey) -> Result<()> {
        if let Some(folder) = &self.folder {
            Saver::remove(&folder.session_path(&key))?;
        }
        self.stopped.push(key);
        Ok(())
    }

    /// Returns the multiply-accumulates of a fold's training; baselines cost next to nothing.
    fn work(&self, key: &FoldKey) -> u64 {
        let (Some(candidate), Some(fold)) = (self.candidate(key), self.plan.fold(key)) else { return 0 };
        candidate.estimator.work_per_sample() * candidate.estimator.samples(fold) as u64
    }

    fn candidate(&self, key: &FoldKey) -> Option<&Candidate> {
        Some(&self.plan.candidates[self.plan.row(key)?.candidate])
    }

    /// Trains and tests one fold; none if it was cancelled.
    fn one(&self, key: &FoldKey, progress: &dyn Progress, cancel: &AtomicBool) -> Result<Option<Finished>> {
        #[expect(clippy::expect_used, reason = "keys are made of the plan's rows")]
        let candidate = self.candidate(key).expect("a row of the plan");
        let RunPlan { dataset, encoder, protocol, seed, .. } = &self.plan;
        let fold = self.fold(key);
        let job = FoldJob {
            candidate,
            protocol,
            seed: *seed,
            place: Some((key.repetition, key.fold)),
            fold,
            threads: self.options.threads(),
            teacher: None,
            cache: &self.cache,
            is_timed: self.is_first(key),
        };
        let weight = candidate.estimator.work_per_sample();
        let mut tick = |samples: usize| progress.step(weight * samples as u64);
        let mut saver = match &self.folder {
            Some(folder) => Saver::new(folder.session_path(key), self.options),
            None => Saver::none(),
        };
        let mut hooks = Hooks { tick: &mut tick, cancel, saver: &mut saver };
        let Some(trained) = train_fold(&job, encoder, &mut hooks)? else { return Ok(None) };
        let model = self.write_model(key, &trained.model)?;
        let record = trained.record(key, dataset, fold, model)?;
        let record = FoldRecord { network_digest: candidate.network_digest(), ..record };
        let timing = Timing {
            key: key.clone(),
            train_seconds: trained.trained.train_seconds,
            samples: trained.trained.samples,
            test_seconds: trained.trained.test_seconds,
            threads: self.options.threads(),
            encoding_ms_per_sample: trained.encoding_ms_per_sample,
            latency_without_encoding: None,
            latency: trained.latency,
        };
        Ok(Some(Finished { record, timing }))
    }

    /// Writes the model of a fold, where there is a folder; gives its digest.
    fn write_model(&self, key: &FoldKey, model: &Model) -> Result<Option<String>> {
        self.folder.as_ref().map(|folder| model.write(&folder.model_path(key))).transpose()
    }

    fn fold(&self, key: &FoldKey) -> &taxel_data::Fold {
        #[expect(clippy::expect_used, reason = "keys are made of the plan's folds")]
        self.plan.fold(key).expect("a fold of the plan")
    }

    /// Checks whether this fold is the one of its row whose predictions are timed.
    fn is_first(&self, key: &FoldKey) -> bool {
        self.plan.keys.iter().find(|other| other.network == key.network) == Some(key)
    }

    fn keep(&mut self, record: FoldRecord, timing: Timing) -> Result<()> {
        let Some(folder) = &self.folder else {
            self.timings.push(timing);
            self.records.push(record);
            return Ok(());
        };
        self.timings.push(write_json(&folder.timing_path(&timing.key), &timing, true)?);
        #[cfg(feature = "tensorboard")]
        tensorboard::write(folder, &record, &self.plan.dataset.task())?;
        // Last: a fold with a record is a finished fold.
        self.records.push(write_json(&folder.record_path(&record.key), &record, false)?);
        Saver::remove(&folder.session_path(&record.key))
    }

    /// Writes everything that follows from the finished folds.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn assemble(&mut self) -> Result<()> {
        let place = |key: &FoldKey| self.plan.keys.iter().position(|k| k == key);
        self.records.sort_by_key(|r| place(&r.key));
        self.timings.sort_by_key(|t| place(&t.key));
        let plan = &mut self.plan;
        fill(&mut plan.results, &plan.keys, &self.records, &plan.frame)?;
        for network in &mut plan.results.networks {
            network.diverged += self.stopped.iter().filter(|key| key.network == network.network).count();
        }
        match &self.folder {
            Some(folder) => assemble(folder, &plan.results, &self.records, &self.timings),
            None => Ok(()),
        }
    }

    /// Returns the scores of all that is finished.
    ///
    /// # Errors
    /// Records that do not fit the data.
    pub fn into_results(mut self) -> Result<Results> {
        self.assemble()?;
        Ok(self.plan.results)
    }
}

/// Returns the timing of a finished fold; measures the latency of the table anew if it is to be timed again.
fn timed(folder: &RunFolder, record: &FoldRecord, dataset: &Dataset, again: bool) -> Result<Option<Timing>> {
    let known = folder.timing(&record.key)?;
    let Some(before) = known.as_ref().filter(|timing| again && timing.is_timed()) else {
        return Ok(known);
    };
    let latency = Some(of_model(&folder.model(record)?, dataset, record.index[0])?);
    write_json(&folder.timing_path(&record.key), &Timing { latency, ..before.clone() }, false).map(Some)
}
