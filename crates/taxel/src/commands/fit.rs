//! `taxel fit`: one network trained on all recordings, as a file to ship.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use taxel::IndicatifProgress;
use taxel::experiment::{Runner, settings};
use taxel::judge::{Case, Criteria, choose};
use taxel::learn::Score;
use taxel::{Dataset, Experiment, Overrides, ReadOptions, Registry, RunFolder, RunOptions};

use crate::Outcome;
use crate::commands::interrupt::{INTERRUPTED, flag};
use crate::commands::judging::judgement;
use crate::commands::reading::with_option_hint;

/// Trains one network, or baseline, on all recordings and writes it as a model: one file that says all about
/// itself, for `taxel predict` and `taxel inspect`.
///
/// From a run folder it is the network that `taxel choose` names, unless --network names another, and the model
/// carries the cross-validated score of the run. From a config it is the one that --network names; nothing is
/// scored then. Ctrl-C saves the training: the same command goes on with it.
#[derive(Args)]
#[command(after_help = "Examples:  taxel fit runs/quickstart --output hardness.safetensors
           taxel fit runs/glove --network resnet8-lite-1d --output glove.safetensors
           taxel fit configs/quickstart.toml --network mlp --output mlp.safetensors")]
pub struct Fit {
    /// A run folder, or an experiment file.
    from: PathBuf,
    /// The network or baseline, by the name that tables give it.
    #[arg(long)]
    network: Option<String>,
    /// Recordings in place of those of the run or config.
    #[arg(long)]
    data: Option<PathBuf>,
    #[command(flatten)]
    reading: ReadOptions,
    /// Where the model goes, `.safetensors`.
    #[arg(long, short)]
    output: PathBuf,
    /// Uses the values of the config's [quick] table.
    #[arg(long)]
    quick: bool,
    /// A config value by its dotted key: train.epochs=20.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Puts a guard before the model, as encoding.guard = true in the config: it finds broken channels and taxels of raw
    /// recordings and replaces what they read by what the training recordings expect.
    #[arg(long)]
    guard: bool,
    /// A seed in place of the config's.
    #[arg(long)]
    seed: Option<u64>,
    /// Seconds between two savings of the training [default: 10].
    #[arg(long, value_name = "SECONDS")]
    save_every: Option<f64>,
    /// Prints the model's card as JSON.
    #[arg(long)]
    json: bool,
    /// Caps all threads [default: all cores]; the model does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
}

/// What is trained.
struct Work {
    experiment: Experiment,
    dataset: Dataset,
    /// Name of the network or baseline.
    name: String,
    /// What a run measured of it.
    score: Option<Score>,
    /// Whether the model is wanted in eight bits.
    quantized: bool,
}

impl Fit {
    pub fn run(self) -> Outcome {
        let cancel = flag()?;
        let registry = Registry::built_in();
        if self.output.extension().is_none_or(|e| e != "safetensors") {
            return Err(format!("{}: a model is a .safetensors file", self.output.display()).into());
        }
        let Work { experiment, dataset, name, score, quantized } = match self.from.is_dir() {
            true => self.of_run(&registry)?,
            false => self.of_config(&registry)?,
        };
        let runner = Runner { experiment: &experiment, registry: &registry, dataset: &dataset };
        let threads = Some(super::threads(self.threads));
        let save_every = self.save_every;
        let options = RunOptions { resume: true, threads, save_every, ..RunOptions::default() };
        let session = self.session(&experiment, &dataset, &name);
        let model = runner.fit(&name, &options, Some(&session), &IndicatifProgress::default(), &cancel)?;
        let Some(model) = model else {
            match session.is_file() {
                true => eprintln!("stopped; the same command goes on with {}", session.display()),
                false => eprintln!("stopped before anything was saved; the same command begins again"),
            }
            return Ok(ExitCode::from(INTERRUPTED));
        };
        let model = if quantized { model.quantized(&dataset.x, &dataset.digest)? } else { model };
        let model = model.with_score(score);
        model.save(&self.output)?;
        taxel::learn::forget(&session)?;
        match self.json {
            true => println!("{}", serde_json::to_string_pretty(model.card())?),
            false => {
                print!("{}", model.card());
                println!("model        {}", self.output.display());
            }
        }
        Ok(ExitCode::SUCCESS)
    }

