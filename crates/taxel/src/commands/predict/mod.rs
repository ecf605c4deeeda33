//! `taxel predict`: the predictions of a model for new recordings.

mod explain;
mod guard;
pub mod true_values;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum, ValueHint};
use serde_json::json;
use taxel::base::{Grid, thousands};
use taxel::data::{Npz, Recordings};
use taxel::learn::certainty::AnswerSet;
use taxel::learn::metrics::Levels;
use taxel::{Model, Predictions, ReadOptions};

use explain::Explained;
use guard::Replaced;
use true_values::{TrueValues, with_unit};

use crate::CommandResult;
use crate::arrays::write;
use crate::commands::arguments::certainty::{CertaintyOptions, UNKNOWN, set_of};
use crate::commands::arguments::model_recordings::ModelRecordings;
use crate::commands::arguments::threads::Threads;
use crate::out;
use crate::terminal::messages::{note, warn};
use crate::terminal::tables;

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

/// Predictions with the samples that they belong to.
struct SamplePredictions<'a> {
    origins: &'a [String],
    /// First time step of each, where samples are windows of recordings.
    starts: Option<&'a [usize]>,
    predictions: &'a Predictions,
    /// Names of the true classes, where the recordings have labels.
    truth: Option<&'a [Vec<String>]>,
    /// The true values, where the recordings have some.
    values: Option<&'a TrueValues>,
    /// Broken channels and taxels that the guard of the model replaced.
    replaced: Option<&'a Replaced>,
    /// The parts that each rests on, where that is asked for.
    explained: Option<&'a Explained>,
    /// Whether the probabilities were fitted to held-out predictions.
    is_calibrated: bool,
    /// The familiarity up to which a sample is unknown to the model.
    unknown: f32,
    /// Sets of classes, where they are asked for.
    sets: Option<&'a AnswerSet>,
    /// Share of samples whose intervals hold the true values; none without intervals.
    interval: Option<f64>,
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

