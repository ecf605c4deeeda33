//! `taxel quantize`: models in eight bits.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use taxel::learn::quantize_run;
use taxel::{Model, Registry, RunFolder};

use crate::Outcome;
use crate::commands::asked::Asked;

/// Makes a network answer in eight bits: smaller and faster, and nearly as accurate.
///
/// Of a MODEL that `taxel fit` made it writes another one, with ranges that values had on the recordings of --calibrate:
/// best those that it has learned from, or others of the same sensor. Weights are rounded for each output by itself.
///
/// Of a RUN it puts every network beside itself as <name>.int8, each fold calibrated on its own training samples and
/// tested on samples that it has not seen; `taxel report` then shows both.
#[derive(Args)]
#[command(
    after_help = "Examples:  taxel quantize glove.safetensors --calibrate recordings.npz --output glove8.safetensors
           taxel quantize runs/glove && taxel report runs/glove"
)]
pub struct Quantize {
    /// A model, or a run folder.
    from: PathBuf,
    /// Recordings like those that the model will be asked about.
    #[arg(long, value_name = "DATA")]
    calibrate: Option<PathBuf>,
    /// Where the model in eight bits goes, `.safetensors`.
    #[arg(long, short)]
    output: Option<PathBuf>,
    #[command(flatten)]
    reading: taxel::ReadOptions,
}

impl Quantize {
    pub fn run(self) -> Outcome {
        match (self.from.is_dir(), &self.calibrate, &self.output) {
            (true, None, None) => of_run(&self.from),
            (true, ..) => {
                Err("--calibrate, --output: a run calibrates each fold on its own training samples, and keeps the models".into())
            }
            (false, Some(data), Some(output)) => self.of_model(data, output),
            (false, ..) => Err("a model needs --calibrate DATA and --output MODEL".into()),
        }
    }

    fn of_model(&self, data: &Path, output: &Path) -> Outcome {
        if output.extension().is_none_or(|e| e != "safetensors") {
            return Err(format!("{}: a model is a .safetensors file", output.display()).into());
        }
        let model = Model::open(&self.from)?;
        let (recordings, options) = Asked { data, reading: &self.reading }.of(model.card())?;
        let options = taxel::ReadOptions { channels: model.card().spec.channels.clone(), ..options };
        // Unlabelled recordings are no data set, but have samples.
        let digest = match taxel::load(data, &options) {
            Ok(dataset) => dataset.digest,
            Err(_) => taxel::data::digest_of(&recordings.x),
        };
        let quantized = model.quantized(&recordings.x, &digest)?;
        quantized.save(output)?;
        print!("{}", quantized.card());
        println!("model        {}", output.display());
        Ok(ExitCode::SUCCESS)
    }
}

fn of_run(path: &Path) -> Outcome {
    let folder = RunFolder::open(path)?;
    let (_, dataset) = taxel::experiment::open(&folder, &Registry::built_in())?;
    let rows = quantize_run(&folder, &dataset, &|what| eprintln!("{what}"))?;
    if rows.is_empty() {
        return Err(format!("{}: has no network to put in eight bits", path.display()).into());
    }
    println!("{}", taxel::Table::of(&folder)?);
    println!("report       taxel report {}", path.display());
    Ok(ExitCode::SUCCESS)
}
