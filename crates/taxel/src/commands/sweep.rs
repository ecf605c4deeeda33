//! `taxel sweep`: many experiments on many machines.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, Subcommand, ValueHint};
use taxel::Registry;
use taxel::judge::named_scores;
use taxel::sweep::Sweep as Collected;
use taxel::sweep::{
    Arrays, Chunking, Emit, Study, SweepFolder, Trial, TrialOutcome, WorkOptions, collect, emit, plan,
    shares, tasks, work,
};

use crate::CommandResult;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::threads::Threads;
use crate::terminal::messages::{self, note};
use crate::terminal::signals::Signals;
use crate::terminal::tables;
use crate::{out, outln};

/// Rows of the table that `collect` prints.
const PRINTED: usize = 12;

/// Runs many experiments: planned once, run on many machines, collected on one page.
#[derive(Subcommand)]
#[command(after_help = "Examples:  taxel sweep plan study.toml
           taxel sweep run sweeps/study --jobs 2
           taxel sweep emit slurm sweeps/study --seconds-per-trial 5 && sh sweeps/study/slurm/submit.sh
           taxel sweep collect sweeps/study")]
pub enum Sweep {
    Plan(PlanStudy),
    RunOne(RunOne),
    Run(RunAll),
    Collect(Collect),
    #[command(subcommand)]
    Emit(EmitTo),
}

/// Plans a study: writes its manifest, a line for each trial with its resolved config.
///
/// Trials are the product of the configs, the grid, the list and the random draws of the study. Planning again
/// keeps what is finished, where the trial is the same.
#[derive(Args)]
#[command(after_help = "Example:  taxel sweep plan study.toml --output sweeps/study

study.toml:
  config = \"configs/quickstart.toml\"
  quick = true
  [grid]
  seed = [0, 1, 2]
  train.optimizer.lr = [0.1, 0.01]")]
