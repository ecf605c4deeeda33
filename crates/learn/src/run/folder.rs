//! The run folder: which file is where, and how it is written and read.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};
use crate::json_file::{read_json, write_atomic, write_json};
use crate::run::environment::Environment;
use crate::run::lock::{Lock, is_empty, sweep};
use crate::run::records::{FoldKey, FoldRecord, Timing};
use crate::run::results::Results;

/// The identity of a run: a text that is kept in the run folder, equal for equal runs.
pub struct Identity<'a> {
    /// Name of its file: `config.toml`.
    pub file: &'a str,
    /// The text itself.
    pub text: String,
    /// In what the text of an earlier run differs from this one, if it does.
    pub difference: &'a dyn Fn(&Path, &str) -> Result<Option<String>>,
}

/// On what machine, with which code and on which data a run was made.
pub(crate) const ENVIRONMENT: &str = "environment.json";

/// Files that hold the identity of a run: an experiment's, or a library's.
pub(crate) const IDENTITIES: [&str; 2] = ["config.toml", "run.json"];

/// A folder with the files of one run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// Opens the run folder at `path`.
    ///
    /// # Errors
    /// A folder that is not there or holds no run.
    pub fn open(path: &Path) -> Result<Self> {
        if IDENTITIES.iter().any(|name| path.join(name).is_file()) {
            Ok(RunFolder { path: path.into() })
        } else {
            Err(Error::folder(path, "is no run folder (no config.toml); make one with taxel run"))
        }
    }

    /// Makes or reopens the folder for writing; nobody else may while the lock lives.
    ///
    /// # Errors
    /// A folder that holds something else or another run, or that another process writes to.
    pub(crate) fn prepare(path: &Path, identity: &Identity, resume: bool) -> Result<(Self, Lock)> {
        let folder = RunFolder { path: path.into() };
        let file = path.join(identity.file);
        if path.exists() && !is_empty(path)? {
            if !resume {
                let reason = "exists and is not empty; resume its run or give another folder";
                return Err(Error::folder(path, reason));
            }
            if !file.is_file() {
                let reason = format!("holds no {} to resume; give another folder", identity.file);
                return Err(Error::folder(path, reason));
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
        if !file.is_file() {
            write_atomic(&file, identity.text.as_bytes())?;
            return Ok((folder, lock));
        }
        let before = fs::read_to_string(&file).map_err(|e| Error::io(&file, "read", e))?;
        match (identity.difference)(&file, &before)? {
            None => Ok((folder, lock)),
            Some(difference) => {
                let reason = format!(
                    "was run with other settings: {difference}; resume with the same ones or give another \
                     folder"
                );
                Err(Error::folder(path, reason))
            }
        }
    }

    /// Returns the path of the folder itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path of a file of the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Returns the path of the model that a fold writes.
    pub fn model_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("models").join(format!("{key}.safetensors"))
    }

    pub(crate) fn record_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("folds").join(format!("{key}.json"))
    }

    /// Returns the path under which a fold in training is saved.
    pub(crate) fn session_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("folds").join(format!("{key}.session.safetensors"))
    }

    /// Returns the folder of a fold's TensorBoard events.
    pub(crate) fn events_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("tensorboard").join(key.to_string())
    }

    pub(crate) fn timing_path(&self, key: &FoldKey) -> PathBuf {
        self.path.join("folds").join(format!("{key}.timing.json"))
    }

    /// Reads the scores.
    ///
    /// # Errors
    /// A missing or damaged `results.json`.
    pub fn results(&self) -> Result<Results> {
        let path = self.file("results.json");
        read_json(&path)?.ok_or_else(|| Error::damaged(&path, "is not there; resume the run"))
    }

    /// Reads the machine, code and data of the run.
    ///
    /// # Errors
    /// A missing or damaged `environment.json`.
    pub fn environment(&self) -> Result<Environment> {
        let path = self.file(ENVIRONMENT);
        read_json(&path)?.ok_or_else(|| Error::damaged(&path, "is not there; run the experiment again"))
    }

    /// Reads a JSON file that was put beside the run's own; `None` where there is none.
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

    /// Reads how long a finished fold took; `None` where it is not finished.
    ///
    /// # Errors
    /// A damaged file.
    pub fn timing(&self, key: &FoldKey) -> Result<Option<Timing>> {
        read_json(&self.timing_path(key))
    }

    /// Returns every fold of every network, in the order in which they are run.
    ///
    /// # Errors
    /// A damaged `results.json`.
    pub fn keys(&self) -> Result<Vec<FoldKey>> {
        self.keys_of(&self.results()?)
    }

    /// Does what [`RunFolder::keys`] does, for results that are read already.
    pub(crate) fn keys_of(&self, results: &Results) -> Result<Vec<FoldKey>> {
        let (repetitions, folds) = (results.protocol.repetitions(), results.folds);
        let known = results.networks.iter().map(|n| n.folds.len()).sum::<usize>() + results.missing.len();
        let all = repetitions.checked_mul(folds).and_then(|each| each.checked_mul(results.networks.len()));
        // Before memory is allocated.
        if all != Some(known) {
            let reason = format!(
                "names {known} folds, {} networks in {repetitions} repetitions of {folds} folds have others; \
                 resume the run, which writes it anew",
                results.networks.len()
            );
            return Err(Error::damaged(&self.file("results.json"), reason));
        }
        let labels = results.networks.iter().map(|n| n.network.as_str());
        Ok(FoldKey::all(labels, repetitions, folds))
    }

    /// Keeps other processes from writing to the folder while it lives; half-written files of killed ones are
    /// swept away.
    ///
    /// # Errors
    /// Another process that writes to it.
    pub fn lock(&self) -> Result<Lock> {
        let lock = Lock::take(&self.path)?;
        sweep(&self.path)?;
        Ok(lock)
    }

    /// Timings of all finished folds.
    ///
    /// # Errors
    /// A damaged file.
    pub fn timings(&self) -> Result<Vec<Timing>> {
        self.keys()?.iter().filter_map(|key| self.timing(key).transpose()).collect()
    }
}
