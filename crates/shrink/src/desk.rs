//! Trainings, one after the other; each is kept as a record, and none is made twice.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use taxel_data::{Dataset, Fold};
use taxel_learn::{Candidate, Encoder, FoldKey, FoldRecord, OneFold, Progress, Teacher, Tested};
use taxel_trainer::{Experiment, Variant, prepared};
use taxel_zoo::Registry;

use crate::error::{Error, Result};

/// Makes trainings and keeps their records.
pub struct Desk<'a> {
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
    /// Digests of the trainings that were asked for: one that is asked for again counts once.
    done: BTreeSet<String>,
    total: usize,
}

/// What is trained now.
struct Ready<'a> {
    name: String,
    changes: Variant,
    experiment: Experiment,
    /// Its config as text.
    text: String,
    built: Option<(Candidate, Encoder<'a>)>,
}

/// A training that is asked for.
#[derive(Clone, Copy)]
pub struct Ask<'q> {
    /// The network or baseline.
    pub name: &'q str,
    /// What is said of it while it runs.
    pub label: &'q str,
    /// What becomes less.
    pub changes: &'q Variant,
    /// Repetition and fold, which seed it.
    pub place: (usize, usize),
    /// The samples.
    pub fold: &'q Fold,
    /// Whose answers it learns from.
    pub teacher: Option<&'q Teacher>,
}

/// A record with the digest of all that it depends on.
#[derive(Serialize, Deserialize)]
struct Kept<T> {
    of: String,
    value: T,
}

impl<'a> Desk<'a> {
    /// A desk that expects no trainings yet.
    pub fn new(
        (experiment, registry, dataset): (&'a Experiment, &'a Registry, &'a Dataset),
        records: PathBuf,
        threads: usize,
        progress: &'a dyn Progress,
        cancel: &'a AtomicBool,
    ) -> Self {
        let (ready, done, total) = (None, BTreeSet::new(), 0);
        Desk { experiment, registry, dataset, records, threads, progress, cancel, ready, done, total }
    }

    /// So many more trainings are to come at most.
    pub fn expect(&mut self, trainings: usize) {
        self.total += trainings;
    }

    /// Answers of a training to its test samples: kept ones, or it is made now.
    ///
    /// # Errors
    /// What the network or the training refuses, [`Error::Stopped`].
    pub fn answers(&mut self, ask: Ask) -> Result<FoldRecord> {
        let of = self.digest(&ask)?;
        if let Some(record) = self.kept::<FoldRecord>(&of)? {
            if self.done.insert(of) {
                let seen = record.epochs.len().max(1) * ask.fold.train.len();
                self.progress.step(seen as u64);
            }
            return Ok(record);
        }
        Ok(self.train_as(ask, &of)?.record)
    }

    /// A training made now, with its model.
    ///
    /// # Errors
    /// As [`Desk::answers`].
    pub fn train(&mut self, ask: Ask) -> Result<Tested> {
        let of = self.digest(&ask)?;
        self.train_as(ask, &of)
    }

    fn train_as(&mut self, ask: Ask, of: &str) -> Result<Tested> {
        let Ask { label, place: (repetition, number), fold, teacher, .. } = ask;
        let key = FoldKey { network: label.into(), repetition, fold: number };
        self.done.insert(of.into());
        self.progress.fold(&key, self.done.len(), self.total);
        let (threads, progress, cancel) = (self.threads, self.progress, self.cancel);
        let (registry, dataset) = (self.registry, self.dataset);
        let folder = self.records.display().to_string();
        let ready = self.ready(&ask)?;
        let built = match ready.built.take() {
            Some(own) => own,
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

    /// The experiment that is asked for.
    pub fn alone(&mut self, ask: &Ask) -> Result<&Experiment> {
        Ok(&self.ready(ask)?.experiment)
    }

    fn ready(&mut self, ask: &Ask) -> Result<&mut Ready<'a>> {
        let same = |own: &Ready| own.name == ask.name && own.changes == *ask.changes;
        let own = match self.ready.take().filter(same) {
            Some(own) => own,
            None => {
                let experiment = self.experiment.variant(ask.name, ask.changes, self.registry)?;
                let (name, changes) = (ask.name.to_string(), ask.changes.clone());
                Ready { name, changes, text: experiment.to_toml(), experiment, built: None }
            }
        };
        Ok(self.ready.insert(own))
    }

    /// Digest of all that a training depends on.
    fn digest(&mut self, ask: &Ask) -> Result<String> {
        let data = self.dataset.digest.clone();
        let text = &self.ready(ask)?.text;
        let Fold { train, test, validation } = ask.fold;
        let own = serde_json::json!({
            "config": text, "name": ask.name, "data": data, "place": ask.place,
            "rows": [train, test, validation], "teacher": ask.teacher.map(Teacher::digest),
            "taxel": env!("CARGO_PKG_VERSION"),
        });
        Ok(blake3::hash(own.to_string().as_bytes()).to_hex().to_string())
    }

    /// What was kept under a digest.
    ///
    /// # Errors
    /// A damaged file.
    pub fn kept<T: DeserializeOwned>(&self, of: &str) -> Result<Option<T>> {
        let path = self.path(of);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(Error::file(&path, error)),
        };
        let read = |error| Error::file(&path, format!("{error}; delete it and go on with --resume"));
        let kept: Kept<T> = serde_json::from_str(&text).map_err(read)?;
        Ok((kept.of == of).then_some(kept.value))
    }

    /// Keeps something under a digest.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep<T: Serialize>(&self, of: &str, value: &T) -> Result<()> {
        let path = self.path(of);
        let kept = Kept { of: of.into(), value };
        let text = serde_json::to_string(&kept).map_err(|error| Error::file(&path, error))?;
        taxel_base::files::write_whole(&path, text.as_bytes()).map_err(|error| Error::file(&path, error))
    }

    fn path(&self, of: &str) -> PathBuf {
        self.records.join(format!("{}.json", of.get(..24).unwrap_or(of)))
    }

    /// Digest for what follows from trainings, such as a ranking.
    pub fn following(&mut self, ask: &Ask, what: &str) -> Result<String> {
        let own = format!("{what} {}", self.digest(ask)?);
        Ok(blake3::hash(own.as_bytes()).to_hex().to_string())
    }
}
