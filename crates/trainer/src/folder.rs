//! The run folder: which file is where, and how it is written and read.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::experiment::{Experiment, Overrides};
use crate::files::{Lock, is_empty, sweep, write_atomic};
use crate::results::{FoldKey, FoldRecord, Results, Timing};

/// A folder with the files of one run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// The run folder at `path`.
    ///
    /// # Errors
    /// A folder that is not there or holds no run.
    pub fn open(path: &Path) -> Result<Self> {
        let folder = RunFolder { path: path.into() };
        match folder.config_path().is_file() {
            true => Ok(folder),
            false => Err(Error::folder(path, "is no run folder (no config.toml); make one with taxel run")),
        }
    }

    /// Makes or reopens the folder for writing; nobody else may while the lock lives.
    pub(crate) fn prepare(path: &Path, experiment: &Experiment, resume: bool) -> Result<(Self, Lock)> {
        let folder = RunFolder { path: path.into() };
        if path.exists() && !is_empty(path)? {
            if !resume {
                let reason = "exists and is not empty; go on with it by --resume or give another --out";
                return Err(Error::folder(path, reason));
            }
            if !folder.config_path().is_file() {
                return Err(Error::folder(path, "holds no config.toml to resume; give another --out"));
            }
        }
        for part in ["folds", "models"] {
            let part = path.join(part);
            fs::create_dir_all(&part).map_err(|e| Error::io(&part, "created", e))?;
        }
        let lock = Lock::take(path)?;
        for part in [path.to_path_buf(), path.join("folds"), path.join("models")] {
            sweep(&part)?;
        }
        let config = experiment.to_toml()?;
        if folder.config_path().is_file() {
            folder.same_config(&config)?;
        } else {
            write_atomic(&folder.config_path(), config.as_bytes())?;
        }
        Ok((folder, lock))
    }

    fn same_config(&self, resolved: &str) -> Result<()> {
        let path = self.config_path();
        let text = fs::read_to_string(&path).map_err(|e| Error::io(&path, "read", e))?;
        let parse = |text: &str| -> Result<Table> {
            toml::from_str(text).map_err(|e| Error::damaged(&path, format!("is no TOML: {}", e.message())))
        };
        let (before, now) = (parse(&text)?, parse(resolved)?);
        match difference("", &Value::Table(before), &Value::Table(now)) {
            None => Ok(()),
            Some((key, before, now)) => Err(Error::folder(
                &self.path,
                format!(
                    "was run with another config: {key} was {before}, is now {now}; resume with the same \
                     config or give another --out"
                ),
            )),
        }
    }

    /// The folder itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn config_path(&self) -> PathBuf {
        self.path.join("config.toml")
    }

    /// A file of the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Where the network of a fold is.
    pub fn model_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("models").join(format!("{key}.safetensors"))
    }

    pub(crate) fn record_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("folds").join(format!("{key}.json"))
    }

    /// Where a fold in training is saved.
    pub(crate) fn session_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("folds").join(format!("{key}.session.safetensors"))
    }

    /// The folder of a fold's TensorBoard events.
    pub(crate) fn events_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("tensorboard").join(key.to_string())
    }

    pub(crate) fn timing_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("folds").join(format!("{key}.timing.json"))
    }

    /// The experiment that was run.
    ///
    /// # Errors
    /// A `config.toml` that was changed by hand and is no experiment any more.
    pub fn experiment(&self) -> Result<Experiment> {
        Experiment::load(&self.config_path(), &Overrides::default())
    }

    /// The scores.
    ///
    /// # Errors
    /// A missing or damaged `results.json`.
    pub fn results(&self) -> Result<Results> {
        let path = self.file("results.json");
        read_json(&path)?
            .ok_or_else(|| Error::damaged(&path, "is not there; run the experiment again with --resume"))
    }

    /// Machine, code and data of the run.
    ///
    /// # Errors
    /// A missing or damaged `environment.json`.
    pub fn environment(&self) -> Result<Environment> {
        let path = self.file("environment.json");
        read_json(&path)?.ok_or_else(|| Error::damaged(&path, "is not there; run the experiment again"))
    }

    /// A JSON file that was put beside the run's own; `None` where there is none.
    ///
    /// # Errors
    /// A damaged file.
    pub fn read<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>> {
        read_json(&self.file(name))
    }

    /// Writes a JSON file beside the run's own, whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write<T: Serialize + DeserializeOwned>(&self, name: &str, value: &T) -> Result<()> {
        write_json(&self.file(name), value, true).map(|_| ())
    }

    /// Predictions of a finished fold; `None` where it is not finished.
    ///
    /// # Errors
    /// A damaged file.
    pub fn record(&self, key: &FoldKey) -> Result<Option<FoldRecord>> {
        read_json(&self.record_path(key))
    }

    /// How long a finished fold took; `None` where it is not finished.
    ///
    /// # Errors
    /// A damaged file.
    pub fn timing(&self, key: &FoldKey) -> Result<Option<Timing>> {
        read_json(&self.timing_path(key))
    }

    /// Every fold of every network, in the order in which they are run.
    ///
    /// # Errors
    /// A damaged `results.json`.
    pub fn keys(&self) -> Result<Vec<FoldKey>> {
        let results = self.results()?;
        let labels = results.networks.iter().map(|n| n.network.as_str());
        Ok(keys(labels, results.protocol.repetitions, results.folds))
    }

    /// Timings of all finished folds.
    ///
    /// # Errors
    /// A damaged file.
    pub fn timings(&self) -> Result<Vec<Timing>> {
        self.keys()?.iter().filter_map(|key| self.timing(key).transpose()).collect()
    }
}

