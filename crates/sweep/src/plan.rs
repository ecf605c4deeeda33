//! From a study to its manifest.

use std::collections::{HashMap, HashSet};
use std::io::Write;
use std::path::Path;

use serde_json::{Map, json};
use taxel_learn::{FoldKey, program};
use taxel_trainer::{Experiment, Overrides, Runner};
use taxel_zoo::Registry;

use crate::axes::{Axes, Point};
use crate::error::{Error, Result};
use crate::folder::SweepFolder;
use crate::manifest::write_line;
use crate::samples::{Loader, TrialSamples, data_key};
use crate::study::{Folds, Study, values};
use crate::trial::{DataOf, Trial, TrialFold, fold_identity, hashed, run_identity, toml_of};

/// Counts of a plan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Planned {
    /// Trials of the manifest.
    pub trials: usize,
    /// Points of the axes that are a trial which stands in the manifest already.
    pub duplicates: usize,
}

/// Resolves every trial of `study` and writes the manifest of `folder`, whole or not at all. Trials of an earlier
/// plan keep their identity, and with it their results.
///
/// # Errors
/// A config that a point makes invalid, data that cannot be loaded, a manifest that cannot be written.
pub fn plan(study: &Study, folder: &SweepFolder, registry: &Registry) -> Result<Planned> {
    let axes = Axes::new(study)?;
    std::fs::create_dir_all(folder.path()).map_err(|e| Error::io(folder.path(), "created", e))?;
    let path = folder.manifest();
    let samples = TrialSamples::default();
    let mut planner = Planner {
        study,
        registry,
        path: &path,
        program: program(),
        loader: samples.loader(),
        known: HashMap::new(),
        seen: HashSet::new(),
        planned: Planned::default(),
    };
    taxel_base::files::write_piecewise(&path, |out| {
        for config in study.configs() {
            for at in 0..axes.len() {
                planner.point(&config, axes.point(at), out).map_err(Stop::Own)?;
            }
        }
        Ok(())
    })
    .map_err(|stop| match stop {
        Stop::Io(e) => Error::io(&path, "written", e),
        Stop::Own(error) => error,
    })?;
    Ok(planner.planned)
}

/// An error that ends a plan: of its file, or of a trial.
enum Stop {
    Io(std::io::Error),
    Own(Error),
}

impl From<std::io::Error> for Stop {
    fn from(error: std::io::Error) -> Self {
        Stop::Io(error)
    }
}

struct Planner<'a> {
    study: &'a Study,
    registry: &'a Registry,
    path: &'a Path,
    program: String,
    loader: Loader<'a>,
    /// Samples that were loaded: what says which, their source, digest, and the digest of the facts about them.
    known: HashMap<String, (String, String, String)>,
    seen: HashSet<String>,
    planned: Planned,
}

impl Planner<'_> {
    /// Writes the trials of one point.
    fn point(&mut self, config: &Path, point: Point, out: &mut impl Write) -> Result<()> {
        let fixed = values(&self.study.set);
        let set = fixed.iter().chain(&point).map(|(key, value)| format!("{key}={value}")).collect();
        let place = Some(self.study.file.display().to_string());
        let overrides = Overrides { quick: self.study.quick, set, place, ..Overrides::default() };
        let experiment = Experiment::load(config, &overrides, self.registry)?;
        let text = experiment.to_toml();
        let data = self.data(&experiment)?;
        let run = run_identity(&text, &data, &self.program);
        let whole = Trial {
            identity: run.clone(),
            name: experiment.config().name.clone(),
            set: self.settings(config, point),
            fold: None,
            data,
            program: self.program.clone(),
            config: text,
        };
        if self.study.folds == Folds::Together {
            return self.write(&whole, out);
        }
        let keys = self.keys(&experiment)?;
        for key in &keys {
            let identity = fold_identity(&run, key);
            let fold = Some(TrialFold { run: run.clone(), of: keys.len(), key: key.clone() });
            self.write(&Trial { identity, fold, ..whole.clone() }, out)?;
        }
        Ok(())
    }

    fn write(&mut self, trial: &Trial, out: &mut impl Write) -> Result<()> {
        if !self.seen.insert(trial.identity.clone()) {
            self.planned.duplicates += 1;
            return Ok(());
        }
        self.planned.trials += 1;
        write_line(out, trial).map_err(|e| Error::io(self.path, "written", e))
    }

    /// Returns the varied settings of a trial, for its rows in tables.
    fn settings(&self, config: &Path, point: Point) -> Map<String, serde_json::Value> {
        let mut set = Map::new();
        if self.study.configs().len() > 1 {
            set.insert("config".into(), json!(config.file_stem().unwrap_or_default().to_string_lossy()));
        }
        set.extend(point.into_iter().map(|(key, value)| (key, json!(value))));
        set
    }

    fn data(&mut self, experiment: &Experiment) -> Result<DataOf> {
        let config = experiment.config();
        let key = data_key(config);
        if !self.known.contains_key(&key) {
            let dataset = self.loader.of(experiment)?;
            let facts = dataset.facts().digest();
            self.known.insert(key.clone(), (dataset.source.to_string(), dataset.digest.clone(), facts));
        }
        let (source, digest, facts) = self.known[&key].clone();
        let weights = experiment.weights_digest()?;
        Ok(DataOf { source, digest, facts, weights, set: hashed(&[&toml_of(&config.data)]) })
    }

    fn keys(&mut self, experiment: &Experiment) -> Result<Vec<FoldKey>> {
        let dataset = self.loader.of(experiment)?;
        Ok(Runner { experiment, registry: self.registry, dataset: &dataset }.keys()?)
    }
}
