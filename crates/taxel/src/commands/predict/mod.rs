//! `taxel predict`: the predictions of a model for new recordings.

mod explain;
mod formats;
mod guard;
mod samples;
pub mod true_values;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum, ValueHint};
use taxel::data::Recordings;
use taxel::{Model, ReadOptions};

use explain::Explained;
use guard::Replaced;
use samples::SamplePredictions;
use true_values::TrueValues;

use crate::CommandResult;
use crate::arrays::write;
use crate::commands::arguments::certainty::CertaintyOptions;
use crate::commands::arguments::model_recordings::ModelRecordings;
use crate::commands::arguments::threads::Threads;
use crate::out;
use crate::terminal::messages::{note, warn};

/// Predicts the classes of recordings with a model that `taxel fit` made, or one of a run folder's models/.
///
/// DATA may be anything that `taxel data check` reads, with or without labels, a folder of files, or a single
/// CSV (rows = time), NPY, MAT, PNG or JPEG file. Where there are labels, the command also says how many predictions are
/// right; where there are values of the model's quantities, how far off it is.
///
/// Recordings may have any length where the model was trained with a length rule: it applies that rule. Under the rule
/// `window` every window has a prediction, and `start` is its first time step in the recording.
///
/// A model that was fitted from a run says `unknown` for samples that are unlike all that it has learned from, as `familiarity`
/// tells: the share of held-out samples that were less like them. `likeliest` keeps the class that it would have named; a value is
/// printed beside the word, and without an interval.
///
/// text prints sample, class and probability; csv has a row per sample with every probability; json one object
/// per sample; npz arrays `predicted` [N] ([N, attributes]) and `probabilities` [N, outputs], of windows `recording`
/// and `start` [N] too. Behind a guard `replaced` names the broken channels or taxels of each sample; csv and npz
/// count them.
#[derive(Args)]
#[command(after_help = "Examples:  taxel predict model.safetensors recordings.npz
           taxel predict model.safetensors press.csv
           taxel predict model.safetensors press.csv --explain
           taxel predict model.safetensors recordings/ --format csv --output predictions.csv")]
pub struct Predict {
    /// The model file.
    #[arg(value_hint = ValueHint::FilePath)]
    model: PathBuf,
    /// The recordings: a file or a folder.
    data: PathBuf,
    /// How the result is printed: text to read, or csv, json or npz for programs.
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "text")]
    format: PredictionFormat,
    /// The file to write [default: the result is printed]; npz needs it.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    read_options: ReadOptions,
    /// Leaves the model's guard out, if it has one: broken channels and taxels keep their values.
    #[arg(long)]
    no_guard: bool,
    /// Predicts recordings that are not as in training: unit, rate, full scale, layout and bit depth are not compared.
    #[arg(long)]
    as_is: bool,
    /// Says what each prediction rests on: how it changes where a sensor, or a part of the window, reads as at rest. For text and
    /// json, and at most 100 samples.
    #[arg(long)]
    explain: bool,
    #[command(flatten)]
    certainty: CertaintyOptions,
    #[command(flatten)]
    threads: Threads,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum PredictionFormat {
    #[value(alias = "table")]
    Text,
    Csv,
    Json,
    Npz,
}

impl Predict {
    pub fn run(self) -> CommandResult {
        if self.format == PredictionFormat::Npz && self.output.is_none() {
            return Err("npz is no text: name a file with --output".into());
        }
        if self.explain && matches!(self.format, PredictionFormat::Csv | PredictionFormat::Npz) {
            return Err("--explain: has no columns in csv and npz; print text or json".into());
        }
        let model = Model::open(&self.model)?;
        let card = model.card();
        let (unknown, sets) = self.certainty.of(card)?;
        let interval = self.certainty.interval(card)?;
        let recordings =
            ModelRecordings { data: &self.data, read_options: &self.read_options, as_is: Some(self.as_is) };
        let (Recordings { x, origins, starts, truth, values, .. }, options) = recordings.of(card)?;
        let mut predictor = model.predictor(card.batch(), self.threads.count()?)?;
        if self.no_guard {
            predictor = predictor.guarded(None)?;
        }
        let refuse = |e| format!("{}: {e}", self.data.display());
        let predictions = predictor.predict(&x).map_err(refuse)?;
        if let Some(words) = predictor.range_warning(&x).map_err(refuse)? {
            warn(format!("{}: {words}", self.data.display()));
        }
        let replaced = match predictor.guard() {
            Some(guard) => Some(Replaced::new(guard.clone(), predictor.found(&x).map_err(refuse)?)),
            None => None,
        };
        let explained = if self.explain { Some(Explained::of(&predictor, card, &x)?) } else { None };
        let (starts, truth) = (starts.as_deref(), truth.as_deref());
        let replaced = replaced.as_ref();
        let values = values.as_ref().filter(|_| !card.task.quantities().is_empty());
        let values = values.and_then(|values| TrueValues::new(&card.task, values).map_err(note).ok());
        let samples = SamplePredictions {
            origins: &origins,
            starts,
            predictions: &predictions,
            truth,
            values: values.as_ref(),
            replaced,
            explained: explained.as_ref(),
            is_calibrated: card.certainty.is_some(),
            unknown,
            sets: sets.as_ref(),
            interval,
        };
        self.write(&samples)?;
        if let Some(line) = replaced.and_then(Replaced::summary) {
            note(line);
        }
        if let Some(line) = samples.score() {
            let caution = if self.was_trained_on(card, &options) {
                "; the model was trained on these recordings, so this says nothing about new ones"
            } else {
                ""
            };
            note(format!("{line}{caution}"));
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Checks whether the model was trained on these recordings.
    fn was_trained_on(&self, card: &taxel::Card, options: &ReadOptions) -> bool {
        taxel::load(&self.data, options).is_ok_and(|dataset| dataset.digest == card.trained_on.digest)
    }

    fn write(&self, samples: &SamplePredictions) -> Result<(), Box<dyn std::error::Error>> {
        let text = match self.format {
            PredictionFormat::Text => samples.table(),
            PredictionFormat::Csv => samples.csv(),
            PredictionFormat::Json => samples.json()?,
            PredictionFormat::Npz => {
                let path = self.output.as_deref().unwrap_or(Path::new("predictions.npz"));
                return Ok(write(path, samples.npz())?);
            }
        };
        match &self.output {
            Some(path) => Ok(write(path, Ok(text.into_bytes()))?),
            None => {
                out!("{text}");
                Ok(())
            }
        }
    }
}
