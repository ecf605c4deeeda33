//! Records of finished trials besides their run folders: enough for tables, small enough for thousands.

use serde::{Deserialize, Serialize};
use taxel_judge::Primary;
use taxel_learn::Results;
use taxel_learn::metrics::{Scores, metrics};

use crate::error::{Error, Result};
use crate::folder::SweepFolder;
use crate::json;
use crate::trial::DataOf;

/// The scores of a trial or of a run put together from folds: a function of its identity alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialResult {
    /// Identity of the trial or run.
    pub identity: String,
    /// Name of the experiment.
    pub name: String,
    /// The samples.
    pub data: DataOf,
    /// Seed of the experiment.
    pub seed: u64,
    /// The metric that networks are compared by.
    #[serde(default, skip_serializing_if = "Primary::is_accuracy")]
    pub primary: Primary,
    /// One per network and baseline, in the order of the config; of a fold its own alone.
    pub networks: Vec<NetworkScore>,
}

/// Scores of one network, mean over its folds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NetworkScore {
    /// Name of the row.
    pub network: String,
    /// Name in the registry, or of the baseline.
    pub zoo: String,
    /// Number of folds.
    pub folds: usize,
    /// The metrics of the task by name, in their units, the primary one first; behind it, as `accuracy_sd`, its sample
    /// standard deviation over folds (n - 1), which one fold does not have.
    #[serde(flatten)]
    pub scores: Scores,
}

/// Returns the name of the primary metric's standard deviation.
pub(crate) fn sd_of(primary: &Primary) -> String {
    format!("{}_sd", primary.name())
}

/// How a trial was made; differs between equal trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialTiming {
    /// Seconds from taking it up to its result, of the process that finished it.
    pub seconds: f64,
    /// Worker threads.
    pub threads: usize,
    /// Machine.
    pub host: String,
    /// How many times it was taken up.
    pub attempts: u32,
}

/// Why a trial could not be run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Identity of the trial.
    pub identity: String,
    /// The error that ended it.
    pub error: String,
}

impl TrialTiming {
    /// Writes the file without waiting for the disk: a trial counts by its result alone.
    pub(crate) fn write(&self, folder: &SweepFolder, identity: &str) -> Result<()> {
        json::write_unflushed(&folder.timing(identity), self)
    }

    /// Reads how a finished trial was made; none where a power cut lost the file.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub(crate) fn read(folder: &SweepFolder, identity: &str) -> Result<Option<Self>> {
        let bytes = json::bytes(&folder.timing(identity))?;
        Ok(bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()))
    }
}

impl TrialResult {
    pub(crate) fn of(identity: &str, data: &DataOf, results: &Results) -> Self {
        let primary = Primary::of(&results.task);
        let shown: Vec<&str> = metrics(&results.task)
            .iter()
            .filter(|metric| metric.is_shown)
            .map(|metric| metric.name)
            .collect();
        let score = |results: &taxel_learn::NetworkResults| {
            let mean = results.mean.as_ref()?;
            let mut scores = Scores::default();
            for name in &shown {
                scores.set(name, mean.get(name)?);
                if let Some(sd) = results.primary_spread().filter(|_| *name == primary.name()) {
                    scores.set(&sd_of(&primary), sd);
                }
            }
            let (network, zoo, folds) = (results.network.clone(), results.zoo.clone(), results.folds.len());
            Some(NetworkScore { network, zoo, folds, scores })
        };
        TrialResult {
            identity: identity.into(),
            name: results.name.clone(),
            data: data.clone(),
            seed: results.seed,
            networks: results.networks.iter().filter_map(score).collect(),
            primary: primary.clone(),
        }
    }

    /// Reads the result of a finished trial or run; `None` where it is not finished.
    ///
    /// # Errors
    /// A damaged file, or one of another trial.
    pub fn read(folder: &SweepFolder, identity: &str) -> Result<Option<Self>> {
        let path = folder.result(identity);
        let read: Option<TrialResult> = json::read(&path)?;
        match &read {
            Some(record) if record.identity != identity => {
                let reason = format!("is of {}, not of {identity}; delete it", record.identity);
                Err(Error::file(&path, reason))
            }
            _ => Ok(read),
        }
    }
}
