//! Trainings, one after the other; each is kept as a record, and none is made twice.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use serde::Serialize;
use serde::de::DeserializeOwned;
use taxel_data::{Dataset, Fold};
use taxel_learn::{
    Candidate, Encoder, FoldKey, FoldRecord, OneFold, Progress, Teacher, Tested, read_kept, write_kept,
};
use taxel_trainer::{Experiment, Variant, prepared};
use taxel_zoo::Registry;

use crate::error::{Error, Result};

/// Makes trainings and keeps their records.
pub struct Cache<'a> {
    /// The run's experiment.
    pub experiment: &'a Experiment,
    /// Where its networks come from.
    pub registry: &'a Registry,
    /// Its samples.
    pub dataset: &'a Dataset,
    /// Folder of the records.
    pub records: PathBuf,
    /// Worker threads.
    pub threads: usize,
    /// Hears how far it is.
    pub progress: &'a dyn Progress,
    /// Set from outside to end it between two steps.
    pub cancel: &'a AtomicBool,
    ready: Option<Ready<'a>>,
    /// Digests of the requested trainings: each counts once, however often it is requested.
    done: BTreeSet<String>,
    total: usize,
}

/// The training at hand.
struct Ready<'a> {
    name: String,
    changes: Variant,
    experiment: Experiment,
    /// Its config as text.
    text: String,
    built: Option<(Candidate, Encoder<'a>)>,
}

/// A requested training.
#[derive(Clone, Copy)]
pub struct Request<'q> {
    /// The network or baseline.
    pub name: &'q str,
    /// Name in the progress while it runs.
    pub label: &'q str,
    /// The reductions.
    pub changes: &'q Variant,
    /// Repetition and fold, which seed it.
    pub place: (usize, usize),
    /// The samples.
    pub fold: &'q Fold,
    /// Teacher that it learns from.
    pub teacher: Option<&'q Teacher>,
}

impl<'a> Cache<'a> {
    /// Returns a cache that expects no trainings yet.
    pub fn new(
        (experiment, registry, dataset): (&'a Experiment, &'a Registry, &'a Dataset),
        records: PathBuf,
        threads: usize,
        progress: &'a dyn Progress,
        cancel: &'a AtomicBool,
    ) -> Self {
        let (ready, done, total) = (None, BTreeSet::new(), 0);
        Cache { experiment, registry, dataset, records, threads, progress, cancel, ready, done, total }
    }

    /// Adds to the number of trainings that are to come at most.
    pub fn expect(&mut self, trainings: usize) {
        self.total += trainings;
    }

    /// Returns the predictions of a training for its test samples. Reads them where they were kept, trains otherwise.
    ///
    /// # Errors
    /// Settings that network or training refuse, [`Error::Stopped`].
    pub fn predictions(&mut self, request: Request) -> Result<FoldRecord> {
        let of = self.digest(&request)?;
        if let Some(record) = self.kept::<FoldRecord>(&of)? {
            if self.done.insert(of) {
                let seen = record.epochs.len().max(1) * request.fold.train.len();
                self.progress.step(seen as u64);
            }
            return Ok(record);
        }
        Ok(self.train_as(request, &of)?.record)
    }

    /// Trains now, and returns the result with its model.
    ///
    /// # Errors
    /// As [`Cache::predictions`].
    pub fn train(&mut self, request: Request) -> Result<Tested> {
        let of = self.digest(&request)?;
        self.train_as(request, &of)
    }

    fn train_as(&mut self, request: Request, of: &str) -> Result<Tested> {
        let Request { label, place: (repetition, number), fold, teacher, .. } = request;
        let key = FoldKey { network: label.into(), repetition, fold: number };
        self.done.insert(of.into());
        self.progress.fold(&key, self.done.len(), self.total);
        let (threads, progress, cancel) = (self.threads, self.progress, self.cancel);
        let (registry, dataset) = (self.registry, self.dataset);
        let folder = self.records.display().to_string();
        let ready = self.ready(&request)?;
        let built = match ready.built.take() {
            Some(built) => built,
            None => prepared(&ready.experiment, registry, dataset, &ready.name)?,
        };
        let (candidate, encoder) = &*ready.built.insert(built);
        let config = ready.experiment.config();
        let one =
            OneFold { candidate, protocol: &config.protocol, seed: config.seed, key, fold, teacher, threads };
        let tested = one.run(encoder, &mut |samples| progress.step(samples as u64), cancel)?;
        let tested = tested.ok_or(Error::Stopped { folder })?;
        self.keep(of, &tested.record)?;
        Ok(tested)
    }

    /// Returns the experiment of a request.
    pub fn experiment_of(&mut self, request: &Request) -> Result<&Experiment> {
        Ok(&self.ready(request)?.experiment)
    }

    fn ready(&mut self, request: &Request) -> Result<&mut Ready<'a>> {
        let same = |ready: &Ready| ready.name == request.name && ready.changes == *request.changes;
        let ready = match self.ready.take().filter(same) {
            Some(ready) => ready,
            None => {
                let experiment = self.experiment.variant(request.name, request.changes, self.registry)?;
                let (name, changes) = (request.name.to_string(), request.changes.clone());
                Ready { name, changes, text: experiment.to_toml(), experiment, built: None }
            }
        };
        Ok(self.ready.insert(ready))
    }

    /// Returns the digest of all that a training depends on.
    fn digest(&mut self, request: &Request) -> Result<String> {
        let data = self.dataset.digest.clone();
        let text = &self.ready(request)?.text;
        let Fold { train, test, validation } = request.fold;
        let parts = serde_json::json!({
            "config": text, "name": request.name, "data": data, "facts": self.dataset.facts(),
            "place": request.place, "rows": [train, test, validation], "teacher": request.teacher.map(Teacher::digest),
            "taxel": env!("CARGO_PKG_VERSION"),
        });
        Ok(blake3::hash(parts.to_string().as_bytes()).to_hex().to_string())
    }

    /// Reads the value kept under a digest.
    ///
    /// # Errors
    /// A damaged file.
    pub fn kept<T: DeserializeOwned>(&self, of: &str) -> Result<Option<T>> {
        Ok(read_kept(&self.records, of)?)
    }

    /// Keeps something under a digest.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep<T: Serialize>(&self, of: &str, value: &T) -> Result<()> {
        Ok(write_kept(&self.records, of, value)?)
    }

    /// Returns a digest for values computed from trainings, such as a ranking.
    pub fn following(&mut self, request: &Request, what: &str) -> Result<String> {
        let text = format!("{what} {}", self.digest(request)?);
        Ok(blake3::hash(text.as_bytes()).to_hex().to_string())
    }
}
