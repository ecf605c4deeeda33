//! `taxel quantize`: models in eight bits.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use taxel::learn::quantize_run;
use taxel::{Model, Registry, RunFolder};

use crate::CommandResult;
use crate::commands::arguments::model_recordings::ModelRecordings;
use crate::commands::arguments::paths::check_model_output;
use crate::terminal::messages::note;
use crate::{out, outln};

/// Puts a network in eight bits: smaller and faster, and nearly as accurate.
///
/// From a MODEL that `taxel fit` made it writes a second one. Its ranges are those of the recordings of --calibrate: best
/// the ones that the model was trained on, or others of the same sensor. Weights are rounded for each output by itself.
///
/// In a RUN it adds every network once more as <name>.int8, each fold calibrated on its training samples and tested on
/// samples that it has not seen; `taxel report` then shows both.
#[derive(Args)]
#[command(
    after_help = "Examples:  taxel quantize glove.safetensors --calibrate recordings.npz --output glove8.safetensors
           taxel quantize runs/glove && taxel report runs/glove"
)]
pub struct Quantize {
    /// A model, or a run folder.
    from: PathBuf,
    /// Recordings like those that the model will see.
    #[arg(long, value_name = "DATA")]
    calibrate: Option<PathBuf>,
    /// The model file to write, `.safetensors`.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    read_options: taxel::ReadOptions,
}

impl Quantize {
    pub fn run(self) -> CommandResult {
        match (self.from.is_dir(), &self.calibrate, &self.output) {
            (true, None, None) => of_run(&self.from),
            (true, ..) => {
                Err("--calibrate, --output: a run calibrates each fold on its training samples and keeps its models; leave both out".into())
            }
            (false, Some(data), Some(output)) => self.of_model(data, output),
            (false, ..) => Err("a model needs --calibrate DATA and --output MODEL".into()),
        }
    }

    fn of_model(&self, data: &Path, output: &Path) -> CommandResult {
        check_model_output(output)?;
        let model = Model::open(&self.from)?;
        let (recordings, options) =
            ModelRecordings { data, read_options: &self.read_options, as_is: None }.of(model.card())?;
        // Unlabelled recordings are no data set, but have samples.
        let digest = match taxel::load(data, &options) {
            Ok(dataset) => dataset.digest,
            Err(_) => taxel::data::digest_of(&recordings.x),
        };
        let quantized = model.quantized(&recordings.x, &digest)?;
        quantized.save(output)?;
        out!("{}", quantized.card());
        outln!("model        {}", output.display());
        Ok(ExitCode::SUCCESS)
    }
}

fn of_run(path: &Path) -> CommandResult {
    let folder = RunFolder::open(path)?;
    let (_, dataset) = taxel::experiment::open(&folder, &Registry::built_in())?;
    let rows = quantize_run(&folder, &dataset, &|text| note(text))?;
    if rows.is_empty() {
        return Err(format!("{}: has no network to put in eight bits", path.display()).into());
    }
    outln!("{}", taxel::ResultsTable::of(&folder)?);
    outln!("report       taxel report {}", path.display());
    Ok(ExitCode::SUCCESS)
}
