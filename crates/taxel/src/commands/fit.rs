//! `taxel fit`: one network trained on all recordings, as a file to ship.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::Args;
use taxel::base::files::write_whole;
use taxel::experiment::{Runner, settings};
use taxel::judge::{Case, Judgement, held_out};
use taxel::learn::certainty::{Certainty, HeldOut, HeldOutParts, HeldOutValues, Intervals};
use taxel::learn::metrics::Levels;
use taxel::learn::{FoldRecord, HUB_LIBRARY, Results, Score, Tuning};
use taxel::{Dataset, Experiment, Model, Overrides, ReadOptions, Registry, RunFolder, RunOptions};

use crate::CommandResult;
use crate::commands::arguments::certainty::{USUAL, unpromised};
use crate::commands::arguments::model_recordings::ModelRecordings;
use crate::commands::arguments::option_hints::with_option_hint;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::paths::check_model_output;
use crate::commands::arguments::threads::Threads;
use crate::commands::judging::choice;
use crate::terminal::interrupt::{GRACE, INTERRUPTED, flag};
use crate::terminal::messages::{detail, note, warn};
use crate::terminal::progress::progress;
use crate::{out, outln};

/// Trains one network, or baseline, on all recordings and writes it as a model file to ship.
///
/// The file holds everything that `taxel predict` and `taxel inspect` need. From a run folder it is the network that
/// `taxel choose` names, unless --network names another, and the model carries the cross-validated score of the run. From
/// a config it is the one that --network names, and nothing is scored. Ctrl-C saves the training: the same command goes
/// on with it.
#[derive(Args)]
#[command(after_help = "Examples:  taxel fit runs/quickstart --output hardness.safetensors
           taxel fit runs/glove --network resnet8-lite-1d --output glove.safetensors
           taxel fit configs/quickstart.toml --network mlp --output mlp.safetensors
           taxel fit runs/glove --output hub/glove.safetensors --model-card
           taxel fit ten-presses.npz --from force.safetensors --output new-force.safetensors")]
pub struct Fit {
    /// A run folder, or an experiment file; with --from labelled recordings.
    path: PathBuf,
    /// A model whose network goes on learning, from few recordings of another sensor of its kind. Scaling and batch norm stay.
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["network", "data", "quick", "set", "guard", "no_calibration", "save_every"])]
    from: Option<PathBuf>,
    /// Epochs of every training, here that with --from [default: 300].
    #[arg(long, value_name = "N", requires = "from")]
    epochs: Option<usize>,
    /// The network or baseline, by its name in the tables [default: the one that is chosen].
    #[arg(long, value_name = "NAME")]
    network: Option<String>,
    /// Recordings in place of the config's data.
    #[arg(long, value_name = "DATA")]
    data: Option<PathBuf>,
    #[command(flatten)]
    read_options: ReadOptions,
    /// The model file to write, `.safetensors`.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Uses the values of the config's [quick] table.
    #[arg(long)]
    quick: bool,
    /// A config value by its dotted key: train.epochs=20.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Puts a guard before the model, as encoding.guard = true in the config. It finds broken channels and taxels of raw
    /// recordings and replaces their values by those that the training recordings make likely.
    #[arg(long)]
    guard: bool,
    /// Leaves the probabilities as the method answers by itself, in place of fitting them to the test parts of the run.
    #[arg(long)]
    no_calibration: bool,
    /// Seed of every random choice [default: the config's].
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// The model card of the Hugging Face Hub as well: README.md beside the model, with a head in YAML.
    #[arg(long)]
    model_card: bool,
    /// Seconds between two savings of the training [default: 10].
    #[arg(long, value_name = "SECONDS")]
    save_every: Option<f64>,
    #[command(flatten)]
    format: OutputFormat,
    #[command(flatten)]
    threads: Threads,
}