impl SamplePredictions<'_> {
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
        let interval = self.interval.map(|share| format!("{:.0} % interval", 100.0 * share));
        let truth = self.values.map(|_| "true".to_string());
        let of_quantity =
            |quantity| [Some(with_unit(quantity)), interval.clone(), truth.clone()].into_iter().flatten();
        let values: Vec<String> = quantities.iter().flat_map(of_quantity).collect();
        header.extend(self.familiarity().map(|_| "familiarity".to_string()));
        header.extend(self.sets.map(|sets| format!("{:.0} % set", 100.0 * sets.share)));
        header.extend(values.iter().cloned());
        header.extend(self.replaced.map(|_| "replaced".to_string()));
        let row = |i: usize| {
            let mut cells = vec![self.origins[i].clone()];
            cells.extend(self.starts.map(|starts| starts[i].to_string()));
            for (at, predicted) in self.predictions.predicted(i).into_iter().enumerate() {
                let class = if self.is_unknown(i) {
                    format!("{UNKNOWN} (like {})", predicted.class)
                } else {
                    predicted.class.to_string()
                };
                cells.extend([class, format!("{:.3}", predicted.probability)]);
                cells.extend(self.truth.map(|truth| truth[i].get(at).cloned().unwrap_or_default()));
            }
            cells.extend(self.familiarity().map(|all| format!("{:.2}", all[i])));
            cells.extend(self.sets.map(|sets| self.set_words(sets, i)));
            let ends = self.ends(i).unwrap_or_default();
            for (at, (_, value)) in self.predictions.values(i).into_iter().enumerate() {
                let is_unknown = self.is_unknown(i);
                cells.push(if is_unknown {
                    format!("{UNKNOWN} ({value:.3})")
                } else {
                    format!("{value:.3}")
                });
                let interval = |[low, high]: &[f32; 2]| {
                    // No share of intervals holds for a sample that is unlike those that they were fitted to.
                    if is_unknown { "–".to_string() } else { format!("{low:.3} to {high:.3}") }
                };
                cells.extend(ends.get(at).map(interval));
                cells.extend(self.values.map(|values| values.cell(i, at)));
            }
            cells.extend(self.replaced.map(|replaced| replaced.words(i)));
            cells
        };
        let rows: Vec<Vec<String>> = (0..self.predictions.len()).map(row).collect();
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        let is_number = |name: &str| {
            ["probability", "start", "familiarity"].contains(&name) || values.iter().any(|v| v == name)
        };
        let right: Vec<usize> = (0..header.len()).filter(|i| is_number(header[*i])).collect();
        tables::table(&header, &rows, &right) + &self.explanation()
    }

    /// Says what each prediction rests on, below the table.
    fn explanation(&self) -> String {
        let Some(explained) = self.explained else { return String::new() };
        let one = |i: usize| format!("\n{}: what changes\n{}", self.origins[i], explained.words(i));
        (0..self.predictions.len()).map(one).collect()
    }

    fn csv(&self) -> String {
        let task = &self.predictions.task;
        let attributes = task.attributes().into_iter().map(|attribute| attribute.name);
        let has_labels = task.quantities().is_empty();
        let outputs =
            task.output_names().into_iter().map(|name| if has_labels { format!("p({name})") } else { name });
        let quantities = task.quantities().iter().filter(|_| self.interval.is_some());
        let ends =
            quantities.flat_map(|quantity| ["low", "high"].map(|end| format!("{}_{end}", quantity.name)));
        let outputs = outputs.chain(ends);
        let start = self.starts.map(|_| "start".to_string());
        let likeliest =
            self.predictions.task.attributes().into_iter().filter(|_| self.familiarity().is_some());
        let likeliest = likeliest.map(|attribute| format!("likeliest {}", attribute.name));
        let familiarity = self.familiarity().map(|_| "familiarity".to_string());
        let unknown = self.familiarity().filter(|_| !has_labels).map(|_| UNKNOWN.to_string());
        let familiarity = familiarity.into_iter().chain(unknown);
        let set = self.sets.map(|_| "set".to_string());
        let replaced = self.replaced.map(|_| "replaced".to_string());
        let columns = start.into_iter().chain(attributes).chain(outputs).chain(likeliest);
        let columns = columns.chain(familiarity).chain(set).chain(replaced);
        let mut grid = columns.fold(Grid::new().left("sample"), Grid::left);
        for i in 0..self.predictions.len() {
            let predicted = self.predictions.predicted(i);
            let outputs = self.predictions.row(i);
            let class = |class: &str| if self.is_unknown(i) { UNKNOWN.into() } else { class.to_string() };
            let cells = predicted.iter().map(|one| class(one.class));
            let likeliest = predicted.iter().filter(|_| self.familiarity().is_some());
            let likeliest = likeliest.map(|one| one.class.to_string());
            let familiarity = self.familiarity().map(|all| all[i].to_string());
            let unknown = self.familiarity().filter(|_| !has_labels).map(|_| self.is_unknown(i).to_string());
            let familiarity = familiarity.into_iter().chain(unknown);
            let set = self.sets.map(|sets| self.set_words(sets, i));
            let start = self.starts.map(|starts| starts[i].to_string());
            let sample = [self.origins[i].clone()].into_iter().chain(start);
            let replaced = self.replaced.map(|replaced| replaced.count(i).to_string());
            let ends = self.ends(i).unwrap_or_default().concat();
            let end = |end: &f32| if self.is_unknown(i) { String::new() } else { end.to_string() };
            let outputs = outputs.iter().map(f32::to_string).chain(ends.iter().map(end));
            let cells = sample.chain(cells).chain(outputs).chain(likeliest);
            grid.row(cells.chain(familiarity).chain(set).chain(replaced));
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
            let predicted = self.predictions.predicted(i);
            let is_unknown = self.is_unknown(i);
            let named =
                |class: &dyn Fn(&str) -> serde_json::Value| -> serde_json::Map<String, serde_json::Value> {
                    predicted.iter().map(|one| (one.attribute.to_string(), class(one.class))).collect()
                };
            let classes = named(&|class| if is_unknown { json!(UNKNOWN) } else { json!(class) });
            let mut sample = if has_labels {
                json!({
                    "sample": self.origins[i], "predicted": classes, "probabilities": outputs,
                    "true": self.truth.map(|truth| &truth[i]),
                })
            } else {
                json!({ "sample": self.origins[i], "predicted": outputs })
            };
            if let Some(ends) = self.ends(i).filter(|_| !is_unknown) {
                let named = names.iter().cloned().zip(ends.into_iter().map(|ends| json!(ends)));
                sample["interval"] = named.collect::<serde_json::Map<_, _>>().into();
            }
            if let Some(values) = self.values {
                sample["true"] = json!(values.of(i));
            }
            if is_unknown && has_labels {
                sample["likeliest"] = named(&|class| json!(class)).into();
            }
            if let Some(familiarity) = self.familiarity() {
                sample["familiarity"] = json!(as_printed(familiarity[i]));
                if !has_labels {
                    sample[UNKNOWN] = json!(is_unknown);
                }
            }
            if let Some(sets) = self.sets {
                sample["set"] = self.set_names(sets, i).into_iter().collect::<serde_json::Value>();
            }
            if let Some(starts) = self.starts {
                sample["start"] = json!(starts[i]);
            }
            if let Some(replaced) = self.replaced {
                sample["replaced"] = replaced.json(i);
            }
            if let Some(explained) = self.explained {
                sample["rests_on"] = explained.json(i);
            }
            sample
        };
        let all = json!({
            "answers": (0..self.predictions.len()).map(one).collect::<Vec<_>>(),
            "calibrated": self.is_calibrated,
            "interval_share": self.interval,
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
            if let Some(share) = self.interval {
                let of_sample = |i: usize| {
                    let is_unknown = self.is_unknown(i);
                    let ends = self.ends(i).unwrap_or_default().into_iter().flatten();
                    ends.map(move |end| if is_unknown { f32::NAN } else { end })
                };
                let ends: Vec<f32> = (0..n).flat_map(of_sample).collect();
                npz.add("interval", &[n, self.predictions.width(), 2], &ends)?;
                npz.add("interval_share", &[], &[share])?;
            }
        }
        if let Some(familiarity) = self.familiarity() {
            npz.add("familiarity", &[n], familiarity)?;
            let unknown: Vec<bool> = (0..n).map(|i| self.is_unknown(i)).collect();
            npz.add("unknown", &[n], &unknown)?;
        }
        if let Some(sets) = self.sets {
            let held = (0..n).flat_map(|i| self.set_mask(sets, i)).collect::<Vec<bool>>();
            npz.add("set", &[n, self.predictions.width()], &held)?;
            npz.add("set_share", &[], &[sets.share])?;
        }
        if let Some(replaced) = self.replaced {
            let replaced: Vec<i64> = (0..n).map(|i| replaced.count(i) as i64).collect();
            npz.add("replaced", &[n], &replaced)?;
        }
        if let Some(starts) = self.starts {
            let starts: Vec<i64> = starts.iter().map(|start| *start as i64).collect();
            npz.add("start", &[n], &starts)?;
            npz.add("recording", &[n], &self.recordings())?;
        }
        npz.finish()
    }

    /// Returns the ends of the intervals of a sample.
    fn ends(&self, i: usize) -> Option<Vec<[f32; 2]>> {
        self.predictions.intervals(i, self.interval?)
    }

    fn familiarity(&self) -> Option<&Vec<f32>> {
        self.predictions.familiarity.as_ref()
    }

    fn is_unknown(&self, i: usize) -> bool {
        self.predictions.is_unknown(i, self.unknown)
    }

    /// Returns each attribute with the classes in the set of a sample.
    fn set_classes(&self, sets: &AnswerSet, i: usize) -> Vec<(taxel::Attribute, Vec<usize>)> {
        let task = &self.predictions.task;
        let classes = set_of(sets, self.predictions.row(i), &Levels::of_task(task), self.is_unknown(i));
        task.attributes().into_iter().zip(classes).collect()
    }

    /// Returns the names of the classes in the set of a sample, with the name of each attribute.
    fn set_names(&self, sets: &AnswerSet, i: usize) -> Vec<(String, Vec<String>)> {
        let names = |(attribute, set): (taxel::Attribute, Vec<usize>)| {
            (attribute.name, set.into_iter().map(|class| attribute.classes[class].clone()).collect())
        };
        self.set_classes(sets, i).into_iter().map(names).collect()
    }

    /// Returns of every output whether the set of a sample has its class.
    fn set_mask(&self, sets: &AnswerSet, i: usize) -> Vec<bool> {
        let of = |(attribute, set): (taxel::Attribute, Vec<usize>)| {
            (0..attribute.classes.len()).map(move |class| set.contains(&class))
        };
        self.set_classes(sets, i).into_iter().flat_map(of).collect()
    }

    fn set_words(&self, sets: &AnswerSet, i: usize) -> String {
        let joined = |(_, set): (String, Vec<String>)| set.join(" | ");
        self.set_names(sets, i).into_iter().map(joined).collect::<Vec<_>>().join("; ")
    }

    /// Returns the number of each window's recording, in the order of the recordings.
    fn recordings(&self) -> Vec<i64> {
        let mut number = 0;
        let next = |i: usize| {
            let starts = self.starts.is_none_or(|starts| starts[i] == 0);
            number += i64::from(i > 0 && (starts || self.origins[i] != self.origins[i - 1]));
            number
        };
        (0..self.origins.len()).map(next).collect()
    }

    /// Counts the right predictions, and all whose true names the model knows.
    fn right(&self) -> Option<(usize, usize)> {
        let truth = self.truth?;
        let knows = |attribute: &taxel::Attribute, name: &String| attribute.classes.contains(name);
        let (mut right, mut of) = (0, 0);
        let attributes = self.predictions.task.attributes();
        for (i, names) in truth.iter().enumerate() {
            for ((predicted, attribute), name) in
                self.predictions.predicted(i).iter().zip(&attributes).zip(names)
            {
                of += usize::from(knows(attribute, name));
                right += usize::from(knows(attribute, name) && predicted.class == name);
            }
        }
        (of > 0).then_some((right, of))
    }

    fn score(&self) -> Option<String> {
        if let Some(values) = self.values {
            return values.score(self.predictions);
        }
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
                let unknown = (0..self.predictions.len()).filter(|i| self.is_unknown(*i)).count();
                let refused = match unknown {
                    0 => String::new(),
                    some => format!("; {some} are unknown to the model, and count by their likeliest class"),
                };
                format!("{right} of {count} right ({share:.2} %){refused}{foreign}")
            }
        })
    }
}

/// Returns the number whose digits a float prints; in double precision it would show others behind them.
fn as_printed(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
