//! An experiment from start to end: networks × repetitions × folds into a run folder.

use std::path::PathBuf;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use taxel_data::Fold;
use taxel_graph::{Graph, Weights};
use taxel_rivals::Method;
use taxel_zoo::{Entry, Settings};

use crate::assemble::assemble;
use crate::checkpoint::{Metadata, write_checkpoint, write_tensors};
use crate::config::{Config, Network, Problem, ProtocolKind, Train};
use crate::encode::{Encoder, Input, Transform};
use crate::environment::{Environment, cores};
use crate::error::{Error, Result};
use crate::experiment::{Experiment, settings};
use crate::files::{Lock, write_atomic};
use crate::folder::{RunFolder, keys, write_json};
use crate::progress::Progress;
use crate::results::{Change, Costs, FoldKey, FoldRecord, Frame, NetworkResults, Results, Timing};
use crate::rival::{self, Readings};
use crate::samples::Samples;
use crate::session::Saver;
use crate::tensorboard;
use crate::train::{Latency, Material, Task, Trained};

/// Seconds between two savings of a fold in training, where nothing else is said.
const SAVE_EVERY: f64 = 10.0;

/// How an experiment is run; none of it changes a result.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunOptions {
    /// The run folder. Default `runs/<name>`.
    pub out: Option<PathBuf>,
    /// Whether the folder may hold a run of the same config: its finished folds are kept, and a fold in
    /// training goes on where it was saved.
    pub resume: bool,
    /// Worker threads. Default one per core.
    pub threads: Option<usize>,
    /// Seconds between two savings of a fold in training. Default 10; never more than a twentieth of the
    /// time is spent on it.
    pub save_every: Option<f64>,
}

/// One row of the table: a network or a rival, in a learning curve with one number of samples.
struct Candidate<'a> {
    label: String,
    kind: Kind<'a>,
    /// Training samples per class, and the fold that has so many.
    few: Option<(usize, usize)>,
}

enum Kind<'a> {
    Network(Box<Fitted<'a>>),
    Rival(Method),
}

/// A network of the experiment, fitted to the samples.
struct Fitted<'a> {
    config: &'a Network,
    train: Train,
    entry: &'static Entry,
    settings: Settings,
    graph: Graph,
    /// Shared by the rows of a learning curve.
    checkpoint: Option<Rc<Weights>>,
    anew: Vec<String>,
}

