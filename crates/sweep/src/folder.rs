//! The folder of a sweep: which file is where.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Characters of an identity that name a trial's files.
const SHORT: usize = 16;

/// The folder of a planned sweep.
///
/// | path | holds |
/// |---|---|
/// | `manifest.jsonl` | the plan, one trial a line |
/// | `runs/<name>-<id>/` | run folders: of trials that are a whole config, and those put together from folds |
/// | `pieces/<name>-<id>/` | run folders of one fold each |
/// | `results/<id>.json` | the scores of a finished trial; `<id>.timing.json`: how long it took, and where |
/// | `failed/<id>.json` | why a trial could not be run |
/// | `claims/`, `work/` | who works on what, and as far as they are |
/// | `collected/` | the page and the tables |
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SweepFolder {
    path: PathBuf,
}

impl SweepFolder {
    /// Opens the sweep at `path`.
    ///
    /// # Errors
    /// A folder without a manifest.
    pub fn open(path: &Path) -> Result<Self> {
        let folder = SweepFolder::at(path);
        if folder.manifest().is_file() {
            Ok(folder)
        } else {
            Err(Error::file(path, "holds no manifest.jsonl; make one with taxel sweep plan"))
        }
    }

    /// Returns the folder of a sweep that may not be planned yet.
    pub fn at(path: &Path) -> Self {
        SweepFolder { path: path.into() }
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path of the plan.
    pub fn manifest(&self) -> PathBuf {
        self.path.join("manifest.jsonl")
    }

    /// Returns the run folder of the run `identity`.
    pub fn run(&self, name: &str, identity: &str) -> PathBuf {
        self.path.join("runs").join(format!("{name}-{}", short(identity)))
    }

    /// Returns the run folder of one fold.
    pub(crate) fn piece(&self, name: &str, identity: &str) -> PathBuf {
        self.path.join("pieces").join(format!("{name}-{}", short(identity)))
    }

    /// Returns the path of the scores of a finished trial or run.
    pub(crate) fn result(&self, identity: &str) -> PathBuf {
        self.path.join("results").join(format!("{}.json", short(identity)))
    }

    /// Returns the path of its time.
    pub(crate) fn timing(&self, identity: &str) -> PathBuf {
        self.path.join("results").join(format!("{}.timing.json", short(identity)))
    }

    /// Returns the path of the reason why it could not be run.
    pub(crate) fn failure(&self, identity: &str) -> PathBuf {
        self.path.join("failed").join(format!("{}.json", short(identity)))
    }

    /// Returns the path of a lease: one file for each time that somebody took the trial up, counted from 1.
    pub(crate) fn lease(&self, identity: &str, generation: u32) -> PathBuf {
        self.leases().join(format!("{}.{generation}", short(identity)))
    }

    /// Returns the folder of all leases.
    pub(crate) fn leases(&self) -> PathBuf {
        self.path.join("claims")
    }

    /// Returns the path of a working folder.
    pub(crate) fn work(&self, identity: &str, generation: u32) -> PathBuf {
        self.path.join("work").join(format!("{}.{generation}", short(identity)))
    }

    /// Returns the path of the page and the tables of all that is finished.
    pub fn collected(&self) -> PathBuf {
        self.path.join("collected")
    }

    /// Makes the folders that trials are worked on in.
    pub(crate) fn make(&self) -> Result<()> {
        for part in ["runs", "pieces", "results", "failed", "claims", "work"] {
            let part = self.path.join(part);
            std::fs::create_dir_all(&part).map_err(|e| Error::io(&part, "created", e))?;
        }
        Ok(())
    }
}

fn short(identity: &str) -> &str {
    identity.get(..SHORT).unwrap_or(identity)
}
