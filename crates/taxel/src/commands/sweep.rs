//! `taxel sweep`: many experiments on many machines.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, Subcommand};
use taxel::Registry;
use taxel::judge::named_scores;
use taxel::sweep::Sweep as Collected;
use taxel::sweep::{
    Arrays, Chunking, Emit, Outcome as Came, Study, SweepFolder, Trial, WorkOptions, collect, emit, plan,
    shares, tasks, work,
};

use crate::commands::signals::Signals;
use crate::{Outcome, text};

/// Rows of the table that `collect` prints.
const PRINTED: usize = 12;

/// Many experiments: planned once, run wherever there is room, collected on one page.
#[derive(Subcommand)]
#[command(after_help = "Examples:  taxel sweep plan study.toml
           taxel sweep run sweeps/study --jobs 2
           taxel sweep emit slurm sweeps/study --seconds-per-trial 5 && sh sweeps/study/slurm/submit.sh
           taxel sweep collect sweeps/study")]
pub enum Sweep {
    Plan(Plan),
    RunOne(RunOne),
    Run(Run),
    Collect(Collect),
    #[command(subcommand)]
    Emit(EmitTo),
}

/// Writes the manifest of a study: every trial with its resolved config, one a line.
///
/// Trials are the product of the configs, the grid, the list and the random draws of the study. Planning again
/// keeps what is finished, where the trial is the same.
#[derive(Args)]
#[command(after_help = "Example:  taxel sweep plan study.toml --out sweeps/study

study.toml:
  config = \"configs/quickstart.toml\"
  quick = true
  [grid]
  seed = [0, 1, 2]
  train.optimizer.lr = [0.1, 0.01]")]
pub struct Plan {
    /// The study.
    study: PathBuf,
    /// Folder of the sweep [default: sweeps/<name>].
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Runs some trials of a sweep, those that have no result yet: what a scheduler starts.
///
/// Trials that another process is at are waited for, and taken over if it is not heard of any more. A trial that was
/// begun goes on where it was saved. SIGTERM and SIGUSR1 end the work after the epoch under way, saved, with exit
/// code 75: start it again. Exit code 1: some trial could not be run; collect says why.
#[derive(Args)]
pub struct RunOne {
    /// Folder of the sweep.
    sweep: PathBuf,
    /// Position of the first trial, from 0.
    #[arg(long, value_name = "N")]
    index: usize,
    /// Number of trials.
    #[arg(long, value_name = "K", default_value_t = 1)]
    count: usize,
    #[command(flatten)]
    how: How,
}

/// Runs all of a sweep on this machine; start it again after whatever ended it.
///
/// Exit codes as those of run-one.
#[derive(Args)]
pub struct Run {
    /// Folder of the sweep.
    sweep: PathBuf,
    /// Trials at a time, at most one per thread.
    #[arg(long, value_name = "J", default_value_t = 1)]
    jobs: usize,
    #[command(flatten)]
    how: How,
}

#[derive(Args)]
struct How {
    /// Threads of all trials together [default: all cores]; results do not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    /// Seconds between two savings of a fold in training [default: 10].
    #[arg(long, value_name = "SECONDS")]
    save_every: Option<f64>,
    #[command(flatten)]
    stale: Stale,
    /// Says nothing of trials that go well.
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
struct Stale {
    /// Seconds after which a trial whose process on another machine is not heard of is taken over.
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

/// Makes the page of all that is finished, and says what is missing.
///
/// Runs whose folds were trials of their own are put together first. Exit code 1: some trial has no result.
#[derive(Args)]
pub struct Collect {
    /// Folder of the sweep.
    sweep: PathBuf,
    #[command(flatten)]
    stale: Stale,
    /// Prints everything as one JSON object.
    #[arg(long)]
    json: bool,
}

/// Writes scripts that hand what is missing to a scheduler.
#[derive(Subcommand)]
pub enum EmitTo {
    Slurm(Slurm),
    Make(Make),
}

/// Arrays for Slurm with all that has no result, and a job that collects when they have ended.
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

/// A Makefile with all that has no result: make -j 4 -f sweeps/study/Makefile.
#[derive(Args)]
pub struct Make {
    #[command(flatten)]
    tasks: TaskArgs,
}

#[derive(Args)]
struct TaskArgs {
    /// Folder of the sweep.
    sweep: PathBuf,
    /// Trials of a task [default: as many as take --task-seconds].
    #[arg(long, value_name = "K")]
    count: Option<usize>,
    /// Seconds that a trial takes [default: as long as finished trials took].
    #[arg(long, value_name = "SECONDS")]
    seconds_per_trial: Option<f64>,
    /// Seconds that a task should take [default: 120].
    #[arg(long, value_name = "SECONDS")]
    task_seconds: Option<f64>,
    /// Threads of a task.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// The program on the machines that run the tasks [default: this one].
    #[arg(long, value_name = "PATH")]
    program: Option<PathBuf>,
}

impl Sweep {
    pub fn run(self) -> Outcome {
        match self {
            Sweep::Plan(command) => command.run(),
            Sweep::RunOne(command) => {
                let range = command.index..command.index.saturating_add(command.count);
                command.how.work(&command.sweep, range, 1)
            }
            Sweep::Run(command) => command.how.work(&command.sweep, 0..usize::MAX, command.jobs),
            Sweep::Collect(command) => command.run(),
            Sweep::Emit(EmitTo::Slurm(command)) => command.run(),
            Sweep::Emit(EmitTo::Make(command)) => command.run(),
        }
    }
}

impl Plan {
    fn run(self) -> Outcome {
        let study = Study::load(&self.study)?;
        let out = self.out.unwrap_or_else(|| Path::new("sweeps").join(&study.name));
        let folder = SweepFolder::at(&out);
        let planned = plan(&study, &folder, &Registry::built_in())?;
        println!("{}: {} trials", folder.manifest().display(), planned.trials);
        if planned.duplicates > 0 {
            println!("{} points of the axes are a trial again and stand there once", planned.duplicates);
        }
        Ok(ExitCode::SUCCESS)
    }
}

impl How {
    fn work(&self, sweep: &Path, range: std::ops::Range<usize>, jobs: usize) -> Outcome {
        let folder = SweepFolder::open(sweep)?;
        let signals = Signals::listen()?;
        let shares = shares(super::threads(self.threads), jobs);
        if shares.len() < jobs {
            eprintln!("{} trials at a time: one per thread", shares.len());
        }
        let options = WorkOptions {
            save_every: self.save_every,
            stale: self.stale.time(),
            stop: signals.stop.clone(),
            cancel: signals.cancel.clone(),
        };
        let say = |number: usize, trial: &Trial, came: &Came| self.say(number, trial, came);
        let tally = work(&folder, range, &shares, &options, &Registry::built_in(), &say)?;
        println!(
            "{} finished, {} were finished before, {} failed",
            tally.finished, tally.before, tally.failed
        );
        Ok(match (tally.stopped, tally.failed) {
            (true, _) => {
                eprintln!("stopped; the same command goes on");
                ExitCode::from(signals.code())
            }
            (false, 0) => ExitCode::SUCCESS,
            (false, _) => ExitCode::from(1),
        })
    }