/// Every fold of every network, in the order in which they are run.
pub(crate) fn keys<'a>(
    labels: impl Iterator<Item = &'a str>,
    repetitions: usize,
    folds: usize,
) -> Vec<FoldKey> {
    let mut keys = vec![];
    for network in labels {
        for repetition in 0..repetitions {
            keys.extend((0..folds).map(|fold| FoldKey { network: network.into(), repetition, fold }));
        }
    }
    keys
}

/// Writes `value` as indented JSON and hands back what a later reader will see.
pub(crate) fn write_json<T: Serialize + DeserializeOwned>(path: &Path, value: &T, pretty: bool) -> Result<T> {
    let damaged = |e: serde_json::Error| Error::damaged(path, format!("cannot be encoded: {e}"));
    let mut text = match pretty {
        true => serde_json::to_string_pretty(value),
        false => serde_json::to_string(value),
    }
    .map_err(damaged)?;
    text.push('\n');
    write_atomic(path, text.as_bytes())?;
    // JSON may round the last digit of a number: with this, fresh and resumed runs agree to the byte.
    serde_json::from_str(&text).map_err(damaged)
}

/// `None` where there is no such file.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(Error::io(path, "read", e)),
    };
    serde_json::from_str(&text).map(Some).map_err(|e| {
        Error::damaged(path, format!("cannot be read: {e}; delete it and run again with --resume"))
    })
}

/// First dotted key, in order of the alphabet, whose values differ.
fn difference(prefix: &str, before: &Value, now: &Value) -> Option<(String, String, String)> {
    let shown = |value: Option<&Value>| value.map_or("not set".into(), ToString::to_string);
    let join = |key: &str| if prefix.is_empty() { key.into() } else { format!("{prefix}.{key}") };
    match (before, now) {
        (Value::Table(a), Value::Table(b)) => {
            let names: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            names.into_iter().find_map(|key| match (a.get(key), b.get(key)) {
                (Some(a), Some(b)) => difference(&join(key), a, b),
                (a, b) => Some((join(key), shown(a), shown(b))),
            })
        }
        (Value::Array(a), Value::Array(b)) if a.iter().chain(b).any(Value::is_table) => {
            (0..a.len().max(b.len())).find_map(|i| match (a.get(i), b.get(i)) {
                (Some(a), Some(b)) => difference(&join(&i.to_string()), a, b),
                (a, b) => Some((join(&i.to_string()), shown(a), shown(b))),
            })
        }
        (a, b) if a == b => None,
        (a, b) => Some((prefix.into(), shown(Some(a)), shown(Some(b)))),
    }
}
