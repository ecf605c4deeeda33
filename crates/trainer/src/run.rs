//! An experiment from start to end: networks × repetitions × folds into a run folder.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use taxel_data::Fold;
use taxel_graph::Graph;
use taxel_zoo::{Entry, Settings};

use crate::assemble::assemble;
use crate::checkpoint::{Metadata, write_checkpoint};
use crate::config::{Network, Train};
use crate::encode::{Encoder, Input};
use crate::environment::{Environment, cores};
use crate::error::{Error, Result};
use crate::experiment::{Experiment, settings};
use crate::files::Lock;
use crate::folder::{RunFolder, keys, write_json};
use crate::metrics::argmax;
use crate::progress::Progress;
use crate::results::{FoldKey, FoldRecord, NetworkResults, Results, Timing};
use crate::samples::Samples;
use crate::train::{Latency, Task};

/// How an experiment is run; none of it changes a result.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RunOptions {
    /// The run folder. Default `runs/<name>`.
    pub out: Option<PathBuf>,
    /// Whether the folder may hold a run of the same config: its finished folds are kept.
    pub resume: bool,
    /// Worker threads. Default one per core.
    pub threads: Option<usize>,
}

/// A network of the experiment, fitted to the samples.
struct Candidate<'a> {
    config: &'a Network,
    train: Train,
    entry: &'static Entry,
    settings: Settings,
    graph: Graph,
}