pub struct PlanStudy {
    /// The study.
    #[arg(value_hint = ValueHint::FilePath)]
    study: PathBuf,
    /// Folder of the sweep [default: sweeps/<name>].
    #[arg(long, short, alias = "out", value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Runs some trials of a sweep that have no result yet; schedulers start it.
///
/// It waits for trials that another process runs, and takes them over when that process is silent for long. A trial that
/// was begun goes on where it was saved. SIGTERM and SIGUSR1 end the work after the epoch under way, saved, with exit
/// code 75: start it again. Exit code 1: some trial could not be run; collect says why.
#[derive(Args)]
#[command(after_help = "Example:  taxel sweep run-one sweeps/study --index 0 --count 4")]
pub struct RunOne {
    /// Folder of the sweep.
    #[arg(value_hint = ValueHint::DirPath)]
    sweep: PathBuf,
    /// Position of the first trial, from 0.
    #[arg(long, value_name = "N")]
    index: usize,
    /// Trials of one task.
    #[arg(long, value_name = "K", default_value_t = 1)]
    count: usize,
    #[command(flatten)]
    work: WorkArguments,
}

/// Runs all of a sweep on this machine; start it again after whatever ended it.
///
/// Exit codes as those of run-one.
#[derive(Args)]
#[command(after_help = "Example:  taxel sweep run sweeps/study --jobs 2")]
pub struct RunAll {
    /// Folder of the sweep.
    #[arg(value_hint = ValueHint::DirPath)]
    sweep: PathBuf,
    /// Trials at a time, at most one per thread.
    #[arg(long, value_name = "J", default_value_t = 1)]
    jobs: usize,
    #[command(flatten)]
    work: WorkArguments,
}

#[derive(Args)]
struct WorkArguments {
    #[command(flatten)]
    threads: Threads,
    /// Seconds between two savings of a training [default: 10].
    #[arg(long, value_name = "SECONDS")]
    save_every: Option<f64>,
    #[command(flatten)]
    stale: Stale,
}

#[derive(Args)]
struct Stale {
    /// Seconds of silence after which the trial of a process on another machine is taken over.
    #[arg(long = "stale", value_name = "SECONDS", default_value_t = 120.0, value_parser = seconds)]
    seconds: f64,
}

impl Stale {
    fn time(&self) -> Duration {
        Duration::from_secs_f64(self.seconds)
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.5..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("must be in 0.5..=1000000".into()),
    }
}

/// Collects all finished trials on one page, and lists the missing ones.
///
/// Runs whose folds were separate trials are put together first. Exit code 1: some trial has no result.
#[derive(Args)]
#[command(after_help = "Example:  taxel sweep collect sweeps/study --format json")]
pub struct Collect {
    /// Folder of the sweep.
    #[arg(value_hint = ValueHint::DirPath)]
    sweep: PathBuf,
    #[command(flatten)]
    stale: Stale,
    #[command(flatten)]
    format: OutputFormat,
}

/// Writes scripts that give the missing trials to a scheduler.
#[derive(Subcommand)]
pub enum EmitTo {
    Slurm(Slurm),
    Make(Make),
}

/// Writes job arrays for Slurm with all trials that have no result, and a job that collects them at the end.
#[derive(Args)]
#[command(after_help = "Example:  taxel sweep emit slurm sweeps/study --sbatch=--partition=short
          sh sweeps/study/slurm/submit.sh")]
pub struct Slurm {
    #[command(flatten)]
    tasks: TaskArgs,
    /// Tasks of one array: the cluster's MaxArraySize less one, or what a user may submit.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    max_array: usize,
    /// A further option of sbatch; may be given several times.
    #[arg(long = "sbatch", value_name = "OPTION", allow_hyphen_values = true)]
    options: Vec<String>,
}

/// Writes a Makefile with all trials that have no result.
#[derive(Args)]
#[command(after_help = "Example:  taxel sweep emit make sweeps/study
          make -j 4 -f sweeps/study/Makefile")]
pub struct Make {
    #[command(flatten)]
    tasks: TaskArgs,
}

#[derive(Args)]
struct TaskArgs {
    /// Folder of the sweep.
    #[arg(value_hint = ValueHint::DirPath)]
    sweep: PathBuf,
    /// Trials of one task [default: as many as take --task-seconds].
    #[arg(long, value_name = "K")]
    count: Option<usize>,
    /// Seconds that a trial takes [default: as long as finished trials took].
    #[arg(long, value_name = "SECONDS")]
    seconds_per_trial: Option<f64>,
    /// Seconds that a task should take [default: 120].
    #[arg(long, value_name = "SECONDS")]
    task_seconds: Option<f64>,
    /// Threads of one task.
    #[arg(long, alias = "threads", value_name = "N", default_value_t = 1)]
    task_threads: usize,
    /// The program on the machines that run the tasks [default: this one].
    #[arg(long, value_name = "PATH")]
    program: Option<PathBuf>,
}

impl Sweep {
    pub fn run(self) -> CommandResult {
        match self {
            Sweep::Plan(command) => command.run(),
            Sweep::RunOne(command) => {
                let range = command.index..command.index.saturating_add(command.count);
                command.work.work(&command.sweep, range, 1)
            }
            Sweep::Run(command) => command.work.work(&command.sweep, 0..usize::MAX, command.jobs),
            Sweep::Collect(command) => command.run(),
            Sweep::Emit(EmitTo::Slurm(command)) => command.run(),
            Sweep::Emit(EmitTo::Make(command)) => command.run(),
        }
    }
}

impl PlanStudy {
    fn run(self) -> CommandResult {
        let study = Study::load(&self.study)?;
        let output = self.output.unwrap_or_else(|| Path::new("sweeps").join(&study.name));
        let folder = SweepFolder::at(&output);
        let planned = plan(&study, &folder, &Registry::built_in())?;
        outln!("{}: {} trials", folder.manifest().display(), planned.trials);
        if planned.duplicates > 0 {
            outln!("{} points of the axes are a trial again and stand there once", planned.duplicates);
        }
        Ok(ExitCode::SUCCESS)
    }
}

impl WorkArguments {
    fn work(&self, sweep: &Path, range: std::ops::Range<usize>, jobs: usize) -> CommandResult {
        let folder = SweepFolder::open(sweep)?;
        let signals = Signals::listen()?;
        let shares = shares(self.threads.count()?, jobs);
        if shares.len() < jobs {
            note(format!("{} trials at a time: one per thread", shares.len()));
        }
        let options = WorkOptions {
            save_every: self.save_every,
            stale: self.stale.time(),
            stop: signals.stop.clone(),
            cancel: signals.cancel.clone(),
        };
        let say = |number: usize, trial: &Trial, came: &TrialOutcome| Self::say(number, trial, came);
        let tally = work(&folder, range, &shares, &options, &Registry::built_in(), &say)?;
        outln!("{} finished, {} were finished before, {} failed", tally.finished, tally.before, tally.failed);
        Ok(match (tally.stopped, tally.failed) {
            (true, _) => {
                note("stopped; the same command goes on");
                ExitCode::from(signals.code())
            }
            (false, 0) => ExitCode::SUCCESS,
            (false, _) => ExitCode::from(1),
        })
    }