/// One training: experiment, samples, and the network or baseline by its name.
struct Training {
    experiment: Experiment,
    dataset: Dataset,
    /// Name of the network or baseline.
    name: String,
    /// Cross-validated score of the run, if it belongs to this training.
    score: Option<Score>,
    /// How sure the model may be, by the predictions of the run.
    certainty: Option<Certainty>,
    /// The intervals around its values, by the predictions of the run.
    intervals: Option<Intervals>,
    /// Whether the model is made in eight bits afterwards.
    quantized: bool,
}

impl Fit {
    pub fn run(self) -> CommandResult {
        let cancel = flag(GRACE)?;
        let registry = Registry::built_in();
        check_model_output(&self.output)?;
        self.refuse_page()?;
        if let Some(model) = &self.from {
            return self.tune(&Model::open(model)?, &cancel);
        }
        let training = if self.path.is_dir() { self.of_run(&registry)? } else { self.of_config(&registry)? };
        let Training { experiment, dataset, name, score, certainty, intervals, quantized } = training;
        dataset.warnings.iter().for_each(warn);
        detail(format!("{name} on {} samples, digest {}", dataset.x.shape()[0], dataset.digest));
        let runner = Runner { experiment: &experiment, registry: &registry, dataset: &dataset };
        let threads = Some(self.threads.count()?);
        let save_every = self.save_every;
        let options = RunOptions { resume: true, threads, save_every, ..RunOptions::default() };
        let session = self.session(&experiment, &dataset, &name);
        let model = runner.fit(&name, &options, Some(&session), &*progress(), &cancel)?;
        let Some(model) = model else {
            if session.is_file() {
                note(format!("stopped; the same command goes on with {}", session.display()));
            } else {
                note("stopped before anything was saved; the same command begins again");
            }
            return Ok(ExitCode::from(INTERRUPTED));
        };
        let model = if quantized { model.quantized(&dataset.x, &dataset.digest)? } else { model };
        // What the run measured counts before what the method says of its own samples.
        let own = model.card().certainty.clone();
        let certainty = certainty.or(own).filter(|_| !self.no_calibration);
        let intervals = intervals.or(model.card().intervals.clone()).filter(|_| !self.no_calibration);
        let model = model.with_score(score).with_intervals(intervals);
        let model = match certainty {
            Some(certainty) => model.with_certainty_of(certainty, &dataset)?,
            None => model.with_certainty(None),
        };
        // The share that `predict` and `stream` take where nobody says another.
        unpromised(model.card(), USUAL).iter().for_each(warn);
        let written = self.write(&model)?;
        taxel::learn::forget(&session)?;
        Ok(written)
    }

    /// Trains a model further on labelled recordings.
    fn tune(&self, model: &Model, cancel: &AtomicBool) -> CommandResult {
        let recordings = ModelRecordings { data: &self.path, read_options: &self.read_options, as_is: None };
        let (_, dataset) = recordings.labelled(model.card())?;
        let standard = Tuning::default();
        let tuning = Tuning {
            epochs: self.epochs.unwrap_or(standard.epochs),
            seed: self.seed.unwrap_or(standard.seed),
            options: RunOptions { threads: Some(self.threads.count()?), ..standard.options },
            ..standard
        };
        let progress = progress();
        progress.start(tuning.samples(&dataset) as u64);
        let tuned = tuning.run(model, &dataset, &mut |samples| progress.step(samples as u64), cancel);
        progress.finish();
        let Some(tuned) = tuned? else {
            note("stopped before anything was saved; the same command begins again");
            return Ok(ExitCode::from(INTERRUPTED));
        };
        self.write(&tuned)
    }

