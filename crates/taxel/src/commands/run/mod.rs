//! `taxel run`: the experiments of config files.

mod plan;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::{Args, ValueHint};
use taxel::experiment::{self, Runner, settings};
use taxel::learn;
use taxel::learn::Progress;
use taxel::{Experiment, Overrides, ReadOptions, Registry, ResultsTable, RunFolder, RunOptions};

use crate::CommandResult;
use crate::commands::arguments::budget::Budget;
use crate::commands::arguments::option_hints::with_option_hint;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::threads::Threads;
use crate::terminal::interrupt::{GRACE, INTERRUPTED, flag};
use crate::terminal::messages::{self, detail, note, warn};
use crate::terminal::progress::progress;
use crate::{out, outln};

/// Runs the experiment of each config, or of recordings: cross-validates networks, prints their table, writes a run folder.
///
/// Recordings without a config get the encoding, networks, baselines and folds that suit them, as `taxel init` writes them, within
/// --budget. With --resume the choice is that of the run folder.
///
/// Every network is trained and scored on every fold. Published numbers stand in a column of their own: they are a
/// paper's, on that paper's recordings. Ctrl-C leaves a readable run folder; --resume goes on from it.
///
/// A training stops when its loss is not finite any more, and the others go on. One that ends far above the loss of
/// guessing is marked as diverged. Exit code 1: some folds did not finish.
#[derive(Args)]
#[command(after_help = "Examples:  taxel run presses.npz --budget 20m
           taxel run configs/quickstart.toml
           taxel run configs/quickstart.toml --quick --set train.epochs=5 --output runs/try
           taxel run configs/quickstart.toml --data presses/ --length resample:300
           TAXEL_DATA=/data taxel run configs/real/fsr-glove28.toml --resume
           taxel run configs/hardness/hardness.toml --only mlp,lstm --resume
           taxel run configs/quickstart.toml --plan
           taxel run configs/quickstart.toml --set train.epochs=5 --print-config > mine.toml")]
pub struct RunExperiments {
    /// Experiment files, or files and folders of recordings.
    #[arg(required = true, value_name = "CONFIG|DATA", value_hint = ValueHint::AnyPath)]
    config: Vec<PathBuf>,
    #[command(flatten)]
    budget: Budget,
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
    read_options: ReadOptions,
    /// Folder of the run [default: runs/<name>]; with several configs, a folder of run folders.
    #[arg(long, short, alias = "out", value_name = "DIR")]
    output: Option<PathBuf>,
    /// Goes on with what was interrupted, to the same bytes: finished folds are kept, and a fold in training goes on where
    /// it was saved.
    #[arg(long)]
    resume: bool,
    /// Measures the speed of finished networks again, for example after the machine was busy.
    #[arg(long, requires = "resume")]
    time_again: bool,
    /// Trains these only and leaves the rest to --resume: rows of the table (mlp), repetitions (r0), or both (mlp.r0),
    /// separated by commas.
    #[arg(long, value_name = "PARTS", value_delimiter = ',')]
    only: Vec<String>,
    /// Prints the whole config, with every default and what --quick, --set and others change, and trains nothing.
    #[arg(long, conflicts_with_all = ["resume", "only", "format", "json"])]
    print_config: bool,
    /// Says how many trainings a run and its learning curve would be, and about how long they would take here. Each method is tried
    /// for a moment on up to 256 samples; nothing else is trained, and nothing is written.
    #[arg(long, conflicts_with_all = ["resume", "only", "print_config"])]
    plan: bool,
    /// Seconds between two savings of a training [default: 10].
    #[arg(long, value_name = "SECONDS")]
    save_every: Option<f64>,
    #[command(flatten)]
    format: OutputFormat,
    /// Seed of every random choice [default: the config's].
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    threads: Threads,
}