    fn say(number: usize, trial: &Trial, came: &TrialOutcome) {
        let words = match came {
            TrialOutcome::Before => return,
            TrialOutcome::Finished { seconds } => format!("finished in {seconds:.1} s"),
            TrialOutcome::Held(holder) => format!("{holder} runs it; waits"),
            TrialOutcome::Stopped => "stopped".into(),
            TrialOutcome::Failed(error) => {
                return messages::error(format!("trial {number} ({}): failed: {error}", trial.words()));
            }
        };
        note(format!("trial {number} ({}): {words}", trial.words()));
    }
}

impl Collect {
    fn run(self) -> CommandResult {
        let folder = SweepFolder::open(&self.sweep)?;
        let name = std::path::absolute(&self.sweep)?;
        let name = name.file_name().unwrap_or_default().to_string_lossy();
        let (sweep, page) = collect(&folder, &name, &Registry::built_in(), self.stale.time())?;
        if self.format.is_json() {
            outln!("{}", serde_json::to_string(&named_scores(&sweep)?)?);
        } else {
            print(&sweep);
            outln!("page: {}", page.display());
        }
        let progress = sweep.progress;
        Ok(if progress.finished == progress.planned { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

fn print(sweep: &Collected) {
    let progress = &sweep.progress;
    outln!(
        "{}: {} of {} trials finished, {} failed, {} begun, {} missing",
        sweep.name,
        progress.finished,
        progress.planned,
        progress.failed,
        progress.begun,
        progress.missing
    );
    let first = sweep.settings.first().map(|setting| setting.primary.clone()).unwrap_or_default();
    let is_one = sweep.settings.iter().all(|setting| setting.primary == first);
    let head = if is_one { first.head() } else { "score".into() };
    let row = |setting: &taxel::sweep::Setting| {
        let (score, longer) = (&setting.score, setting.primary.show_longer());
        // A column for several metrics names each in its rows.
        let unit = if is_one { "" } else { &format!(" {}", setting.primary.head()) };
        let sd = score.sd.map_or("-".into(), longer);
        vec![
            setting.source.clone(),
            setting.network.clone(),
            setting.set.clone(),
            score.count.to_string(),
            longer(score.mean) + unit,
            sd,
        ]
    };
    if !sweep.settings.is_empty() {
        let rows: Vec<Vec<String>> = sweep.settings.iter().take(PRINTED).map(row).collect();
        let heads = ["on", "network", "with", "trials", &head, "SD"];
        outln!();
        out!("{}", tables::table(&heads, &rows, &[3, 4, 5]));
        outln!();
    }
    let ranked = sweep.across.iter().flat_map(|across| &across.words);
    ranked.chain(&sweep.notes).for_each(|line| outln!("{line}"));
    for trial in sweep.open.iter().filter(|trial| trial.state == "failed").take(PRINTED) {
        outln!("trial {} ({}): {}", trial.number, trial.trial, trial.reason);
    }
    if progress.failed > PRINTED {
        outln!("{} more failed; trials.csv names them", progress.failed - PRINTED);
    }
}

impl TaskArgs {
    fn tasks(&self) -> Result<(SweepFolder, taxel::sweep::Tasks), taxel::sweep::Error> {
        let folder = SweepFolder::open(&self.sweep)?;
        let chunking = Chunking {
            count: self.count,
            seconds_per_trial: self.seconds_per_trial,
            task_seconds: self.task_seconds,
        };
        let tasks = tasks(&folder, &chunking)?;
        outln!(
            "{} of {} trials have no result: {} tasks of at most {} of them",
            tasks.missing,
            tasks.planned,
            tasks.tasks.len(),
            tasks.each
        );
        Ok((folder, tasks))
    }

    fn emit(&self) -> std::io::Result<Emit> {
        let program = match &self.program {
            Some(program) => program.clone(),
            None => std::env::current_exe()?,
        };
        Ok(Emit { program, threads: self.task_threads.max(1) })
    }
}

impl Slurm {
    fn run(self) -> CommandResult {
        let (folder, tasks) = self.tasks.tasks()?;
        let emit = self.tasks.emit()?;
        let arrays = Arrays { max: self.max_array, options: self.options };
        let script = emit::slurm(&folder, &tasks, &emit, &arrays)?;
        outln!("submit with: sh {}", script.display());
        Ok(ExitCode::SUCCESS)
    }
}

impl Make {
    fn run(self) -> CommandResult {
        let (folder, tasks) = self.tasks.tasks()?;
        let makefile = emit::make(&folder, &tasks, &self.tasks.emit()?)?;
        outln!("run with: make -j 2 -f {}", makefile.display());
        Ok(ExitCode::SUCCESS)
    }
}
