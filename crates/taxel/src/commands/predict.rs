//! `taxel predict`: what a model says about new recordings.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::json;
use taxel::base::{Grid, thousands};
use taxel::data::{Npz, Recordings};
use taxel::{Model, Predictions, ReadOptions};

use crate::Outcome;
use crate::arrays::write;
use crate::commands::asked::Asked;
use crate::commands::guarding::Mended;
use crate::text;

/// Answers recordings with a model that `taxel fit` made, or one of a run folder's models/.
///
/// DATA may be anything that `taxel data check` reads, with or without labels, a folder of files, or a single
/// CSV (rows = time), NPY, MAT, PNG or JPEG file. Labels that are there only say how often the answer is right.
///
/// Recordings may have any length where the model has learned with a length rule: it applies its own. Under the rule
/// `window` every window has its answer, and `start` says where it begins, in readings of its recording.
///
/// table prints sample, class and probability; csv has a row per sample with every probability; json one object
/// per sample; npz arrays `predicted` [N] ([N, attributes]) and `probabilities` [N, outputs], of windows `recording`
/// and `start` [N] too. Behind a guard `replaced` says which channels or taxels of each sample it took for broken; csv
/// and npz count them.
#[derive(Args)]
#[command(after_help = "Examples:  taxel predict model.safetensors recordings.npz
           taxel predict model.safetensors press.csv
           taxel predict model.safetensors recordings/ --format csv --output answers.csv")]
pub struct Predict {
    /// The model.
    model: PathBuf,
    /// Recordings.
    data: PathBuf,
    /// How answers are written.
    #[arg(long, value_enum, default_value = "table")]
    format: Format,
    /// Where answers go [default: printed]; npz needs it.
    #[arg(long, short)]
    output: Option<PathBuf>,
    #[command(flatten)]
    reading: ReadOptions,
    /// Leaves the model's guard out, if it has one: broken channels and taxels are answered as they read.
    #[arg(long)]
    no_guard: bool,
    /// Caps all threads [default: all cores]; answers do not depend on it.
    #[arg(long)]
    threads: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Format {
    Table,
    Csv,
    Json,
    Npz,
}

/// Answers with what they are about.
struct Answered<'a> {
    origins: &'a [String],
    /// First reading of each, where samples are windows of recordings.
    starts: Option<&'a [usize]>,
    predictions: &'a Predictions,
    /// Right names, where the recordings bear any.
    truth: Option<&'a [Vec<String>]>,
    /// What the guard of the model found.
    mended: Option<&'a Mended>,
}

