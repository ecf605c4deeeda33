//! `taxel compare`: two models, or rows of two runs, on the same samples.

mod models;
mod runs;
mod words;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::ReadOptions;
use taxel::judge::named_scores;

use crate::CommandResult;
use crate::commands::arguments::output_format::OutputFormat;
use crate::{out, outln};

/// Compares two models on the same labelled recordings, or the rows of two runs on the samples that both tested.
///
/// It says how far they are apart and how sure that is, who is right where, and what each costs. Models are tested over the samples
/// (McNemar's exact test, of groups a test over these; of values Wilcoxon's signed-rank test). Runs with equal folds are tested over
/// the folds (corrected resampled t-test), as `taxel choose` does. The verdict is at 5 %; where it is open, the number of samples is
/// said that would settle a difference of this size.
///
/// Give recordings that neither model has learned from.
#[derive(Args)]
#[command(after_help = "Examples:  taxel compare old.safetensors new.safetensors presses.npz
           taxel compare runs/monday runs/friday --network resnet8-lite-1d
           taxel compare runs/glove runs/glove --network mlp --network mini-rocket --format json")]
pub struct Compare {
    /// A model made by `taxel fit`, or a run folder.
    #[arg(value_name = "A", value_hint = ValueHint::AnyPath)]
    first: PathBuf,
    /// The model or run folder that it is compared with.
    #[arg(value_name = "B", value_hint = ValueHint::AnyPath)]
    second: PathBuf,
    /// Labelled recordings for two models.
    #[arg(value_hint = ValueHint::AnyPath)]
    data: Option<PathBuf>,
    /// The network or baseline, by its name in the tables of the runs; given twice, that of each [default: the most accurate].
    #[arg(long, value_name = "NAME")]
    network: Vec<String>,
    #[command(flatten)]
    read_options: ReadOptions,
    #[command(flatten)]
    format: OutputFormat,
}

impl Compare {
    pub fn run(self) -> CommandResult {
        let paths = [self.first.as_path(), self.second.as_path()];
        let found = match paths.map(|path| path.is_dir()) {
            [true, true] => {
                if let Some(data) = &self.data {
                    let data = data.display();
                    return Err(format!(
                        "{data}: runs are compared on their own test samples; leave the data out"
                    )
                    .into());
                }
                runs::compared(paths, &self.network)?
            }
            [false, false] => {
                if let Some(name) = self.network.first() {
                    return Err(format!(
                        "--network {name}: names rows of runs, and these are models; leave it out"
                    )
                    .into());
                }
                let missing = "models are compared on labelled recordings; name them behind the models";
                models::compared(paths, self.data.as_deref().ok_or(missing)?, &self.read_options)?
            }
            [a_run, _] => {
                let (run, model) = if a_run { (paths[0], paths[1]) } else { (paths[1], paths[0]) };
                let (run, model) = (run.display(), model.display());
                let fix = "compare two models, or two runs (models of a run are in its models/)";
                return Err(format!("{run} is a folder and {model} is none: {fix}").into());
            }
        };
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(&named_scores(&found)?)?);
        } else {
            out!("{}", words::page(&found));
        }
        Ok(ExitCode::SUCCESS)
    }
}
