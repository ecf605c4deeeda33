//! `taxel`: the command line of the tactile model zoo.
//!
//! Exit codes: 0 done, 1 ran but a stated target was missed (`data check` found problems, some folds of a run did
//! not finish), 2 could not run, 75 stopped by a scheduler and to be taken up again (`taxel sweep`), 130 stopped by
//! Ctrl-C. Messages on standard error name the file, key or sample and the way
//! out.

// Doc comments on arguments are what --help prints, not Markdown.
#![allow(rustdoc::broken_intra_doc_links, rustdoc::invalid_html_tags)]

mod arrays;
mod boundary;
mod commands;
mod text;

use std::io::Write;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// What a command ends with: an exit code, or the one error to print.
type Outcome = Result<ExitCode, Box<dyn std::error::Error>>;

/// Which network is accurate enough on this tactile sensor, how fast is it, and where does it break.
#[derive(Parser)]
#[command(name = "taxel", version, arg_required_else_help = true)]
#[command(after_help = "Start with:  taxel run configs/quickstart.toml")]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(commands::run::Run),
    Report(commands::report::Report),
    Stress(commands::stress::Stress),
    Choose(commands::choose::Choose),
    Fit(commands::fit::Fit),
    Predict(commands::predict::Predict),
    Stream(commands::stream::Stream),
    Inspect(commands::inspect::Inspect),
    Export(commands::export::Export),
    Import(commands::import::Import),
    Zoo(commands::zoo::Zoo),
    Cost(commands::cost::Cost),
    Forward(commands::forward::Forward),
    Stitch(commands::stitch::Stitch),
    Encode(commands::encode::Encode),
    Simulate(commands::simulate::Simulate),
    #[command(subcommand)]
    Data(commands::data::Data),
    #[command(subcommand)]
    Sweep(commands::sweep::Sweep),
    Completions(commands::completions::Completions),
}

fn main() -> ExitCode {
    boundary::guarded(command).unwrap_or_else(|error| {
        // Nobody may be there to read it.
        let _ = writeln!(std::io::stderr(), "error: {error}");
        ExitCode::from(2)
    })
}

fn command() -> Outcome {
    match Arguments::parse().command {
        Command::Run(command) => command.run(),
        Command::Report(command) => command.run(),
        Command::Stress(command) => command.run(),
        Command::Choose(command) => command.run(),
        Command::Fit(command) => command.run(),
        Command::Predict(command) => command.run(),
        Command::Stream(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Export(command) => command.run(),
        Command::Import(command) => command.run(),
        Command::Zoo(command) => command.run(),
        Command::Cost(command) => command.run(),
        Command::Forward(command) => command.run(),
        Command::Stitch(command) => command.run(),
        Command::Encode(command) => command.run(),
        Command::Simulate(command) => command.run(),
        Command::Data(command) => command.run(),
        Command::Sweep(command) => command.run(),
        Command::Completions(command) => command.run(),
    }
}