/// Runs `experiment` and writes its run folder; a set `cancel` ends it between two steps.
///
/// # Errors
/// Data that cannot be loaded or encoded, a network that does not fit them, a folder that holds
/// something else, training that diverges; [`Error::Cancelled`] if `cancel` was set. Finished folds
/// are on disk in every case.
pub fn run(
    experiment: &Experiment,
    options: &RunOptions,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<RunFolder> {
    let samples = Samples::load(experiment)?;
    run_on(experiment, &samples, options, progress, cancel)
}

/// [`run`] on samples that are loaded already.
///
/// # Errors
/// As [`run`].
pub fn run_on(
    experiment: &Experiment,
    samples: &Samples,
    options: &RunOptions,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<RunFolder> {
    let config = experiment.config();
    let entries: Vec<&'static Entry> =
        config.networks.iter().map(|n| Ok(taxel_zoo::find(&n.name)?)).collect::<Result<_>>()?;
    let wanted: Vec<&str> = entries.iter().flat_map(|e| e.inputs).map(|input| input.name).collect();
    let encoder = Encoder::new(experiment, samples, &wanted)?;
    let mut candidates = vec![];
    for (config_of, entry) in config.networks.iter().zip(entries) {
        let mut fitted = entry.fit(samples.classes.len(), |input| encoder.shape(input))?;
        fitted.extend(settings(&config_of.set));
        let graph = entry.graph(&fitted)?;
        let train = config_of.train(&config.train);
        candidates.push(Candidate { config: config_of, train, entry, settings: fitted, graph });
    }
    let folds: Vec<Vec<Fold>> = (0..config.protocol.repetitions)
        .map(|repetition| samples.folds(experiment, repetition))
        .collect::<Result<_>>()?;
    let out = options.out.clone().unwrap_or_else(|| experiment.default_out());
    let (folder, lock) = RunFolder::prepare(&out, experiment, options.resume)?;
    let threads = options.threads.unwrap_or_else(cores).max(1);
    let mut run = Run {
        experiment,
        samples,
        encoder,
        all: keys(config.networks.iter().map(Network::label), folds.len(), config.protocol.folds),
        results: empty_results(experiment, samples, &candidates),
        candidates,
        folds,
        folder,
        threads,
        records: vec![],
        timings: vec![],
        _lock: lock,
    };
    run.begin()?;
    let outcome = run.all_folds(progress, cancel);
    progress.finish();
    // Also after an error: what was finished must be readable.
    run.assemble()?;
    outcome?;
    Ok(run.folder)
}

struct Run<'a> {
    experiment: &'a Experiment,
    samples: &'a Samples,
    encoder: Encoder<'a>,
    candidates: Vec<Candidate<'a>>,
    folds: Vec<Vec<Fold>>,
    folder: RunFolder,
    threads: usize,
    all: Vec<FoldKey>,
    results: Results,
    records: Vec<FoldRecord>,
    timings: Vec<Timing>,
    _lock: Lock,
}

impl Run<'_> {
    /// Takes over what an earlier run of the folder has finished.
    fn begin(&mut self) -> Result<()> {
        if self.folder.file("results.json").is_file() {
            let before = self.folder.results()?;
            if before.data_digest != self.samples.digest {
                let reason = format!(
                    "was run on other data ({} {}, now {} {}); give another --out",
                    before.source, before.data_digest, self.samples.source, self.samples.digest
                );
                return Err(Error::folder(self.folder.path(), reason));
            }
        }
        for key in &self.all {
            let path = self.folder.record_path(key);
            let Some(record) = self.folder.record(key)? else { continue };
            if record.key != *key || record.index != self.folds[key.repetition][key.fold].test {
                let reason = "belongs to another split; give another --out, or delete the run folder";
                return Err(Error::damaged(&path, reason));
            }
            self.timings.extend(self.folder.timing(key)?);
            self.records.push(record);
        }
        let environment = self.folder.file("environment.json");
        if !environment.is_file() {
            let seed = self.experiment.config().seed;
            let now = Environment::now(self.threads, seed, &self.samples.source, &self.samples.digest);
            write_json(&environment, &now, true)?;
        }
        self.assemble()
    }

    fn all_folds(&mut self, progress: &dyn Progress, cancel: &AtomicBool) -> Result<()> {
        let open: Vec<(usize, FoldKey)> = self
            .all
            .iter()
            .filter(|key| !self.records.iter().any(|r| r.key == **key))
            .filter_map(|key| {
                let network = self.candidates.iter().position(|c| c.config.label() == key.network)?;
                Some((network, key.clone()))
            })
            .collect();
        let work = |(network, key): &(usize, FoldKey)| {
            let candidate = &self.candidates[*network];
            let samples = self.folds[key.repetition][key.fold].train.len() * candidate.train.epochs;
            work_per_sample(&candidate.graph) * samples as u64
        };
        progress.start(open.iter().map(work).sum());
        let (begin, mut assembling) = (Instant::now(), 0.0);
        let finished = self.records.len();
        for (done, (network, key)) in open.into_iter().enumerate() {
            progress.fold(&key, finished + done + 1, self.all.len());
            if !self.one_fold(network, key, progress, cancel)? {
                return Err(Error::Cancelled {
                    done: self.records.len(),
                    total: self.all.len(),
                    folder: self.folder.path().display().to_string(),
                });
            }
            // After every fold, unless that would take a share of the time worth mentioning.
            if assembling * 20.0 <= begin.elapsed().as_secs_f64() {
                let start = Instant::now();
                self.assemble()?;
                assembling += start.elapsed().as_secs_f64();
            }
        }
        Ok(())
    }

    /// Trains, tests and writes one fold; false if it was cancelled.
    fn one_fold(
        &mut self,
        network: usize,
        key: FoldKey,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<bool> {
        let candidate = &self.candidates[network];
        let fold = &self.folds[key.repetition][key.fold];
        let inputs: Vec<Input> = self.encoder.fit(&fold.train)?;
        let task = Task {
            label: candidate.config.label(),
            graph: &candidate.graph,
            train: &candidate.train,
            seed: self.experiment.config().seed,
            repetition: key.repetition,
            fold: key.fold,
            threads: self.threads,
        };
        let weight = work_per_sample(&candidate.graph);
        let mut tick = |samples: usize| progress.step(weight * samples as u64);
        let Some(trained) = task.run(&inputs, &self.samples.y, fold, &mut tick, cancel)? else {
            return Ok(false);
        };
        let own: Vec<&Input> =
            candidate.graph.inputs().filter_map(|node| inputs.iter().find(|i| i.name == node.name)).collect();
        let metadata = Metadata {
            network: candidate.entry.name.into(),
            settings: candidate.settings.clone(),
            classes: self.samples.classes.clone(),
            inputs: own.iter().map(|i| (i.name.to_string(), i.transform.clone())).collect(),
            source: self.samples.source.clone(),
            seed: task.seed,
            repetition: key.repetition,
            fold: key.fold,
        };
        write_checkpoint(&self.folder.model_path(&key), &candidate.graph, &trained.weights, &metadata)?;
        let first = !self.timings.iter().any(|t| t.key.network == key.network && t.latency.is_some());
        let latency = match fold.test.first() {
            Some(&row) if first => Some(Latency::measure(&candidate.graph, &trained.weights, &inputs, row)?),
            _ => None,
        };
        let seen = (fold.train.len() * candidate.train.epochs) as u64;
        let timing = Timing {
            key: key.clone(),
            train_seconds: trained.train_seconds,
            samples: seen,
            samples_per_second: seen as f64 / trained.train_seconds.max(1e-9),
            test_seconds: trained.test_seconds,
            threads: self.threads,
            encoding_ms_per_sample: own.iter().map(|i| i.ms_per_sample).sum(),
            latency,
        };
        self.timings.push(write_json(&self.folder.timing_path(&key), &timing, true)?);
        let record = FoldRecord {
            train_samples: fold.train.len(),
            index: fold.test.clone(),
            truth: fold.test.iter().map(|&row| self.samples.y[row]).collect(),
            predicted: argmax(&trained.probabilities, self.samples.classes.len()),
            probabilities: trained.probabilities,
            epochs: trained.epochs,
            key,
        };
        // Last: a fold with a record is a finished fold.
        let path = self.folder.record_path(&record.key);
        self.records.push(write_json(&path, &record, false)?);
        Ok(true)
    }

    fn assemble(&mut self) -> Result<()> {
        let place = |key: &FoldKey| self.all.iter().position(|k| k == key);
        self.records.sort_by_key(|r| place(&r.key));
        self.timings.sort_by_key(|t| place(&t.key));
        assemble(&self.folder, &mut self.results, &self.all, &self.records, &self.timings)
    }
}

/// Multiply-accumulates, and something for what a small network spends besides them.
fn work_per_sample(graph: &Graph) -> u64 {
    graph.cost().macs + 200_000
}

fn empty_results(experiment: &Experiment, samples: &Samples, candidates: &[Candidate<'_>]) -> Results {
    let config = experiment.config();
    let network = |c: &Candidate<'_>| NetworkResults {
        network: c.config.label().into(),
        zoo: c.entry.name.into(),
        paper: c.entry.paper.into(),
        settings: c.settings.clone(),
        costs: c.graph.cost().into(),
        folds: vec![],
        mean: None,
        sd: None,
        confusion: None,
        published: c.config.published.clone(),
    };
    Results {
        name: config.name.clone(),
        title: config.title.clone(),
        complete: false,
        missing: vec![],
        source: samples.source.clone(),
        data_digest: samples.digest.clone(),
        samples: samples.len(),
        sample_shape: samples.shape().to_vec(),
        classes: samples.classes.clone(),
        protocol: config.protocol.clone(),
        seed: config.seed,
        unit: "percent".into(),
        networks: candidates.iter().map(network).collect(),
    }
}