    fn overrides(&self) -> Overrides {
        let guard = self.guard.then(|| "encoding.guard=true".to_string());
        let set = self.set.iter().cloned().chain(settings(&self.reading)).chain(guard).collect();
        Overrides { quick: self.quick, set, data: self.data.clone(), seed: self.seed, place: None }
    }

    /// The network of an experiment file that --network names.
    fn of_config(&self, registry: &Registry) -> Result<Work, Box<dyn std::error::Error>> {
        let experiment = Experiment::load(&self.from, &self.overrides(), registry)?;
        let config = experiment.config();
        let name = match (&self.network, config.networks.as_slice()) {
            (Some(name), _) => name.clone(),
            (None, [one]) => one.label.clone(),
            (None, several) => {
                let labels: Vec<&str> = several.iter().map(|own| own.label.as_str()).collect();
                let file = self.from.display();
                return Err(format!(
                    "{file} has {}; name one with --network, or run it first and fit from the run folder",
                    labels.join(", ")
                )
                .into());
            }
        };
        let dataset = experiment.dataset().map_err(|e| with_option_hint(e, None))?;
        Ok(Work { dataset, experiment, name, score: None, quantized: false })
    }

    /// The network of a run that is named, or that suffices.
    fn of_run(&self, registry: &Registry) -> Result<Work, Box<dyn std::error::Error>> {
        let folder = RunFolder::open(&self.from)?;
        let results = folder.results()?;
        let row = match &self.network {
            Some(name) => name.clone(),
            None => self.chosen(&folder, registry)?,
        };
        // Of a learning curve the row with the most samples stands for its network.
        let of = |own: &&taxel::learn::NetworkResults| own.network == row || own.candidate == row;
        let own = results.networks.iter().filter(of).max_by_key(|own| own.per_class);
        // In eight bits it is trained in floats.
        let floats = own.and_then(|own| own.quantized.as_ref());
        let trained = floats.and_then(|row| results.networks.iter().find(|own| own.network == *row)).or(own);
        let name = trained.map_or(row.clone(), |own| own.candidate.clone());
        let overrides = self.overrides();
        let experiment = Experiment::load(&folder.file("config.toml"), &overrides, registry)?;
        let dataset = experiment.dataset().map_err(|e| with_option_hint(e, None))?;
        // What was chosen has been checked already.
        if self.network.is_some() && overrides == Overrides::default() {
            folder.finished(&dataset)?;
        }
        // A score belongs to the recordings and the recipe that it was measured with.
        let same = dataset.digest == results.data_digest && !self.quick && self.set.is_empty() && !self.guard;
        let score = own.filter(|_| same).and_then(|own| results.score(&own.network));
        let quantized = floats.is_some();
        Ok(Work { experiment, dataset, name, score, quantized })
    }

    fn chosen(&self, folder: &RunFolder, registry: &Registry) -> Result<String, Box<dyn std::error::Error>> {
        let (_, dataset) = taxel::experiment::open(folder, registry)?;
        let case = Case::new(folder.clone(), dataset)?;
        let judgement = judgement(&case, None)?;
        let choice = choose(&case, &judgement, &Criteria::default())?;
        choice.words.iter().for_each(|line| eprintln!("{line}"));
        choice.chosen.ok_or_else(|| {
            format!("{}: no network suffices; name one with --network", self.from.display()).into()
        })
    }

    /// Where the training is saved: another training has another file.
    fn session(&self, experiment: &Experiment, dataset: &Dataset, name: &str) -> PathBuf {
        let what = format!("{}\n{}\n{name}", experiment.to_toml(), dataset.digest);
        let key = &blake3::hash(what.as_bytes()).to_hex()[..12];
        let stem = self.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.output.parent().unwrap_or(Path::new("")).join(format!(".{stem}.{key}.session.safetensors"))
    }
}
