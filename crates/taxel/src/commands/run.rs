//! `taxel run`: the experiments of config files.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use taxel::IndicatifProgress;
use taxel::experiment::{self, Runner, settings};
use taxel::learn;
use taxel::{Experiment, Overrides, ReadOptions, Registry, RunFolder, RunOptions, Table};

use crate::Outcome;
use crate::commands::interrupt::{INTERRUPTED, flag};
use crate::commands::reading::with_option_hint;

/// Runs the experiment of each config, prints its table and writes a run folder.
///
/// Every network is trained and scored on every fold. Published numbers stand in their own column: they
/// are a paper's, on its own recordings. Ctrl-C leaves a readable run folder; --resume goes on from it.
///
/// A training whose loss is not finite any more stops, and the others go on; one that ends far above the loss of
/// guessing is marked as diverged. Exit code 1: some folds did not finish.
#[derive(Args)]
#[command(after_help = "Examples:  taxel run configs/quickstart.toml
           taxel run configs/quickstart.toml --quick --set train.epochs=5 --out runs/try
           taxel run configs/quickstart.toml --data presses/ --length resample:300
           TAXEL_DATA=/data taxel run configs/real/fsr-glove28.toml --resume
           taxel run configs/hardness/hardness.toml --only mlp,lstm --resume
           taxel run configs/quickstart.toml --set train.epochs=5 --print-config > mine.toml")]
pub struct Run {
    /// Experiment files.
    #[arg(required = true)]
    config: Vec<PathBuf>,
    /// Uses the values of the config's [quick] table.
    #[arg(long)]
    quick: bool,
    /// A config value by its dotted key: train.epochs=20.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Recordings in place of the config's data.
    #[arg(long)]
    data: Option<PathBuf>,
    #[command(flatten)]
    reading: ReadOptions,
    /// The run folder [default: runs/<name>]; with several configs, a folder of run folders.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Goes on with an interrupted run, to the same bytes: finished folds are kept, and a fold in training
    /// goes on where it was saved.
    #[arg(long)]
    resume: bool,
    /// Times the answers of what is finished once more, such as on a machine that was busy before.
    #[arg(long, requires = "resume")]
    time_again: bool,
    /// Trains these alone and leaves the rest to --resume: rows of the table (mlp), repetitions (r0), or both (mlp.r0),
    /// separated by commas.
    #[arg(long, value_name = "PARTS", value_delimiter = ',')]
    only: Vec<String>,
    /// Prints the whole config, with every default and what --quick, --set and others change, and trains nothing.
    #[arg(long, conflicts_with_all = ["resume", "only", "json"])]
    print_config: bool,
    /// Seconds between two savings of a fold in training [default: 10].
    #[arg(long, value_name = "SECONDS")]
    save_every: Option<f64>,
    /// Prints one JSON object per config instead of tables.
    #[arg(long)]
    json: bool,
    /// A seed in place of the config's.
    #[arg(long)]
    seed: Option<u64>,
    /// Caps all threads [default: all cores]; results do not depend on it.
    #[arg(long)]
    threads: Option<usize>,
}

impl Run {
    pub fn run(self) -> Outcome {
        let cancel = flag()?;
        let registry = Registry::built_in();
        let set = self.set.iter().cloned().chain(settings(&self.reading)).collect();
        let overrides =
            Overrides { quick: self.quick, set, data: self.data.clone(), seed: self.seed, place: None };
        // All configs are read before the first runs: a typo in the last one costs no hours.
        let load = |path: &PathBuf| Experiment::load(path, &overrides, &registry);
        let experiments = self.config.iter().map(load).collect::<Result<Vec<_>, _>>()?;
        if self.print_config {
            experiments.iter().for_each(|experiment| print!("{}", experiment.to_toml()));
            return Ok(ExitCode::SUCCESS);
        }
        let threads = Some(super::threads(self.threads));
        let (resume, save_every, time_again) = (self.resume, self.save_every, self.time_again);
        let options = RunOptions { resume, threads, save_every, time_again, ..RunOptions::default() };
        let mut finished = true;
        for experiment in &experiments {
            let out = self.folder(experiment);
            let progress = IndicatifProgress::default();
            let trained = || -> experiment::Result<RunFolder> {
                let dataset = experiment.dataset()?;
                let runner = Runner { experiment, registry: &registry, dataset: &dataset };
                let only = match self.only.is_empty() {
                    true => None,
                    false => Some(runner.keys_within(&self.only)?),
                };
                runner.run(Some(&out), &RunOptions { only, ..options.clone() }, &progress, &cancel)
            };
            let folder = match trained() {
                Ok(folder) => folder,
                Err(experiment::Error::Learn(error @ learn::Error::Cancelled { .. })) => {
                    eprintln!("{error}\ncontinue with --resume --out {}", out.display());
                    return Ok(ExitCode::from(INTERRUPTED));
                }
                // Hours of training that did finish are worth their table.
                Err(experiment::Error::Learn(error @ learn::Error::Unfinished { .. })) => {
                    eprintln!("error: {error}");
                    finished = false;
                    RunFolder::open(&out)?
                }
                // What the library calls resuming and another folder are two options here.
                Err(experiment::Error::Learn(error @ learn::Error::Folder { .. })) => {
                    let ways = "--resume goes on with the run of a folder, --out gives another folder";
                    return Err(format!("{error}\n{ways}").into());
                }
                Err(error) => return Err(with_option_hint(error, None)),
            };
            let table = Table::of(&folder)?;
            if self.json {
                println!("{}", serde_json::to_string(table.json())?);
            } else {
                println!("{table}");
                println!("run folder: {}", folder.path().display());
            }
        }
        Ok(if finished { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    /// Returns the run folder of one of the experiments.
    fn folder(&self, experiment: &Experiment) -> PathBuf {
        match &self.out {
            Some(out) if self.config.len() > 1 => out.join(&experiment.config().name),
            Some(out) => out.clone(),
            None => experiment.default_out(),
        }
    }
}
