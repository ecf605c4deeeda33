//! `taxel quantize`: models in eight bits or in bf16.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use taxel::learn::quantize_run;
use taxel::{Model, Registry, RunFolder};

use crate::CommandResult;
use crate::commands::arguments::model_recordings::ModelRecordings;
use crate::commands::arguments::paths::check_model_output;
use crate::terminal::messages::note;
use crate::{out, outln};

/// Puts a network in eight bits or in bf16: smaller and faster, and nearly as accurate.
///
/// From a MODEL that `taxel fit` made it writes a second one. Its ranges are those of the recordings of --calibrate: best
/// the ones that the model was trained on, or others of the same sensor. Weights are rounded for each output by itself.
///
/// With --to bf16 weights have 16 bits, and both factors of a product are rounded to bf16: half the file, without recordings, for
/// processors with AVX512-BF16 (`avx512_bf16` in /proc/cpuinfo). Others refuse to predict with it.
///
/// In a RUN it adds every network once more as <name>.int8, each fold calibrated on its training samples and tested on
/// samples that it has not seen; `taxel report` then shows both.
#[derive(Args)]
#[command(
    after_help = "Examples:  taxel quantize glove.safetensors --calibrate recordings.npz --output glove8.safetensors
           taxel quantize glove.safetensors --to bf16 --output glove16.safetensors
           taxel quantize runs/glove && taxel report runs/glove"
)]
pub struct Quantize {
    /// A model, or a run folder.
    from: PathBuf,
    /// The numbers of the result: eight bits, or bf16.
    #[arg(long, value_enum, value_name = "NUMBERS", default_value = "int8")]
    to: Numbers,
    /// Recordings like those that the model will see.
    #[arg(long, value_name = "DATA")]
    calibrate: Option<PathBuf>,
    /// The model file to write, `.safetensors`.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    read_options: taxel::ReadOptions,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Numbers {
    Int8,
    Bf16,
}

impl Quantize {
    pub fn run(self) -> CommandResult {
        if self.to == Numbers::Bf16 {
            return self.halve();
        }
        match (self.from.is_dir(), &self.calibrate, &self.output) {
            (true, None, None) => of_run(&self.from),
            (true, ..) => {
                Err("--calibrate, --output: a run calibrates each fold on its training samples and keeps its models; leave both out".into())
            }
            (false, Some(data), Some(output)) => self.of_model(data, output),
            (false, ..) => Err("a model needs --calibrate DATA and --output MODEL".into()),
        }
    }

    fn halve(&self) -> CommandResult {
        if self.from.is_dir() {
            let text = "--to bf16: takes a model, not a run; `taxel fit RUN --output MODEL` makes one, and a run has its folds' in models/";
            return Err(text.into());
        }
        if self.calibrate.is_some() {
            return Err("--calibrate: bf16 needs no recordings; leave it out, or take --to int8".into());
        }
        let output = self.output.as_ref().ok_or("a model in bf16 needs --output MODEL")?;
        check_model_output(output)?;
        finish(&Model::open(&self.from)?.halved()?, output)
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
        finish(&model.quantized(&recordings.x, &digest)?, output)
    }
}

/// Writes a model and prints its card.
fn finish(model: &Model, output: &Path) -> CommandResult {
    model.save(output)?;
    out!("{}", model.card());
    outln!("model        {}", output.display());
    Ok(ExitCode::SUCCESS)
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