impl RunExperiments {
    pub fn run(self) -> CommandResult {
        let cancel = flag(GRACE)?;
        let registry = Registry::built_in();
        let threads = self.threads.count()?;
        let experiments = self.experiments(&registry, threads, &cancel)?;
        if self.print_config {
            experiments.iter().for_each(|experiment| out!("{}", experiment.to_toml()));
            return Ok(ExitCode::SUCCESS);
        }
        if self.plan {
            let how = (threads, self.format.is_json());
            plan::print_plans(&experiments, &registry, how, &cancel)?;
            return Ok(ExitCode::SUCCESS);
        }
        let threads = Some(threads);
        let (resume, save_every, time_again) = (self.resume, self.save_every, self.time_again);
        let options = RunOptions { resume, threads, save_every, time_again, ..RunOptions::default() };
        let mut finished = true;
        for experiment in &experiments {
            let out = self.folder(experiment);
            let progress = progress();
            let folder = match self.train((experiment, &registry), &out, &options, &*progress, &cancel) {
                Ok(folder) => folder,
                Err(experiment::Error::Learn(error @ learn::Error::Cancelled { .. })) => {
                    note(format!("{error}\ncontinue with --resume --output {}", out.display()));
                    return Ok(ExitCode::from(INTERRUPTED));
                }
                // Hours of training that did finish are worth their table.
                Err(experiment::Error::Learn(error @ learn::Error::Unfinished { .. })) => {
                    messages::error(error);
                    finished = false;
                    RunFolder::open(&out)?
                }
                // The library says "resume" and "another folder": on the command line these are two options.
                Err(experiment::Error::Learn(error @ learn::Error::Folder { .. })) => {
                    let ways = "--resume goes on with the run of a folder, --output gives another folder";
                    return Err(format!("{error}\n{ways}").into());
                }
                Err(error) => return Err(with_option_hint(error, None)),
            };
            let table = ResultsTable::of(&folder)?;
            if self.format.is_json() {
                outln!("{}", serde_json::to_string(table.json())?);
            } else {
                outln!("{table}");
                outln!("run folder: {}", folder.path().display());
            }
        }
        Ok(if finished { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    /// Reads all configs, before the first of them runs: a typo in the last one costs no hours.
    fn experiments(
        &self,
        registry: &Registry,
        threads: usize,
        cancel: &AtomicBool,
    ) -> Result<Vec<Experiment>, Box<dyn std::error::Error>> {
        if let Some(path) = self.config.iter().find(|path| self.data.is_some() && !is_config(path)) {
            return Err(format!("{} and --data are both recordings; keep one of them", path.display()).into());
        }
        if let Some(path) = self.config.iter().find(|path| is_config(path)) {
            self.budget.refuse(path)?;
        }
        let set = self.set.iter().cloned().chain(settings(&self.read_options)).collect();
        let overrides =
            Overrides { quick: self.quick, set, data: self.data.clone(), seed: self.seed, place: None };
        let load = |path: &PathBuf| {
            if is_config(path) {
                Experiment::load(path, &overrides, registry)
            } else {
                self.started(path, registry, threads, cancel)
            }
        };
        let experiments = self.config.iter().map(load).collect::<Result<Vec<_>, _>>();
        experiments.map_err(|error| with_option_hint(error, None))
    }

    /// Chooses the experiment of recordings; one that goes on is that of its run folder.
    fn started(
        &self,
        path: &Path,
        registry: &Registry,
        threads: usize,
        cancel: &AtomicBool,
    ) -> experiment::Result<Experiment> {
        let (quick, seed) = (self.quick, self.seed);
        let overrides = Overrides { quick, seed, set: self.set.clone(), ..Overrides::default() };
        if self.resume {
            let folder =
                self.output.clone().unwrap_or_else(|| Path::new("runs").join(experiment::name_of(path)));
            let begun = folder.join(experiment::RUN_CONFIG);
            if begun.is_file() {
                self.budget.note_unused(&begun);
                let set = self.set.iter().cloned().chain(settings(&self.read_options)).collect();
                return Experiment::load(&begun, &Overrides { set, ..overrides }, registry);
            }
        }
        let start = self.budget.start(path, &self.read_options, &self.set, threads, cancel)?;
        Experiment::parse(&start.to_toml(), &start.file(), &overrides, registry)
    }

    /// Runs an experiment, and its trainings without some of the classes, if it has any.
    fn train(
        &self,
        (experiment, registry): (&Experiment, &Registry),
        out: &Path,
        options: &RunOptions,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> experiment::Result<RunFolder> {
        let dataset = experiment.dataset()?;
        dataset.warnings.iter().for_each(warn);
        let (name, samples) = (&dataset.name, dataset.x.shape()[0]);
        detail(format!("{name}: {samples} samples, digest {}", dataset.digest));
        let runner = Runner { experiment, registry, dataset: &dataset };
        let only = if self.only.is_empty() { None } else { Some(runner.keys_within(&self.only)?) };
        let folder = runner.run(Some(out), &RunOptions { only, ..options.clone() }, progress, cancel)?;
        if let Some(trial) = &experiment.config().unknown {
            runner.try_unknown(&folder, trial, options.threads(), progress, cancel)?;
        }
        Ok(folder)
    }

    /// Returns the run folder of one of the experiments.
    fn folder(&self, experiment: &Experiment) -> PathBuf {
        match &self.output {
            Some(output) if self.config.len() > 1 => output.join(&experiment.config().name),
            Some(output) => output.clone(),
            None => experiment.default_out(),
        }
    }
}

/// Checks whether a path is an experiment file, and not recordings.
fn is_config(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
}