    /// Writes a model, and its card to standard output.
    fn write(&self, model: &Model) -> CommandResult {
        model.save(&self.output)?;
        if self.model_card {
            let (path, file) = (self.page(), self.output.file_name().unwrap_or_default().to_string_lossy());
            write_whole(&path, model.card().hub_page(&file).as_bytes())
                .map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
            note(format!("model card: {}", path.display()));
        }
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(model.card())?);
        } else {
            out!("{}", model.card());
            outln!("model        {}", self.output.display());
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Returns where the model card of the Hub is written.
    fn page(&self) -> PathBuf {
        self.output.with_file_name("README.md")
    }

    /// Refuses to write the model card over a page of somebody else's.
    fn refuse_page(&self) -> Result<(), String> {
        let path = self.page();
        let is_own = |text: String| text.lines().take(2).any(|line| line == HUB_LIBRARY);
        if self.model_card && path.exists() && !std::fs::read_to_string(&path).is_ok_and(is_own) {
            let fix = "it is no model card of taxel; leave --model-card out, or write the model elsewhere";
            return Err(format!("{}: is there already, and {fix}", path.display()));
        }
        Ok(())
    }

    fn overrides(&self) -> Overrides {
        let guard = self.guard.then(|| "encoding.guard=true".to_string());
        let set = self.set.iter().cloned().chain(settings(&self.read_options)).chain(guard).collect();
        Overrides { quick: self.quick, set, data: self.data.clone(), seed: self.seed, place: None }
    }

    /// Returns the training of an experiment file: the network that --network names.
    fn of_config(&self, registry: &Registry) -> Result<Training, Box<dyn std::error::Error>> {
        let experiment = Experiment::load(&self.path, &self.overrides(), registry)?;
        let config = experiment.config();
        let name = match (&self.network, config.networks.as_slice()) {
            (Some(name), _) => name.clone(),
            (None, [one]) => one.label.clone(),
            (None, several) => {
                let labels: Vec<&str> = several.iter().map(|network| network.label.as_str()).collect();
                let file = self.path.display();
                return Err(format!(
                    "{file} has {}; name one with --network, or run it first and fit from the run folder",
                    labels.join(", ")
                )
                .into());
            }
        };
        let dataset = experiment.dataset().map_err(|e| with_option_hint(e, None))?;
        Ok(Training {
            dataset,
            experiment,
            name,
            score: None,
            certainty: None,
            intervals: None,
            quantized: false,
        })
    }

    /// Returns the training of a run: the network that is named, or that suffices.
    fn of_run(&self, registry: &Registry) -> Result<Training, Box<dyn std::error::Error>> {
        let folder = RunFolder::open(&self.path)?;
        let results = folder.results()?;
        let row = match &self.network {
            Some(name) => name.clone(),
            None => self.chosen(&folder, registry)?,
        };
        // Of a learning curve the row with the most samples stands for its network.
        let is_row =
            |result: &&taxel::learn::NetworkResults| result.network == row || result.candidate == row;
        let found = results.networks.iter().filter(is_row).max_by_key(|result| result.per_class);
        // In eight bits it is trained in floats.
        let floats = found.and_then(|result| result.quantized.as_ref());
        let trained =
            floats.and_then(|row| results.networks.iter().find(|result| result.network == *row)).or(found);
        let name = trained.map_or(row.clone(), |result| result.candidate.clone());
        let overrides = self.overrides();
        let experiment = Experiment::load(&folder.file("config.toml"), &overrides, registry)?;
        let dataset = experiment.dataset().map_err(|e| with_option_hint(e, None))?;
        // A network that was chosen has been checked already.
        if self.network.is_some() && overrides == Overrides::default() {
            folder.finished(&dataset)?;
        }
        // A score belongs to the recordings and the recipe that it was measured with.
        let same = results.is_of(&dataset) && !self.quick && self.set.is_empty() && !self.guard;
        let score = found.filter(|_| same).and_then(|result| results.score(&result.network));
        let (certainty, intervals) = match found.filter(|_| same && !self.no_calibration) {
            Some(result) => {
                let records = records_of(&folder, &result.network)?;
                let row = (result.network.as_str(), records.as_slice());
                let certainty = self.certainty(&folder, &results, row, &dataset)?;
                (certainty, intervals(&results, row, &dataset))
            }
            None => (None, None),
        };
        if !(same || self.no_calibration) {
            note(
                "the run's test parts calibrate nothing: the model is fitted by another recipe or to other recordings. \
                  taxel calibrate does it on own recordings",
            );
        }
        let quantized = floats.is_some();
        Ok(Training { experiment, dataset, name, score, certainty, intervals, quantized })
    }

    /// Fits how sure a row may be to the predictions of its test parts.
    fn certainty(
        &self,
        folder: &RunFolder,
        results: &Results,
        (row, records): (&str, &[FoldRecord]),
        dataset: &Dataset,
    ) -> Result<Option<Certainty>, Box<dyn std::error::Error>> {
        let Some(held) = HeldOut::of_folds(records, dataset) else { return Ok(None) };
        let parts = HeldOutParts::of(&results.protocol);
        let levels = Levels::of_task(&results.task);
        let certainty = Certainty::fit(&held, &levels, parts, &dataset.digest, results.seed)?;
        let Some(certainty) = certainty else {
            let held = held.len();
            note(format!(
                "the run's test parts calibrate nothing: it has {held} predictions of {row}, and 30 are needed"
            ));
            return Ok(None);
        };
        // What needs the models of the folds, if they are there.
        let case = Case::new(folder.clone(), dataset.clone());
        let threads = self.threads.count()?;
        let found = case.and_then(|case| Ok((held_out(&case, row, threads)?, Judgement::read(&case)?)));
        let (found_held, judgement) = match found {
            Ok(found) => found,
            Err(error) => {
                note(format!(
                    "early decisions are not calibrated, and unknown samples are told by their readings alone: {error}"
                ));
                (None, None)
            }
        };
        let raw = (dataset.spec.layout, &*dataset.x);
        let certainty = match found_held {
            Some(found) => certainty.with_logits(&found.whole, &found.starts, &levels).with_readings(
                &found.whole,
                raw,
                &levels,
            ),
            None => certainty.with_readings(&held, raw, &levels),
        };
        let stress = judgement.and_then(|judgement| judgement.stress);
        let tested = stress.iter().flat_map(|stress| &stress.networks).find(|network| network.network == row);
        Ok(Some(Certainty { under_faults: tested.and_then(|network| network.sure_when_broken), ..certainty }))
    }

    fn chosen(&self, folder: &RunFolder, registry: &Registry) -> Result<String, Box<dyn std::error::Error>> {
        let (_, dataset) = taxel::experiment::open(folder, registry)?;
        let case = Case::new(folder.clone(), dataset)?;
        let choice = choice(&case)?;
        choice.words.iter().for_each(note);
        choice.chosen.ok_or_else(|| {
            format!("{}: no network suffices; name one with --network", self.path.display()).into()
        })
    }

    /// Returns the file that the training is saved in: another training has another one.
    fn session(&self, experiment: &Experiment, dataset: &Dataset, name: &str) -> PathBuf {
        let what =
            format!("{}\n{}\n{}\n{name}", experiment.to_toml(), dataset.digest, dataset.facts().digest());
        let key = &blake3::hash(what.as_bytes()).to_hex()[..12];
        let stem = self.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.output.parent().unwrap_or(Path::new("")).join(format!(".{stem}.{key}.session.safetensors"))
    }
}

/// Reads the records of a row of a run.
fn records_of(folder: &RunFolder, row: &str) -> taxel::learn::Result<Vec<FoldRecord>> {
    let mut records = vec![];
    for key in folder.keys()?.iter().filter(|key| key.network == row) {
        records.extend(folder.record(key)?);
    }
    Ok(records)
}

/// Fits the intervals of a row of values to the errors of its test parts.
fn intervals(
    results: &Results,
    (row, records): (&str, &[FoldRecord]),
    dataset: &Dataset,
) -> Option<Intervals> {
    let held = HeldOutValues::of_folds(records, dataset)?;
    let intervals = Intervals::fit(&held, HeldOutParts::of(&results.protocol), &dataset.digest);
    let raw = (dataset.spec.layout, &*dataset.x);
    let intervals = intervals.map(|intervals| intervals.with_readings(&held, raw));
    if intervals.is_none() {
        let count = held.len();
        note(format!("no intervals: the run has {count} predictions of {row}, and 30 are needed"));
    }
    intervals
}