impl Candidate<'_> {
    /// One row per number of samples.
    fn rows<'a>(config: &Config, label: &str, kind: impl Fn() -> Kind<'a>) -> Vec<Candidate<'a>> {
        let counts = config.protocol.per_class.as_deref().unwrap_or_default();
        if config.protocol.kind != ProtocolKind::FewSamples {
            return vec![Candidate { label: label.into(), kind: kind(), few: None }];
        }
        let row = |(fold, &count): (usize, &usize)| Candidate {
            label: format!("{label}.n{count}"),
            kind: kind(),
            few: Some((count, fold)),
        };
        counts.iter().enumerate().map(row).collect()
    }
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
    let wanted: Vec<&str> = entries.iter().flat_map(|e| &e.inputs).map(|input| input.name.as_str()).collect();
    let encoder = Encoder::new(experiment, samples, &wanted)?;
    let mut candidates = vec![];
    for (i, (config_of, entry)) in config.networks.iter().zip(entries).enumerate() {
        let mut settings_of = entry.fit(samples.classes.len(), |input| encoder.shape(input))?;
        settings_of.extend(settings(&config_of.set));
        let graph = entry.graph(&settings_of)?;
        let train = config_of.train(&config.train);
        check_frozen(experiment, i, &graph, &train)?;
        let (start, anew) = checkpoint(experiment, i, &graph, &train)?;
        let start = start.map(Rc::new);
        if !anew.is_empty() {
            let (label, anew) = (config_of.label(), anew.join(", "));
            progress.say(&format!("{label}: made anew, for {} classes: {anew}", samples.classes.len()));
        }
        candidates.extend(Candidate::rows(config, config_of.label(), || {
            Kind::Network(Box::new(Fitted {
                config: config_of,
                train: train.clone(),
                entry,
                settings: settings_of.clone(),
                graph: graph.clone(),
                checkpoint: start.clone(),
                anew: anew.clone(),
            }))
        }));
    }
    let folds: Vec<Vec<Fold>> = (0..config.protocol.repetitions)
        .map(|repetition| samples.folds(experiment, repetition))
        .collect::<Result<_>>()?;
    let readings = Readings::of(&samples.x, config, &samples.source)?;
    let most = folds.iter().flatten().map(|fold| fold.train.len()).max().unwrap_or(0);
    let mut left_out = std::collections::BTreeMap::new();
    for method in config.rivals.iter().flatten().map(|rival| rival.0) {
        match readings.unfit(&method, most) {
            Some(reason) => {
                left_out.insert(method.name().to_string(), reason);
            }
            None => candidates.extend(Candidate::rows(config, method.name(), || Kind::Rival(method))),
        }
    }
    let per_row = match config.protocol.kind {
        ProtocolKind::FewSamples => 1,
        _ => folds.first().map_or(0, Vec::len),
    };
    let frame = frame(experiment, samples)?;
    let out = options.out.clone().unwrap_or_else(|| experiment.default_out());
    let (folder, lock) = RunFolder::prepare(&out, experiment, options.resume)?;
    let threads = options.threads.unwrap_or_else(cores).max(1);
    let mut run = Run {
        experiment,
        samples,
        encoder,
        readings,
        all: keys(candidates.iter().map(|c| c.label.as_str()), folds.len(), per_row),
        results: Results { folds: per_row, left_out, ..empty_results(experiment, samples, &candidates) },
        candidates,
        folds,
        frame,
        folder,
        threads,
        save_every: options.save_every.unwrap_or(SAVE_EVERY),
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

/// Names frozen layers that the network does not have before anything is trained.
fn check_frozen(experiment: &Experiment, network: usize, graph: &Graph, train: &Train) -> Result<()> {
    let names = taxel_zoo::matlab::resolve(graph, &train.frozen);
    names.and_then(|names| graph.covered(&names)).map(|_| ()).map_err(|error| {
        let (key, value) = (format!("networks.{network}.train.frozen"), format!("{:?}", train.frozen));
        let reason = format!("{error}; `taxel cost {}` lists and numbers them", graph.name());
        experiment.refuse(Problem { key, value, reason })
    })
}

/// The checkpoint that a network starts from, and the names of the tensors that it does not give.
fn checkpoint(
    experiment: &Experiment,
    network: usize,
    graph: &Graph,
    train: &Train,
) -> Result<(Option<Weights>, Vec<String>)> {
    let Some(path) = experiment.weights_path(network)? else { return Ok((None, vec![])) };
    let refuse = |reason: String| {
        let (key, value) = (format!("networks.{network}.weights"), format!("{:?}", path.display()));
        experiment.refuse(Problem { key, value, reason })
    };
    let (checkpoint, _) = taxel_devices::checkpoint::read(&path).map_err(|e| refuse(e.to_string()))?;
    let mut fresh = Weights::init(graph, train.init, 0, "checkpoint");
    let anew = fresh.start_from(graph, &checkpoint, false).map_err(|e| refuse(e.to_string()))?;
    Ok((Some(checkpoint), anew))
}

/// How far training moved each convolution from the checkpoint.
fn changes(graph: &Graph, checkpoint: &Weights, trained: &Weights) -> Result<Vec<Change>> {
    let mut start = trained.clone();
    start.start_from(graph, checkpoint, false).map_err(taxel_engine::Error::from)?;
    let changes = start.changes(trained, graph).map_err(taxel_engine::Error::from)?;
    Ok(changes.into_iter().map(|(layer, change)| Change { layer, change }).collect())
}

/// What scores need to know about the samples.
fn frame(experiment: &Experiment, samples: &Samples) -> Result<Frame> {
    let own = || (0..samples.len() as u32).collect();
    let clusters = samples.groups.clone().or_else(|| samples.units.clone()).unwrap_or_else(own);
    let mut look_alikes: Vec<(String, Vec<usize>)> = vec![];
    for (name, classes) in &experiment.config().data.look_alikes {
        // Of the classes that were kept, so that one list serves every subset.
        let own = |class: &String| samples.classes.iter().position(|known| known == class);
        let own: Vec<usize> = classes.iter().filter_map(own).collect();
        if !own.is_empty() {
            look_alikes.push((name.clone(), own));
        }
    }
    let named: Vec<usize> = look_alikes.iter().flat_map(|(_, classes)| classes).copied().collect();
    let torn = (0..samples.classes.len()).find(|c| named.iter().filter(|n| *n == c).count() != 1);
    if let Some(class) = torn.filter(|_| !experiment.config().data.look_alikes.is_empty()) {
        return Err(experiment.refuse(Problem {
            key: "data.look_alikes".into(),
            value: format!("{:?}", samples.classes[class]),
            reason: "must be in exactly one group; every class needs one".into(),
        }));
    }
    let (levels, seed) = (samples.labels.levels(), experiment.config().seed);
    Ok(Frame { levels, clusters, look_alikes, seed })
}

struct Run<'a> {
    experiment: &'a Experiment,
    samples: &'a Samples,
    encoder: Encoder<'a>,
    readings: Readings,
    candidates: Vec<Candidate<'a>>,
    folds: Vec<Vec<Fold>>,
    frame: Frame,
    folder: RunFolder,
    threads: usize,
    save_every: f64,
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
            Saver::remove(&self.folder.session_path(key))?;
            if record.key != *key || Some(&record.index) != self.fold_of(key).map(|fold| &fold.test) {
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

    fn candidate(&self, key: &FoldKey) -> Option<usize> {
        self.candidates.iter().position(|candidate| candidate.label == key.network)
    }

    fn fold_of(&self, key: &FoldKey) -> Option<&Fold> {
        let few = self.candidates[self.candidate(key)?].few;
        self.folds.get(key.repetition)?.get(few.map_or(key.fold, |(_, fold)| fold))
    }

    fn task<'s>(&'s self, network: &'s Fitted, key: &FoldKey) -> Task<'s> {
        let config = self.experiment.config();
        Task {
            label: network.config.label(),
            graph: &network.graph,
            train: &network.train,
            choose: config.choose.as_ref(),
            checkpoint: network.checkpoint.as_deref(),
            seed: config.seed,
            repetition: key.repetition,
            fold: key.fold,
            threads: self.threads,
        }
    }

    fn all_folds(&mut self, progress: &dyn Progress, cancel: &AtomicBool) -> Result<()> {
        let open: Vec<(usize, FoldKey)> = self
            .all
            .iter()
            .filter(|key| !self.records.iter().any(|r| r.key == **key))
            .filter_map(|key| Some((self.candidate(key)?, key.clone())))
            .collect();
        let work = |(candidate, key): &(usize, FoldKey)| {
            let (Kind::Network(network), Some(fold)) = (&self.candidates[*candidate].kind, self.fold_of(key))
            else {
                return 0;
            };
            work_per_sample(&network.graph) * self.task(network, key).samples(fold) as u64
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
        candidate: usize,
        key: FoldKey,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<bool> {
        match &self.candidates[candidate].kind {
            Kind::Network(_) => self.network_fold(candidate, key, progress, cancel),
            &Kind::Rival(method) => {
                if cancel.load(std::sync::atomic::Ordering::Relaxed) {
                    return Ok(false);
                }
                self.rival_fold(&method, key)
            }
        }
    }

    fn network_fold(
        &mut self,
        candidate: usize,
        key: FoldKey,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<bool> {
        let (Kind::Network(network), Some(fold)) = (&self.candidates[candidate].kind, self.fold_of(&key))
        else {
            return Ok(true);
        };
        let inputs: Vec<Input> = self.encoder.fit(&fold.train)?;
        let task = self.task(network, &key);
        let material = Material {
            inputs: &inputs,
            labels: &self.samples.labels,
            strata: &self.samples.y,
            units: self.samples.inseparable(self.experiment)?,
            fold,
        };
        let weight = work_per_sample(&network.graph);
        let mut tick = |samples: usize| progress.step(weight * samples as u64);
        let session = self.folder.session_path(&key);
        let mut saver = Saver::new(session.clone(), self.save_every);
        let Some(trained) = task.run_saved(&material, &mut saver, &mut tick, cancel)? else {
            return Ok(false);
        };
        let own: Vec<&Input> =
            network.graph.inputs().filter_map(|node| inputs.iter().find(|i| i.name == node.name)).collect();
        let metadata = self.metadata(
            &key,
            &network.entry.name,
            network.settings.clone(),
            own.iter().map(|i| (i.name.to_string(), i.transform.clone())).collect(),
        );
        write_checkpoint(&self.folder.model_path(&key), &network.graph, &trained.weights, &metadata)?;
        let first = !self.timings.iter().any(|t| t.key.network == key.network && t.latency.is_some());
        let latency = match fold.test.first() {
            Some(&row) if first => Some(Latency::measure(&network.graph, &trained.weights, &inputs, row)?),
            _ => None,
        };
        let samples = trained.epochs.len() * fold.train.len();
        let timing = Timing {
            encoding_ms_per_sample: own.iter().map(|i| i.ms_per_sample).sum(),
            ..self.timing(&key, trained.train_seconds, trained.test_seconds, samples, latency)
        };
        let changes = match network.checkpoint.as_deref() {
            Some(checkpoint) => changes(&network.graph, checkpoint, &trained.weights)?,
            None => vec![],
        };
        let Trained { epochs, chosen, best_epoch, probabilities, test_loss, other_statistics, .. } = trained;
        let record = FoldRecord {
            chosen,
            best_epoch,
            epochs,
            changes,
            other_statistics,
            ..self.record(key, fold, probabilities, test_loss)
        };
        self.keep(timing, record)?;
        Saver::remove(&session)?;
        Ok(true)
    }

    fn rival_fold(&mut self, method: &Method, key: FoldKey) -> Result<bool> {
        let Some(fold) = self.fold_of(&key) else { return Ok(true) };
        let seed = self.experiment.config().seed;
        let purpose = format!("r{}/f{}", key.repetition, key.fold);
        let first = !self.timings.iter().any(|t| t.key.network == key.network && t.latency.is_some());
        let pool = rival::pool(self.threads)?;
        let labels = &self.samples.labels;
        let outcome =
            pool.install(|| rival::run(method, &self.readings, labels, fold, (seed, &purpose), first))?;
        let settings = match serde_json::to_value(method) {
            Ok(serde_json::Value::Object(mut settings)) => {
                settings.remove("name");
                settings
            }
            _ => Settings::new(),
        };
        let inputs: Vec<(String, Transform)> = vec![("series".into(), outcome.transform)];
        let series = Some(self.readings.shape());
        let metadata = Metadata { series, ..self.metadata(&key, method.name(), settings, inputs) };
        write_tensors(&self.folder.model_path(&key), &outcome.weights, &metadata)?;
        let (seconds, samples) = ((outcome.train_seconds, outcome.test_seconds), fold.train.len());
        let timing = self.timing(&key, seconds.0, seconds.1, samples, outcome.latency);
        let record = FoldRecord {
            costs: Some(outcome.costs),
            ..self.record(key, fold, outcome.probabilities, outcome.test_loss)
        };
        self.keep(timing, record)?;
        Ok(true)
    }

    fn metadata(
        &self,
        key: &FoldKey,
        network: &str,
        settings: Settings,
        inputs: Vec<(String, Transform)>,
    ) -> Metadata {
        Metadata {
            network: network.into(),
            settings,
            classes: self.samples.classes.clone(),
            inputs,
            series: None,
            source: self.samples.source.clone(),
            seed: self.experiment.config().seed,
            repetition: key.repetition,
            fold: key.fold,
        }
    }

    fn timing(
        &self,
        key: &FoldKey,
        train_seconds: f64,
        test_seconds: f64,
        samples: usize,
        latency: Option<Latency>,
    ) -> Timing {
        Timing {
            key: key.clone(),
            train_seconds,
            samples: samples as u64,
            samples_per_second: samples as f64 / train_seconds.max(1e-9),
            test_seconds,
            threads: self.threads,
            encoding_ms_per_sample: 0.0,
            latency,
        }
    }

    fn record(&self, key: FoldKey, fold: &Fold, probabilities: Vec<f32>, test_loss: f64) -> FoldRecord {
        FoldRecord {
            key,
            train_samples: fold.train.len(),
            index: fold.test.clone(),
            truth: self.samples.labels.of(&fold.test),
            predicted: self.frame.levels.predicted(&probabilities),
            probabilities,
            test_loss,
            chosen: None,
            best_epoch: None,
            costs: None,
            changes: vec![],
            other_statistics: None,
            epochs: vec![],
        }
    }

    fn keep(&mut self, timing: Timing, record: FoldRecord) -> Result<()> {
        let path = self.folder.timing_path(&timing.key);
        self.timings.push(write_json(&path, &timing, true)?);
        if !record.epochs.is_empty() {
            let folder = self.folder.events_path(&record.key);
            std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, "created", e))?;
            write_atomic(&folder.join("events.out.tfevents.0"), &tensorboard::events(&record))?;
        }
        // Last: a fold with a record is a finished fold.
        let path = self.folder.record_path(&record.key);
        self.records.push(write_json(&path, &record, false)?);
        Ok(())
    }

    fn assemble(&mut self) -> Result<()> {
        let place = |key: &FoldKey| self.all.iter().position(|k| k == key);
        self.records.sort_by_key(|r| place(&r.key));
        self.timings.sort_by_key(|t| place(&t.key));
        assemble(&self.folder, &mut self.results, &self.all, &self.records, &self.timings, &self.frame)
    }
}

/// Multiply-accumulates, and something for what a small network spends besides them.
fn work_per_sample(graph: &Graph) -> u64 {
    graph.cost().macs + 200_000
}

fn empty_results(experiment: &Experiment, samples: &Samples, candidates: &[Candidate<'_>]) -> Results {
    let config = experiment.config();
    let network = |c: &Candidate<'_>| {
        let (zoo, paper, settings, costs, published, made_anew) = match &c.kind {
            Kind::Network(network) => {
                let Fitted { config, entry, settings, graph, anew, .. } = &**network;
                let costs = graph.cost().into();
                let (name, paper) = (entry.name.as_str(), entry.paper.as_str());
                (name, paper, settings.clone(), costs, config.published.clone(), anew.clone())
            }
            Kind::Rival(method) => {
                let none = Costs { parameters: 0, bytes: 0, macs: 0, flops: 0 };
                (method.name(), method.reference(), Settings::new(), none, None, vec![])
            }
        };
        NetworkResults {
            network: c.label.clone(),
            zoo: zoo.into(),
            per_class: c.few.map(|(count, _)| count),
            paper: paper.into(),
            settings,
            made_anew,
            changes: vec![],
            other_statistics: None,
            costs,
            folds: vec![],
            mean: None,
            sd: None,
            interval: None,
            confusion: None,
            look_alikes: None,
            attributes: vec![],
            published,
        }
    };
    let attributes = samples.labels.attributes();
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
        attributes: if attributes.len() > 1 { attributes.to_vec() } else { vec![] },
        protocol: config.protocol.clone(),
        folds: 0,
        left_out: Default::default(),
        shortcut: samples.shortcut(),
        seed: config.seed,
        unit: "percent".into(),
        networks: candidates.iter().map(network).collect(),
    }
}