    fn say(&self, number: usize, trial: &Trial, came: &Came) {
        let words = match came {
            Came::Before => return,
            Came::Finished { .. } if self.quiet => return,
            Came::Finished { seconds } => format!("finished in {seconds:.1} s"),
            Came::Held(holder) => format!("{holder} is at it; waits"),
            Came::Stopped => "stopped".into(),
            Came::Failed(error) => format!("failed: {error}"),
        };
        eprintln!("trial {number} ({}): {words}", trial.words());
    }
}

impl Collect {
    fn run(self) -> Outcome {
        let folder = SweepFolder::open(&self.sweep)?;
        let name = std::path::absolute(&self.sweep)?;
        let name = name.file_name().unwrap_or_default().to_string_lossy();
        let (sweep, page) = collect(&folder, &name, &Registry::built_in(), self.stale.time())?;
        if self.json {
            println!("{}", serde_json::to_string(&named_scores(&sweep)?)?);
        } else {
            print(&sweep);
            println!("page: {}", page.display());
        }
        let progress = sweep.progress;
        Ok(if progress.finished == progress.planned { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

fn print(sweep: &Collected) {
    let progress = &sweep.progress;
    println!(
        "{}: {} of {} trials finished, {} failed, {} begun, {} missing",
        sweep.name, progress.finished, progress.planned, progress.failed, progress.begun, progress.missing
    );
    let first = sweep.settings.first().map(|own| own.primary.clone()).unwrap_or_default();
    let is_one = sweep.settings.iter().all(|own| own.primary == first);
    let head = if is_one { first.head() } else { "score".into() };
    let row = |own: &taxel::sweep::Setting| {
        let (score, longer) = (&own.score, own.primary.show_longer());
        // A column for several metrics names each in its rows.
        let unit = if is_one { "" } else { &format!(" {}", own.primary.head()) };
        let sd = score.sd.map_or("-".into(), longer);
        vec![
            own.source.clone(),
            own.network.clone(),
            own.set.clone(),
            score.count.to_string(),
            longer(score.mean) + unit,
            sd,
        ]
    };
    if !sweep.settings.is_empty() {
        let rows: Vec<Vec<String>> = sweep.settings.iter().take(PRINTED).map(row).collect();
        let heads = ["on", "network", "with", "trials", &head, "SD"];
        println!();
        print!("{}", text::table(&heads, &rows, &[3, 4, 5]));
        println!();
    }
    let ranked = sweep.across.iter().flat_map(|across| &across.words);
    ranked.chain(&sweep.notes).for_each(|line| println!("{line}"));
    for own in sweep.open.iter().filter(|own| own.state == "failed").take(PRINTED) {
        println!("trial {} ({}): {}", own.number, own.trial, own.reason);
    }
    if progress.failed > PRINTED {
        println!("{} more failed; trials.csv names them", progress.failed - PRINTED);
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
        println!(
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
        Ok(Emit { program, threads: self.threads.max(1) })
    }
}

impl Slurm {
    fn run(self) -> Outcome {
        let (folder, tasks) = self.tasks.tasks()?;
        let emit = self.tasks.emit()?;
        let arrays = Arrays { max: self.max_array, options: self.options };
        let script = emit::slurm(&folder, &tasks, &emit, &arrays)?;
        println!("submit with: sh {}", script.display());
        Ok(ExitCode::SUCCESS)
    }
}

impl Make {
    fn run(self) -> Outcome {
        let (folder, tasks) = self.tasks.tasks()?;
        let makefile = emit::make(&folder, &tasks, &self.tasks.emit()?)?;
        println!("run with: make -j 2 -f {}", makefile.display());
        Ok(ExitCode::SUCCESS)
    }
}
