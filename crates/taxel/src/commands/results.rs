//! `taxel results`: the scores of many runs as one table for programs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::base::files::write_whole;
use taxel::learn::metrics::metrics;
use taxel::learn::{NetworkResults, Results};
use taxel::{RunFolder, learn};

use crate::{CommandResult, out, outln};

/// Folders below a folder that are looked into for runs.
const DEPTH: usize = 4;

/// The columns, in their order.
const COLUMNS: [&str; 26] = [
    "run",
    "name",
    "source",
    "data_digest",
    "samples",
    "protocol",
    "seed",
    "complete",
    "row",
    "network",
    "paper",
    "trained_under_faults",
    "eight_bits",
    "per_class",
    "parameters",
    "macs",
    "folds",
    "diverged",
    "metric",
    "unit",
    "mean",
    "sd",
    "low",
    "high",
    "taxel",
    "commit",
];

/// Prints the scores of all rows of all runs as one CSV: a line for each metric of each row.
///
/// Nothing is measured or trained. `low` and `high` are the 95 % interval of the primary metric, which stands first. A field that a
/// run does not have is empty. PATH may hold run folders at any place below it.
#[derive(Args)]
#[command(after_help = "Examples:  taxel results runs > results.csv
           taxel results runs/quickstart runs/glove --output results.csv")]
pub struct ResultsOfRuns {
    /// Run folders, or folders that hold some.
    #[arg(required = true, value_hint = ValueHint::DirPath)]
    path: Vec<PathBuf>,
    /// The CSV file to write [default: standard output].
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    output: Option<PathBuf>,
}

impl ResultsOfRuns {
    pub fn run(self) -> CommandResult {
        let mut runs = vec![];
        for path in &self.path {
            let before = runs.len();
            collect(path, DEPTH, &mut runs).map_err(|error| format!("{}: {error}", path.display()))?;
            if runs.len() == before {
                let fix = "name a run folder, or a folder that holds some (taxel run writes them)";
                return Err(format!("{}: holds no run folder; {fix}", path.display()).into());
            }
        }
        let mut text = line(&COLUMNS.map(String::from));
        for run in &runs {
            let folder = RunFolder::open(run)?;
            text += &rows(run, &folder)?;
        }
        match &self.output {
            None => out!("{text}"),
            Some(path) => {
                write_whole(path, text.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))?;
                outln!("{} runs, {} lines: {}", runs.len(), text.lines().count() - 1, path.display());
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Collects the run folders at and below a path, in the order of their names.
fn collect(path: &Path, depth: usize, runs: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if path.join("results.json").is_file() {
        runs.push(path.into());
        return Ok(());
    }
    let mut below: Vec<PathBuf> = vec![];
    for entry in std::fs::read_dir(path)? {
        let entry = entry?;
        // A link may lead back to where it is.
        if entry.file_type()?.is_dir() {
            below.push(entry.path());
        }
    }
    below.sort();
    below.iter().filter(|_| depth > 0).try_for_each(|path| collect(path, depth - 1, runs))
}

/// Returns the lines of a run.
fn rows(path: &Path, folder: &RunFolder) -> learn::Result<String> {
    let results = folder.results()?;
    let environment = folder.environment().ok();
    let version = environment.as_ref().map_or(String::new(), |known| known.taxel.clone());
    let commit = environment.and_then(|known| known.commit).unwrap_or_default();
    let mut text = String::new();
    for network in &results.networks {
        for (at, (metric, mean)) in network.mean.iter().flat_map(learn::metrics::Scores::iter).enumerate() {
            let mut fields = of_run(path, &results);
            fields.extend(of_row(network));
            let unit = metrics(&results.task).iter().find(|known| known.name == metric);
            let unit = unit.and_then(|known| known.unit_of(&results.task)).unwrap_or_default();
            let ends = network.interval.filter(|_| at == 0).map(|ends| ends.map(|end| end.to_string()));
            let sd = network.spread(metric).map_or(String::new(), |sd| sd.to_string());
            fields.extend([metric.into(), unit.to_string(), mean.to_string(), sd]);
            fields.extend(ends.unwrap_or_default());
            fields.extend([version.clone(), commit.clone()]);
            text += &line(&fields);
        }
    }
    Ok(text)
}

/// Returns the fields that all lines of a run share.
fn of_run(path: &Path, results: &Results) -> Vec<String> {
    vec![
        path.display().to_string(),
        results.name.clone(),
        results.source.to_string(),
        results.data_digest.clone(),
        results.samples.to_string(),
        results.protocol.words(&results.task),
        results.seed.to_string(),
        results.complete.to_string(),
    ]
}

/// Returns the fields that all lines of a row share.
fn of_row(network: &NetworkResults) -> Vec<String> {
    vec![
        network.network.clone(),
        network.zoo.clone(),
        network.paper.clone(),
        network.hardening.is_some().to_string(),
        network.quantized.is_some().to_string(),
        network.per_class.map_or(String::new(), |count| count.to_string()),
        network.costs.parameters.to_string(),
        network.costs.macs.to_string(),
        network.folds.len().to_string(),
        network.diverged.to_string(),
    ]
}

/// Returns a line of CSV (RFC 4180): fields with commas, quotes or line ends stand in quotes.
fn line(fields: &[String]) -> String {
    let quoted = |field: &String| {
        let needs_quotes = field.contains([',', '"', '\n', '\r']);
        if needs_quotes { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.clone() }
    };
    fields.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}
