//! `taxel`: the command line of the tactile model zoo.
//!
//! Exit codes: 0 done, 1 ran but a stated target was missed (`data check` found problems, some folds of a run did
//! not finish), 2 could not run, 75 stopped by a scheduler and to be started again (`taxel sweep`), 130 stopped by
//! Ctrl-C. Messages on standard error name the file, key or sample and how to fix it.

// Doc comments on arguments are what --help prints, not Markdown.
#![allow(rustdoc::broken_intra_doc_links, rustdoc::invalid_html_tags)]

mod arrays;
mod commands;
mod help;
mod live;
mod terminal;

use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use commands::arguments::paths::check_inputs;
use terminal::messages::{self, FAILED, Verbosity};

/// The end of a command: an exit code, or the one error to print.
type CommandResult = Result<ExitCode, Box<dyn std::error::Error>>;

/// Which network is accurate enough on this tactile sensor, how fast is it, and where does it break.
#[derive(Parser)]
#[command(name = "taxel", version, arg_required_else_help = true)]
#[cfg_attr(
    feature = "lab",
    command(
        after_help = "Start with:  taxel run RECORDINGS, or taxel run configs/quickstart.toml\nHelp with examples:  taxel COMMAND --help"
    )
)]
#[cfg_attr(
    not(feature = "lab"),
    command(after_help = "This build predicts; training and reports come with the cargo feature `lab`.")
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    messages: Messages,
}

#[derive(Args)]
struct Messages {
    /// Prints errors and results only: no notes, no warnings, no progress.
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Prints details: threads, files, times.
    #[arg(long, short, global = true)]
    verbose: bool,
}

#[derive(Subcommand)]
enum Command {
    #[cfg(feature = "lab")]
    #[command(subcommand)]
    Data(commands::data::Data),
    #[cfg(feature = "lab")]
    Simulate(commands::simulate::Simulate),
    #[cfg(feature = "lab")]
    Encode(commands::encode::Encode),
    Record(Box<commands::record::Record>),
    #[cfg(feature = "lab")]
    Init(commands::init::Init),
    #[cfg(feature = "lab")]
    Run(Box<commands::run::RunExperiments>),
    #[cfg(feature = "lab")]
    Fit(commands::fit::Fit),
    #[cfg(feature = "lab")]
    Calibrate(commands::calibrate::Calibrate),
    #[cfg(feature = "lab")]
    Import(commands::import::Import),
    #[cfg(feature = "lab")]
    Stitch(commands::stitch::Stitch),
    #[cfg(feature = "lab")]
    Report(commands::report::Report),
    #[cfg(feature = "lab")]
    Results(commands::results::ResultsOfRuns),
    #[cfg(feature = "lab")]
    Choose(commands::choose::Choose),
    #[cfg(feature = "lab")]
    Compare(Box<commands::compare::Compare>),
    #[cfg(feature = "lab")]
    Stress(commands::stress::Stress),
    Predict(Box<commands::predict::Predict>),
    Stream(Box<commands::stream::Stream>),
    Inspect(commands::inspect::Inspect),
    #[cfg(feature = "lab")]
    Quantize(commands::quantize::Quantize),
    #[cfg(feature = "lab")]
    Export(commands::export::Export),
    #[cfg(feature = "lab")]
    Shrink(commands::shrink::Shrink),
    #[cfg(feature = "lab")]
    #[command(subcommand)]
    Sweep(commands::sweep::Sweep),
    #[cfg(feature = "lab")]
    Zoo(commands::zoo::Zoo),
    #[cfg(feature = "lab")]
    Cost(commands::cost::Cost),
    #[cfg(feature = "lab")]
    Forward(commands::forward::Forward),
    #[cfg(feature = "lab")]
    Schema(commands::reference::schema::Schema),
    #[cfg(feature = "lab")]
    Completions(commands::reference::completions::Completions),
    #[cfg(feature = "lab")]
    Man(commands::reference::man::ManualPages),
}

/// Stack of the thread that runs a command, in bytes; that of the main thread is as small as `ulimit -s` makes it.
const STACK: usize = 8 << 20;

fn main() -> ExitCode {
    let failed = |error: &dyn std::fmt::Display| {
        messages::error(error);
        ExitCode::from(FAILED)
    };
    if let Err(error) = terminal::hear_file_limit() {
        return failed(&error);
    }
    let run = move || terminal::guarded(command).unwrap_or_else(|error| failed(&error));
    match std::thread::Builder::new().name("main".into()).stack_size(STACK).spawn(run) {
        Ok(thread) => thread.join().unwrap_or(ExitCode::from(FAILED)),
        Err(error) => failed(&error),
    }
}

fn command() -> CommandResult {
    let mut tree = help::grouped(Arguments::command());
    let matches = tree.get_matches_mut();
    let Arguments { command, messages } =
        Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    messages::set_verbosity(match messages {
        Messages { quiet: true, .. } => Verbosity::Quiet,
        Messages { verbose: true, .. } => Verbosity::Verbose,
        Messages { .. } => Verbosity::Normal,
    });
    check_inputs(&tree, &matches)?;
    let begun = Instant::now();
    let outcome = command.run();
    messages::detail(format!("took {:.2} s", begun.elapsed().as_secs_f64()));
    outcome
}

impl Command {
    fn run(self) -> CommandResult {
        match self {
            #[cfg(feature = "lab")]
            Command::Data(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Simulate(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Encode(command) => command.run(),
            Command::Record(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Run(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Init(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Fit(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Calibrate(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Import(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Stitch(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Report(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Results(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Choose(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Compare(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Stress(command) => command.run(),
            Command::Predict(command) => command.run(),
            Command::Stream(command) => command.run(),
            Command::Inspect(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Quantize(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Export(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Shrink(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Sweep(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Zoo(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Cost(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Forward(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Schema(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Completions(command) => command.run(),
            #[cfg(feature = "lab")]
            Command::Man(command) => command.run(),
        }
    }
}