impl Predict {
    pub fn run(self) -> Outcome {
        if self.format == Format::Npz && self.output.is_none() {
            return Err("npz is no text: name a file with --output".into());
        }
        let model = Model::open(&self.model)?;
        let card = model.card();
        let (Recordings { x, origins, starts, truth, .. }, options) =
            Asked { data: &self.data, reading: &self.reading }.of(card)?;
        let mut predictor = model.predictor(card.batch(), super::threads(self.threads))?;
        if self.no_guard {
            predictor = predictor.guarded(None)?;
        }
        let refuse = |e| format!("{}: {e}", self.data.display());
        let predictions = predictor.predict(&x).map_err(refuse)?;
        let mended = match predictor.guard() {
            Some(guard) => Some(Mended::new(guard.clone(), predictor.found(&x).map_err(refuse)?)),
            None => None,
        };
        let (starts, truth) = (starts.as_deref(), truth.as_deref());
        let mended = mended.as_ref();
        let answered = Answered { origins: &origins, starts, predictions: &predictions, truth, mended };
        self.write(&answered)?;
        if let Some(line) = mended.and_then(Mended::summary) {
            eprintln!("{line}");
        }
        if let Some(line) = answered.score() {
            let seen = if self.was_trained_on(card, options) {
                "; the model was trained on these recordings: of new ones that says nothing"
            } else {
                ""
            };
            eprintln!("{line}{seen}");
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Whether these are the recordings that the model has learned from.
    fn was_trained_on(&self, card: &taxel::Card, options: ReadOptions) -> bool {
        let options = ReadOptions { channels: card.spec.channels.clone(), ..options };
        taxel::load(&self.data, &options).is_ok_and(|dataset| dataset.digest == card.trained_on.digest)
    }

    fn write(&self, answered: &Answered) -> Result<(), Box<dyn std::error::Error>> {
        let text = match self.format {
            Format::Table => answered.table(),
            Format::Csv => answered.csv(),
            Format::Json => answered.json()?,
            Format::Npz => {
                let path = self.output.as_deref().unwrap_or(Path::new("answers.npz"));
                return Ok(write(path, answered.npz())?);
            }
        };
        match &self.output {
            Some(path) => Ok(write(path, Ok(text.into_bytes()))?),
            None => {
                print!("{text}");
                Ok(())
            }
        }
    }
}

impl Answered<'_> {
    fn table(&self) -> String {
        let mut header = vec!["sample".to_string()];
        header.extend(self.starts.map(|_| "start".to_string()));
        for attribute in self.predictions.task.attributes() {
            header.extend([attribute.name, "probability".into()]);
            if self.truth.is_some() {
                header.push("true".into());
            }
        }
        let quantities = self.predictions.task.quantities();
        let values: Vec<String> = quantities.iter().map(with_unit).collect();
        header.extend(values.iter().cloned());
        header.extend(self.mended.map(|_| "replaced".to_string()));
        let row = |i: usize| {
            let mut cells = vec![self.origins[i].clone()];
            cells.extend(self.starts.map(|starts| starts[i].to_string()));
            for (at, answer) in self.predictions.answers(i).into_iter().enumerate() {
                cells.extend([answer.class.to_string(), format!("{:.3}", answer.probability)]);
                cells.extend(self.truth.map(|truth| truth[i].get(at).cloned().unwrap_or_default()));
            }
            cells.extend(self.predictions.values(i).into_iter().map(|(_, value)| format!("{value:.3}")));
            cells.extend(self.mended.map(|mended| mended.words(i)));
            cells
        };
        let rows: Vec<Vec<String>> = (0..self.predictions.len()).map(row).collect();
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        let is_number =
            |name: &str| ["probability", "start"].contains(&name) || values.iter().any(|v| v == name);
        let right: Vec<usize> = (0..header.len()).filter(|i| is_number(header[*i])).collect();
        text::table(&header, &rows, &right)
    }

    fn csv(&self) -> String {
        let task = &self.predictions.task;
        let attributes = task.attributes().into_iter().map(|attribute| attribute.name);
        let has_labels = task.quantities().is_empty();
        let outputs =
            task.output_names().into_iter().map(|name| if has_labels { format!("p({name})") } else { name });
        let start = self.starts.map(|_| "start".to_string());
        let replaced = self.mended.map(|_| "replaced".to_string());
        let columns = start.into_iter().chain(attributes).chain(outputs).chain(replaced);
        let mut grid = columns.fold(Grid::new().left("sample"), Grid::left);
        for i in 0..self.predictions.len() {
            let answers = self.predictions.answers(i);
            let outputs = self.predictions.row(i);
            let cells = answers.iter().map(|answer| answer.class.to_string());
            let start = self.starts.map(|starts| starts[i].to_string());
            let sample = [self.origins[i].clone()].into_iter().chain(start);
            let replaced = self.mended.map(|mended| mended.count(i).to_string());
            grid.row(sample.chain(cells).chain(outputs.iter().map(f32::to_string)).chain(replaced));
        }
        grid.csv()
    }

    fn json(&self) -> serde_json::Result<String> {
        let names = self.predictions.task.output_names();
        let has_labels = self.predictions.task.quantities().is_empty();
        let one = |i: usize| {
            let outputs = self.predictions.row(i).iter().map(|p| json!(p));
            let outputs: serde_json::Map<String, serde_json::Value> =
                names.iter().cloned().zip(outputs).collect();
            let answers = self.predictions.answers(i);
            let classes: serde_json::Map<String, serde_json::Value> =
                answers.iter().map(|answer| (answer.attribute.to_string(), json!(answer.class))).collect();
            let mut answer = if has_labels {
                json!({
                    "sample": self.origins[i], "predicted": classes, "probabilities": outputs,
                    "true": self.truth.map(|truth| &truth[i]),
                })
            } else {
                json!({ "sample": self.origins[i], "predicted": outputs })
            };
            if let Some(starts) = self.starts {
                answer["start"] = json!(starts[i]);
            }
            if let Some(mended) = self.mended {
                answer["replaced"] = mended.json(i);
            }
            answer
        };
        let all = json!({
            "answers": (0..self.predictions.len()).map(one).collect::<Vec<_>>(),
            "accuracy_percent": self.right().map(|(right, of)| 100.0 * right as f64 / of as f64),
        });
        Ok(serde_json::to_string_pretty(&all)? + "\n")
    }

    fn npz(&self) -> std::io::Result<Vec<u8>> {
        let Predictions { task, outputs, labels, .. } = self.predictions;
        let n = self.predictions.len();
        let mut npz = Npz::default();
        let shape = |columns: usize| if columns == 1 { vec![n] } else { vec![n, columns] };
        if task.quantities().is_empty() {
            npz.add("predicted", &shape(labels.len() / n.max(1)), labels)?;
            npz.add("probabilities", &[n, self.predictions.width()], outputs)?;
        } else {
            npz.add("predicted", &shape(self.predictions.width()), outputs)?;
        }
        if let Some(mended) = self.mended {
            let replaced: Vec<i64> = (0..n).map(|i| mended.count(i) as i64).collect();
            npz.add("replaced", &[n], &replaced)?;
        }
        if let Some(starts) = self.starts {
            let starts: Vec<i64> = starts.iter().map(|start| *start as i64).collect();
            npz.add("start", &[n], &starts)?;
            npz.add("recording", &[n], &self.recordings())?;
        }
        npz.finish()
    }

    /// Number of each window's recording, in the order of the recordings.
    fn recordings(&self) -> Vec<i64> {
        let mut number = 0;
        let next = |i: usize| {
            let starts = self.starts.is_none_or(|starts| starts[i] == 0);
            number += i64::from(i > 0 && (starts || self.origins[i] != self.origins[i - 1]));
            number
        };
        (0..self.origins.len()).map(next).collect()
    }

    /// Answers that are right, of those whose true names the model knows.
    fn right(&self) -> Option<(usize, usize)> {
        let truth = self.truth?;
        let known = |own: &taxel::Attribute, name: &String| own.classes.contains(name);
        let (mut right, mut of) = (0, 0);
        let attributes = self.predictions.task.attributes();
        for (i, names) in truth.iter().enumerate() {
            for ((answer, own), name) in self.predictions.answers(i).iter().zip(&attributes).zip(names) {
                of += usize::from(known(own, name));
                right += usize::from(known(own, name) && answer.class == name);
            }
        }
        (of > 0).then_some((right, of))
    }

    fn score(&self) -> Option<String> {
        let truth = self.truth.filter(|_| self.predictions.task.quantities().is_empty())?;
        let all: usize = truth.iter().map(Vec::len).sum();
        Some(match self.right() {
            None => "the labels are no classes of the model: nothing is scored".into(),
            Some((right, of)) => {
                let share = 100.0 * right as f64 / of as f64;
                let (right, count) = (thousands(right as u64), thousands(of as u64));
                let foreign = if of < all {
                    format!("; {} labels are no classes of the model", all - of)
                } else {
                    String::new()
                };
                format!("{right} of {count} right ({share:.2} %){foreign}")
            }
        })
    }
}

/// Returns the name of a quantity with its unit: `force (N)`.
fn with_unit(quantity: &taxel::data::Quantity) -> String {
    let unit = quantity.unit.as_ref().map_or(String::new(), |unit| format!(" ({unit})"));
    format!("{}{unit}", quantity.name)
}
