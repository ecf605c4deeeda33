//! `taxel calibrate`: probabilities and intervals that are right as often as they say.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use taxel::{Model, ReadOptions};

use crate::CommandResult;
use crate::commands::arguments::model_recordings::ModelRecordings;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::paths::check_model_output;
use crate::terminal::messages::note;
use crate::{out, outln};

/// Fits the probabilities of a model, or the intervals around its values, to labelled recordings that it has not learned from.
///
/// Nothing is trained and no answer becomes another; only how sure the model is changes, and which samples it calls unknown. `taxel
/// fit RUN` does the same with the test parts of the run, and for early decisions too, which `calibrate` forgets. Give recordings as
/// the model will meet them: of other objects, sessions or people than those of the training, with their group.
#[derive(Args)]
#[command(
    after_help = "Example:  taxel calibrate glove.safetensors new-objects/ --output glove-calibrated.safetensors"
)]
pub struct Calibrate {
    /// The model file.
    model: PathBuf,
    /// Labelled recordings, 30 or more.
    data: PathBuf,
    /// The model file to write, `.safetensors`.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    read_options: ReadOptions,
    #[command(flatten)]
    format: OutputFormat,
}

impl Calibrate {
    pub fn run(self) -> CommandResult {
        check_model_output(&self.output)?;
        let model = Model::open(&self.model)?;
        let recordings = ModelRecordings { data: &self.data, read_options: &self.read_options, as_is: None };
        let (recordings, dataset) = recordings.labelled(model.card())?;
        let calibrated = model.calibrated(&recordings.x, &dataset)?;
        calibrated.save(&self.output)?;
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(calibrated.card())?);
        } else {
            out!("{}", calibrated.card());
            outln!("model        {}", self.output.display());
        }
        if model.card().certainty.as_ref().is_some_and(|certainty| !certainty.tenths.is_empty()) {
            note(
                "what the model knew of early decisions is forgotten: recordings cannot tell it. Do not use stream --early with it, or fit it from its run",
            );
        }
        Ok(ExitCode::SUCCESS)
    }
}
