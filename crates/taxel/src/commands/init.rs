//! `taxel init`: a config for recordings.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueHint};
use serde_json::Value;
use taxel::base::files::write_whole;
use taxel::{ReadOptions, Registry, experiment};

use crate::CommandResult;
use crate::commands::arguments::budget::Budget;
use crate::commands::arguments::option_hints::with_option_hint;
use crate::commands::arguments::threads::Threads;
use crate::outln;
use crate::terminal::interrupt::{GRACE, flag};

/// File of the schema that a config names, beside it.
const SCHEMA: &str = "taxel.schema.json";

/// Writes a config for recordings: the encoding, networks, baselines, recipe and folds that suit them, to edit.
///
/// The choice follows from the layout, the number of samples and of groups, and whether classes or values are learned. Each method is
/// tried for a moment, and what does not fit the budget is left out. `taxel run DATA` runs the same choice without a file.
///
/// Beside it stands `taxel.schema.json`, which the first line names: an editor of TOML completes and checks its keys.
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
        let start = self.budget.start(&self.data, &self.read_options, &[], threads, &cancel);
        let start = start.map_err(|error| with_option_hint(error, None))?;
        let output = self.output.unwrap_or_else(|| start.file().into());
        let refuse = |why: String| format!("{}: {why}", output.display());
        if output.exists() {
            return Err(refuse("is there already; --output names another file".into()).into());
        }
        write_schema(&output.with_file_name(SCHEMA))?;
        let text = format!("#:schema ./{SCHEMA}\n{}", start.to_toml());
        write_whole(&output, text.as_bytes()).map_err(|error| refuse(error.to_string()))?;
        outln!("config: {}", output.display());
        Ok(ExitCode::SUCCESS)
    }
}

/// Writes the schema of this program's configs, over one of an earlier version and over nothing else.
fn write_schema(path: &Path) -> Result<(), String> {
    let schema = experiment::schema(&Registry::built_in());
    let refuse = |why: String| format!("{}: {why}", path.display());
    if path.exists() {
        let before = std::fs::read(path).map_err(|error| refuse(error.to_string()))?;
        let title = serde_json::from_slice::<Value>(&before).map(|before| before["title"].clone());
        if title.unwrap_or_default() != schema["title"] {
            return Err(refuse(
                "is there already and is no schema of taxel; --output writes to another folder".into(),
            ));
        }
    }
    let text = serde_json::to_string_pretty(&schema).map_err(|error| refuse(error.to_string()))?;
    write_whole(path, format!("{text}\n").as_bytes()).map_err(|error| refuse(error.to_string()))
}
