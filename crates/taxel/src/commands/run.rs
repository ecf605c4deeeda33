//! `taxel run`: the experiments of config files.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use taxel_trainer::{Error, Experiment, IndicatifProgress, Overrides, RunOptions, Table, run};

use crate::Outcome;

/// Exit code after Ctrl-C, as shells have it.
const INTERRUPTED: u8 = 130;

/// Runs the experiment of each config, prints its table and writes a run folder.
///
/// Every network is trained and scored on every fold. Published numbers stand in their own column: they
/// are a paper's, on its own recordings. Ctrl-C leaves a readable run folder; --resume goes on from it.
#[derive(Args)]
#[command(after_help = "Examples:  taxel run configs/quickstart.toml
           taxel run configs/quickstart.toml --quick --set train.epochs=5 --out runs/try
           TAXEL_DATA=/data taxel run configs/real/fsr-glove28.toml --resume")]
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
    /// The run folder [default: runs/<name>]; with several configs, a folder of run folders.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Goes on with an interrupted run, to the same bytes: finished folds are kept, and a fold in training
    /// goes on where it was saved.
    #[arg(long)]
    resume: bool,
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
        let cancel = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&cancel);
        ctrlc::set_handler(move || {
            // A second Ctrl-C does not wait for the current batch.
            if seen.swap(true, Ordering::SeqCst) {
                std::process::exit(i32::from(INTERRUPTED));
            }
        })?;
        let overrides = Overrides {
            quick: self.quick,
            set: self.set.clone(),
            data: self.data.as_ref().map(|p| p.display().to_string()),
            seed: self.seed,
        };
        // All configs are read before the first runs: a typo in the last one costs no hours.
        let load = |path: &PathBuf| Experiment::load(path, &overrides);
        let experiments = self.config.iter().map(load).collect::<Result<Vec<_>, _>>()?;
        for experiment in &experiments {
            let out = match &self.out {
                Some(out) if experiments.len() > 1 => Some(out.join(&experiment.config().name)),
                out => out.clone(),
            };
            let options =
                RunOptions { out, resume: self.resume, threads: self.threads, save_every: self.save_every };
            let folder = match run(experiment, &options, &IndicatifProgress::default(), &cancel) {
                Ok(folder) => folder,
                Err(error @ Error::Cancelled { .. }) => {
                    eprintln!("{error}");
                    return Ok(ExitCode::from(INTERRUPTED));
                }
                Err(error) => return Err(error.into()),
            };
            let table = Table::of(&folder)?;
            if self.json {
                println!("{}", serde_json::to_string(table.json())?);
            } else {
                println!("{table}");
                println!("run folder: {}", folder.path().display());
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
