//! The samples of an experiment: simulated or recorded.

use taxel_data::{
    Attribute, Dataset, Labels, Quantity, SampleSpec, Source, TargetNames, Targets, hash_words,
};
use taxel_learn::Problem;
use taxel_scenes::Scene;
use toml::Value;

use crate::data::{Data, Origin, SceneOrigin};
use crate::error::{Error, Result};
use crate::experiment::Experiment;

/// True values of simulated samples by name.
type TrueValues = Vec<(String, Vec<f32>)>;

impl Experiment {
    /// Simulates or reads what the `[data]` table names.
    ///
    /// # Errors
    /// An environment variable that is not set, a data set that cannot be read, a scene that cannot
    /// be simulated.
    pub fn dataset(&self) -> Result<Dataset> {
        let Data { full_scale, layout, rate, each_frame, attributes, classes, .. } = &self.config().data;
        let mut dataset = match &self.config().data.origin {
            Origin::Scene(scene) => self.simulated_samples(scene, attributes)?,
            Origin::Recordings(recordings) => {
                if self.config().protocol.worlds().is_some() {
                    let reason = "simulates a new world for each repetition, and data.path names recordings; use \"k-fold\"";
                    return Err(self.refuse(Problem::new("protocol.kind", "\"fresh\"", reason)));
                }
                let path = self.recordings_path(recordings)?;
                let options = recordings.options(*layout, *rate, attributes);
                taxel_data::load(&path, &options).map_err(|e| self.of_attributes(attributes, e))?
            }
        };
        // Where nobody states the layout, the encodings imply it.
        let implied = self.config().encoding.layout(&dataset.spec.shape).filter(|_| !each_frame);
        let layout =
            layout.or(implied.filter(|_| matches!(self.config().data.origin, Origin::Recordings(_))));
        if let Some(layout) = layout {
            // The length rule was applied along the axis that the reader took for time.
            if dataset.spec.length.is_some() && layout.time_axis() != dataset.spec.layout.time_axis() {
                let reason =
                    format!("data.length needs it: say data.layout = \"{layout}\", as the encodings take it");
                return Err(self.refuse(Problem::new("data.layout", "left out", reason)));
            }
            dataset.set_layout(layout)?;
        }
        if let Some(full) = full_scale {
            let refuse = |error: taxel_data::Error| {
                let reason = match error {
                    taxel_data::Error::Fact { wanted, .. } => wanted,
                    other => other.to_string(),
                };
                Problem::new("data.full_scale", full.to_string(), reason)
            };
            dataset.set_full_scale(*full as f32).map_err(|e| self.refuse(refuse(e)))?;
        }
        // Of recordings the reader knows it, and what a length rule makes of it.
        if let (Some(rate), Origin::Scene(_)) = (rate, &self.config().data.origin) {
            dataset.spec.rate = Some(*rate);
        }
        if *each_frame {
            dataset = dataset
                .each_frame()
                .map_err(|e| self.refuse(Problem::new("data.each_frame", "true", e.to_string())))?;
        }
        if let Some(classes) = classes {
            dataset.keep_classes(classes).map_err(|e| {
                self.refuse(Problem::new("data.classes", format!("{classes:?}"), e.to_string()))
            })?;
        }
        self.config().encoding.seek_copies(&mut dataset).map_err(|error| self.located(error))?;
        Ok(dataset)
    }

    /// Simulates what a scene's table asks for: one world, or those of the protocol.
    fn simulated_samples(&self, origin: &SceneOrigin, attributes: &[String]) -> Result<Dataset> {
        let SceneOrigin { scene: name, samples, without, .. } = origin;
        let settings = taxel_scenes::Settings::read(name, Value::Table(self.scene_settings(origin)?))?;
        let seed = self.config().seed;
        let (truth, mut dataset) = match self.config().protocol.worlds() {
            None => {
                let mut scene = settings.simulate(*samples, seed, without)?;
                (std::mem::take(&mut scene.truth), simulated(name, without, scene))
            }
            Some((worlds, parts)) => {
                let world = |number: usize| {
                    let seed = taxel_base::seed::derived(seed, &format!("world/{number}"));
                    settings.simulate(parts[0] + parts[1], seed, without)
                };
                let worlds = (0..worlds).map(world).collect::<taxel_scenes::Result<Vec<_>>>()?;
                self.refuse_other_marks(&worlds, parts)?;
                fresh_worlds(name, without, worlds, parts).ok_or_else(|| {
                    let reason = "worlds of this scene have samples of several shapes";
                    self.refuse(Problem::new("protocol.kind", "\"fresh\"", reason))
                })?
            }
        };
        for (effect, factor) in settings.factors() {
            dataset.source.name += &format!(" with {factor} of {effect}");
        }
        if let Some(names) = &origin.y {
            return self.with_truth(dataset, name, &truth, names);
        }
        dataset.learn_attributes(attributes).map_err(|e| self.of_attributes(attributes, e))?;
        Ok(dataset)
    }

