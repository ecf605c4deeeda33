//! `taxel init`: a config for recordings.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::ReadOptions;
use taxel::base::files::write_whole;

use crate::CommandResult;
use crate::commands::arguments::budget::Budget;
use crate::commands::arguments::option_hints::with_option_hint;
use crate::commands::arguments::threads::Threads;
use crate::outln;
use crate::terminal::interrupt::{GRACE, flag};

/// Writes a config for recordings: the encoding, networks, baselines, recipe and folds that suit them, to edit.
///
/// The choice follows from the layout, the number of samples and of groups, and whether classes or values are learned. Each method is
/// tried for a moment, and what does not fit the budget is left out. `taxel run DATA` runs the same choice without a file.
#[derive(Args)]
#[command(after_help = "Examples:  taxel init presses.npz
           taxel init recordings/ --length resample:300 --budget 30m --output skin.toml
           taxel init presses.npz && taxel run presses.toml")]
pub struct Init {
    /// A file or folder of recordings.
    #[arg(value_hint = ValueHint::AnyPath)]
    data: PathBuf,
    #[command(flatten)]
    read_options: ReadOptions,
    #[command(flatten)]
    budget: Budget,
    /// The config to write; nothing is written over [default: the name of the recordings, with .toml].
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    output: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
}

impl Init {
    pub fn run(self) -> CommandResult {
        let cancel = flag(GRACE)?;
        let threads = self.threads.count()?;
        let start = self.budget.start(&self.data, &self.read_options, threads, &cancel);
        let start = start.map_err(|error| with_option_hint(error, None))?;
        let output = self.output.unwrap_or_else(|| start.file().into());
        let refuse = |why: String| format!("{}: {why}", output.display());
        if output.exists() {
            return Err(refuse("is there already; --output names another file".into()).into());
        }
        write_whole(&output, start.to_toml().as_bytes()).map_err(|error| refuse(error.to_string()))?;
        outln!("config: {}", output.display());
        Ok(ExitCode::SUCCESS)
    }
}
