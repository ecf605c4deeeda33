//! `trials.csv` and `scores.csv`: everything for other programs, written line by line.

use std::path::{Path, PathBuf};

use taxel_base::files::Part;

use crate::error::{Error, Result};
use crate::record::{TrialResult, TrialTiming};
use crate::trial::{Trial, shown};

/// Both tables while they are written, under other names.
pub(crate) struct Tables {
    keys: Vec<String>,
    trials: Table,
    scores: Table,
}

struct Table {
    path: PathBuf,
    out: csv::Writer<Part>,
}

impl Tables {
    /// Begins both tables below `folder`, with a column for each varied key.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn new(folder: &Path, keys: &[String]) -> Result<Self> {
        let own = |before: &[&str], behind: &[&str]| {
            let strings = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
            [strings(before), keys.to_vec(), strings(behind)].concat()
        };
        let trials = own(
            &["trial", "identity", "name"],
            &["network", "repetition", "fold", "state", "reason", "seconds", "host", "attempts"],
        );
        let scores = own(
            &["run_folder", "identity", "name", "source", "data_digest", "seed_of_run"],
            &[
                "network",
                "zoo",
                "folds",
                "accuracy_percent",
                "accuracy_sd_points",
                "precision_percent",
                "recall_percent",
                "f1_percent",
            ],
        );
        Ok(Tables {
            keys: keys.to_vec(),
            trials: Table::new(folder.join("trials.csv"), &trials)?,
            scores: Table::new(folder.join("scores.csv"), &scores)?,
        })
    }

    pub fn trial(
        &mut self,
        number: usize,
        trial: &Trial,
        state: &str,
        reason: &str,
        timing: Option<&TrialTiming>,
    ) -> Result<()> {
        let mut row = vec![number.to_string(), trial.identity.clone(), trial.name.clone()];
        row.extend(self.settings(trial));
        match &trial.fold {
            Some(piece) => {
                let key = &piece.key;
                row.extend([key.network.clone(), key.repetition.to_string(), key.fold.to_string()]);
            }
            None => row.extend([const { String::new() }; 3]),
        }
        // One line: some programs count lines.
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        row.extend([state.into(), reason]);
        match timing {
            Some(own) => row.extend([own.seconds.to_string(), own.host.clone(), own.attempts.to_string()]),
            None => row.extend([const { String::new() }; 3]),
        }
        self.trials.write(&row)
    }

    pub fn scores(&mut self, trial: &Trial, result: &TrialResult, run: &Path) -> Result<()> {
        for own in &result.networks {
            let mut row = vec![run.display().to_string(), result.identity.clone(), result.name.clone()];
            row.extend([result.data.source.clone(), result.data.digest.clone(), result.seed.to_string()]);
            row.extend(self.settings(trial));
            row.extend([own.network.clone(), own.zoo.clone(), own.folds.to_string()]);
            row.push(own.accuracy.to_string());
            row.push(own.accuracy_sd.map_or(String::new(), |sd| sd.to_string()));
            row.extend([own.precision, own.recall, own.f1].map(|value| value.to_string()));
            self.scores.write(&row)?;
        }
        Ok(())
    }

    fn settings(&self, trial: &Trial) -> Vec<String> {
        self.keys.iter().map(|key| trial.set.get(key).map_or(String::new(), shown)).collect()
    }

    /// Gives both tables their names.
    pub fn finish(self) -> Result<()> {
        self.trials.finish()?;
        self.scores.finish()
    }
}

impl Table {
    fn new(path: PathBuf, heads: &[String]) -> Result<Self> {
        let part = Part::create(&path).map_err(|e| Error::io(&path, "written", e))?;
        let mut table = Table { path, out: csv::Writer::from_writer(part) };
        table.write(heads)?;
        Ok(table)
    }

    fn write(&mut self, row: &[String]) -> Result<()> {
        self.out.write_record(row).map_err(|e| Error::io(&self.path, "written", e.into()))
    }

    fn finish(self) -> Result<()> {
        let Table { path, out } = self;
        let part = out.into_inner().map_err(csv::IntoInnerError::into_error);
        part.and_then(Part::finish).map_err(|e| Error::io(&path, "written", e))
    }
}
