//! `taxel inspect`: the card of a model.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::Model;

use crate::CommandResult;
use crate::commands::arguments::output_format::OutputFormat;
use crate::{out, outln};

/// Prints the card of a model file: its inputs and outputs, its training data, its score.
///
/// The file needs nothing beside it. The command checks that its tensors belong to its card. With --format json the card
/// includes the network's graph.
#[derive(Args)]
#[command(after_help = "Examples:  taxel inspect model.safetensors --format json
           taxel inspect model.safetensors --model-card > README.md")]
pub struct Inspect {
    /// A model made by `taxel fit`, or one of a run folder's models/.
    #[arg(value_hint = ValueHint::FilePath)]
    model: PathBuf,
    /// The model card of the Hugging Face Hub in place of the card: Markdown with a head in YAML.
    #[arg(long, conflicts_with = "format")]
    model_card: bool,
    #[command(flatten)]
    format: OutputFormat,
}

impl Inspect {
    pub fn run(self) -> CommandResult {
        let model = Model::open(&self.model)?;
        if self.model_card {
            let file = self.model.file_name().unwrap_or_default().to_string_lossy();
            out!("{}", model.card().hub_page(&file));
        } else if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(model.card())?);
        } else {
            out!("{}", model.card());
        }
        Ok(ExitCode::SUCCESS)
    }
}