    /// Refuses a scene that marks other samples for testing than the protocol tests.
    fn refuse_other_marks(&self, worlds: &[Scene], [train, test]: [usize; 2]) -> Result<()> {
        let is_other = |scene: &Scene| {
            let Some(marks) = &scene.test else { return false };
            marks.iter().enumerate().any(|(row, mark)| *mark != (row >= train))
        };
        if !worlds.iter().any(is_other) {
            return Ok(());
        }
        let share = test as f64 / (train + test) as f64;
        let reason = format!("marks other samples for testing than protocol.test; say unseen = {share}");
        Err(self.refuse(Problem::new("data.set.unseen", "..", reason)))
    }

    /// Puts true values of the simulated samples in the place of their classes.
    fn with_truth(
        &self,
        dataset: Dataset,
        scene: &str,
        truth: &[(String, Vec<f32>)],
        names: &TargetNames,
    ) -> Result<Dataset> {
        let (mut quantities, mut columns) = (vec![], vec![]);
        for name in names.each() {
            let Some((_, values)) = truth.iter().find(|(known, _)| known == name) else {
                let hint = taxel_base::names::hint(name, truth.iter().map(|(known, _)| known.as_str()));
                let reason = format!("is no true value of scene {scene}; {hint}");
                return Err(self.refuse(Problem::new("data.y", format!("{name:?}"), reason)));
            };
            quantities.push(quantity(name));
            columns.push(values);
        }
        let row = |at: usize| columns.iter().map(move |column| column[at]);
        let values = (0..dataset.len()).flat_map(row).collect();
        let refuse = |e: taxel_data::Error| {
            self.refuse(Problem::new("data.y", format!("{:?}", names.each()), e.to_string()))
        };
        dataset.with_values(quantities, values).map_err(refuse)
    }

    /// Adds the key of the attributes to an error about them.
    fn of_attributes(&self, attributes: &[String], error: taxel_data::Error) -> Error {
        match error {
            taxel_data::Error::LearnAttributes { .. } => {
                self.refuse(Problem::new("data.attributes", format!("{attributes:?}"), error.to_string()))
            }
            other => other.into(),
        }
    }
}

/// Returns the quantity of a true value of a scene, with its unit.
pub fn quantity(name: &str) -> Quantity {
    let (name, unit) = taxel_scenes::quantity_of(name);
    Quantity { name: name.into(), unit: unit.map(String::from) }
}

/// Makes a data set of simulated samples of the scene `name` without some of its effects.
pub fn simulated(name: &str, without: &[String], scene: Scene) -> Dataset {
    let digest = digest(&scene);
    let left_out = match without {
        [] => String::new(),
        names => format!(" without {}", names.join(", ")),
    };
    let columns = scene.attributes.as_ref().map(|attributes| {
        let named = attributes.class_names.iter().enumerate();
        let named = named
            .map(|(i, classes)| Attribute { name: format!("attribute-{i}"), classes: classes.clone() })
            .collect();
        Labels::new(named, attributes.y.iter().copied().collect())
    });
    Dataset {
        name: name.into(),
        source: Source::simulated(format!("{name}{left_out}")),
        spec: SampleSpec {
            unit: Some(scene.unit.to_string()),
            full_scale: Some(scene.full_scale),
            rest: Some(scene.rest),
            ..SampleSpec::new(scene.layout, &scene.x.shape()[1..])
        },
        targets: Targets::Classes {
            labels: Labels::of_classes(&scene.class_names, &scene.y),
            columns,
            steps: None,
        },
        official: scene.test,
        groups: Some(scene.group),
        group_name: None,
        weights: None,
        units: None,
        origins: (0..scene.y.len()).map(|i| format!("{name}[{i}]")).collect(),
        x: scene.x,
        dropped: vec![],
        warnings: vec![],
        row_hash: vec![],
        dtype: "f32".into(),
        digest,
    }
}

/// Joins worlds to one data set: each is a group, whose last recordings are marked for testing.
fn fresh_worlds(
    name: &str,
    without: &[String],
    worlds: Vec<Scene>,
    [train, test]: [usize; 2],
) -> Option<(TrueValues, Dataset)> {
    let rows = worlds.len() * (train + test);
    let mut scene = Scene::joined(worlds)?;
    let truth = std::mem::take(&mut scene.truth);
    let mut dataset = simulated(name, without, scene);
    dataset.official = Some((0..rows).map(|row| row % (train + test) >= train).collect());
    dataset.group_name = Some("world".into());
    Some((truth, dataset))
}

/// Returns the BLAKE3 hash of shape, values, labels and groups.
fn digest(scene: &Scene) -> String {
    let mut hasher = blake3::Hasher::new();
    for axis in scene.x.shape() {
        hasher.update(&(*axis as u64).to_le_bytes());
    }
    hash_words(&mut hasher, scene.x.iter().map(|v| v.to_le_bytes()));
    hash_words(&mut hasher, scene.y.iter().chain(&scene.group).map(|v| v.to_le_bytes()));
    if let Some(attributes) = &scene.attributes {
        hash_words(&mut hasher, attributes.y.iter().map(|v| v.to_le_bytes()));
    }
    hasher.finalize().to_hex().to_string()
}

/// Simulates a scene by its name, with its default settings.
///
/// # Errors
/// No such scene, or no samples asked for.
pub fn simulate(scene: &str, samples: usize, seed: u64, without: &[String]) -> Result<Dataset> {
    Ok(simulated(scene, without, taxel_scenes::simulate(scene, samples, seed, without)?))
}
