//! `trials.csv` and `scores.csv`: everything for other programs, written line by line.

use std::path::{Path, PathBuf};

use taxel_base::files::PartFile;
use taxel_base::spreadsheet_text;
use taxel_data::Task;
use taxel_judge::Primary;
use taxel_learn::metrics::metrics;

use crate::error::{Error, Result};
use crate::record::{TrialResult, TrialTiming, sd_of};
use crate::trial::{Trial, shown};

/// Both tables while they are written, under other names.
pub(crate) struct ResultTables {
    folder: PathBuf,
    keys: Vec<String>,
    trials: CsvTable,
    /// One for each metric that runs are scored by: the first is `scores.csv`, others bear its name.
    scores: Vec<(Primary, ScoreTable)>,
}

/// A table of scores with the names of the metrics in its last columns.
struct ScoreTable {
    table: CsvTable,
    metrics: Vec<String>,
}

struct CsvTable {
    path: PathBuf,
    out: csv::Writer<PartFile>,
}

impl ResultTables {
    /// Begins both tables below `folder`, with a column for each varied key.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn new(folder: &Path, keys: &[String]) -> Result<Self> {
        let trials = around(
            &["trial", "identity", "name"],
            keys,
            &["network", "repetition", "fold", "state", "reason", "seconds", "host", "attempts"],
        );
        Ok(ResultTables {
            folder: folder.into(),
            keys: keys.to_vec(),
            trials: CsvTable::new(folder.join("trials.csv"), &trials)?,
            scores: vec![],
        })
    }

    /// Returns the table of runs that are scored by that metric, which is begun where there is none.
    fn scored(&mut self, primary: &Primary) -> Result<&mut ScoreTable> {
        let at = match self.scores.iter().position(|(known, _)| known == primary) {
            Some(at) => at,
            None => {
                let name = match self.scores.len() {
                    0 => "scores.csv".into(),
                    // Two units of one metric are two tables.
                    more => format!("scores-{}-{}.csv", more + 1, primary.name()),
                };
                let before = ["run_folder", "identity", "name", "source", "data_digest", "seed_of_run"];
                let metrics = metric_names(primary);
                let mut heads = around(&before, &self.keys, &["network", "zoo", "folds"]);
                heads.extend(metrics.iter().map(|name| column(primary, name)));
                let table = CsvTable::new(self.folder.join(name), &heads)?;
                self.scores.push((primary.clone(), ScoreTable { table, metrics }));
                self.scores.len() - 1
            }
        };
        Ok(&mut self.scores[at].1)
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
            Some(timing) => {
                row.extend([timing.seconds.to_string(), timing.host.clone(), timing.attempts.to_string()])
            }
            None => row.extend([const { String::new() }; 3]),
        }
        self.trials.write(&row)
    }

    pub fn scores(&mut self, trial: &Trial, result: &TrialResult, run: &Path) -> Result<()> {
        for network in &result.networks {
            let mut row = vec![run.display().to_string(), result.identity.clone(), result.name.clone()];
            row.extend([result.data.source.clone(), result.data.digest.clone(), result.seed.to_string()]);
            row.extend(self.settings(trial));
            row.extend([network.network.clone(), network.zoo.clone(), network.folds.to_string()]);
            let scored = self.scored(&result.primary)?;
            let score =
                |name: &String| network.scores.get(name).map_or(String::new(), |value| value.to_string());
            row.extend(scored.metrics.iter().map(score));
            scored.table.write(&row)?;
        }
        Ok(())
    }

    fn settings(&self, trial: &Trial) -> Vec<String> {
        self.keys.iter().map(|key| trial.set.get(key).map_or(String::new(), shown)).collect()
    }

    /// Gives both tables their names.
    pub fn finish(mut self) -> Result<()> {
        if self.scores.is_empty() {
            self.scored(&Primary::default())?;
        }
        self.trials.finish()?;
        self.scores.into_iter().try_for_each(|(_, scores)| scores.table.finish())
    }
}

/// Returns the heads of a table, with those of the varied keys between.
fn around(before: &[&str], keys: &[String], behind: &[&str]) -> Vec<String> {
    let strings = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
    [strings(before), keys.to_vec(), strings(behind)].concat()
}

/// Lists the names of the metrics of a task with that primary metric, behind which its standard deviation stands.
fn metric_names(primary: &Primary) -> Vec<String> {
    let tasks = [Task::Classes(vec![]), Task::Values(vec![])];
    let of_task = tasks.iter().map(metrics).find(|all| all[0].name == primary.name()).unwrap_or_default();
    let mut names: Vec<String> =
        of_task.iter().filter(|metric| metric.is_shown).map(|metric| metric.name.into()).collect();
    names.insert(1.min(names.len()), sd_of(primary));
    names
}

/// Returns the name of a column: `accuracy_percent`, `accuracy_sd_points`; of values the name itself.
fn column(primary: &Primary, name: &str) -> String {
    match (primary.is_percent(), name == sd_of(primary)) {
        (_, true) => primary.column_of_loss(name),
        (true, false) => format!("{name}_percent"),
        (false, false) => name.into(),
    }
}

impl CsvTable {
    fn new(path: PathBuf, heads: &[String]) -> Result<Self> {
        let part = PartFile::create(&path).map_err(|e| Error::io(&path, "written", e))?;
        let mut table = CsvTable { path, out: csv::Writer::from_writer(part) };
        table.write(heads)?;
        Ok(table)
    }

    fn write(&mut self, row: &[String]) -> Result<()> {
        let cells = row.iter().map(|cell| spreadsheet_text(cell).into_owned());
        self.out.write_record(cells).map_err(|e| Error::io(&self.path, "written", e.into()))
    }

    fn finish(self) -> Result<()> {
        let CsvTable { path, out } = self;
        let part = out.into_inner().map_err(csv::IntoInnerError::into_error);
        part.and_then(PartFile::finish).map_err(|e| Error::io(&path, "written", e))
    }
}
