//! The samples of an experiment: simulated or recorded, with the label that says which.

use ndarray::ArrayD;
use taxel_data::{Fold, Options, group_k_fold, stratified_k_fold};

use crate::config::{Data, Problem, Split};
use crate::error::Result;
use crate::experiment::Experiment;

/// Labelled samples, all of one shape, as read: nothing is scaled.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// `simulated: <scene>` or `real: <set>`: stands beside every score.
    pub source: String,
    /// Samples `[N, ..]` in the unit of the readings.
    pub x: ArrayD<f32>,
    /// Class of each sample.
    pub y: Vec<u32>,
    /// Class names by label.
    pub classes: Vec<String>,
    /// Group (session, object, block) of each sample.
    pub groups: Option<Vec<u32>>,
    /// What stays in one fold even under a stratified split: exact copies share a number.
    pub units: Option<Vec<u32>>,
    /// The largest possible reading.
    pub full_scale: Option<f32>,
    /// Where each sample comes from: a file, `x[17]`, or `fingertip[17]`.
    pub origins: Vec<String>,
    /// BLAKE3 of values, labels and groups, in hexadecimal.
    pub digest: String,
}

impl Samples {
    /// Simulates or reads what the experiment's `[data]` table names.
    ///
    /// # Errors
    /// An environment variable that is not set, a data set that cannot be read, a scene that cannot
    /// be simulated.
    pub fn load(experiment: &Experiment) -> Result<Self> {
        let config = experiment.config();
        let full_scale = config.data.full_scale.map(|v| v as f32);
        let mut samples = match (&config.data.scene, experiment.data_path()?) {
            (_, Some(path)) => Self::from_dataset(taxel_data::load(&path, &options(&config.data))?),
            (Some(scene), None) => {
                let count = config.data.samples.unwrap_or(1500);
                let name = scene.as_str();
                let scene = taxel_scenes::simulate(name, count, config.seed, &config.data.without)?;
                Self::from_scene(name, &config.data.without, scene)
            }
            (None, None) => {
                let reason = "needs scene = \"..\" or path = \"..\"".into();
                return Err(experiment.refuse(Problem { key: "data".into(), value: "{}".into(), reason }));
            }
        };
        samples.full_scale = full_scale.or(samples.full_scale);
        Ok(samples)
    }

    /// Samples of a data set on disk.
    pub fn from_dataset(dataset: taxel_data::Dataset) -> Self {
        let units = dataset.units();
        Samples {
            // A scene that was saved and read again is still simulated.
            source: match dataset.source.filter(|source| source.starts_with("simulated: ")) {
                Some(simulated) => format!("{simulated} ({})", dataset.name),
                None => format!("real: {}", dataset.name),
            },
            x: dataset.x,
            y: dataset.y,
            classes: dataset.classes,
            groups: dataset.groups,
            units: Some(units),
            full_scale: None,
            origins: dataset.sources,
            digest: dataset.digest,
        }
    }

    fn from_scene(name: &str, without: &[String], scene: taxel_scenes::Scene) -> Self {
        let mut hasher = blake3::Hasher::new();
        for axis in scene.x.shape() {
            hasher.update(&(*axis as u64).to_le_bytes());
        }
        let mut bytes = Vec::with_capacity(4 * scene.x.len());
        bytes.extend(scene.x.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(scene.y.iter().chain(&scene.group).flat_map(|v| v.to_le_bytes()));
        hasher.update(&bytes);
        let left_out = match without {
            [] => String::new(),
            names => format!(" without {}", names.join(", ")),
        };
        Samples {
            source: format!("simulated: {name}{left_out}"),
            origins: (0..scene.y.len()).map(|i| format!("{name}[{i}]")).collect(),
            x: scene.x,
            y: scene.y,
            classes: scene.class_names,
            groups: Some(scene.group),
            units: None,
            full_scale: Some(scene.full_scale),
            digest: hasher.finalize().to_hex().to_string(),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.y.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.y.is_empty()
    }

    /// Shape of one sample.
    pub fn shape(&self) -> &[usize] {
        self.x.shape().get(1..).unwrap_or_default()
    }

    /// The folds of one repetition of the experiment's protocol.
    ///
    /// # Errors
    /// Groups that are not there, or too few samples or groups for that many folds.
    pub fn folds(&self, experiment: &Experiment, repetition: usize) -> Result<Vec<Fold>> {
        let config = experiment.config();
        let (folds, seed, repetition) = (config.protocol.folds, config.seed, repetition as u32);
        match (config.protocol.split, &self.groups) {
            (Split::Stratified, _) => {
                Ok(stratified_k_fold(&self.y, folds, seed, repetition, self.units.as_deref())?)
            }
            (Split::Group, Some(groups)) => Ok(group_k_fold(groups, &self.y, folds, seed, repetition)?),
            (Split::Group, None) => Err(experiment.refuse(Problem {
                key: "protocol.split".into(),
                value: "\"group\"".into(),
                reason: format!(
                    "{} has no groups; name the array that holds them (data.group = \"session\") or use \
                     split = \"stratified\"",
                    self.source
                ),
            })),
        }
    }
}

fn options(data: &Data) -> Options {
    let default = Options::default();
    Options {
        x: data.x.clone().unwrap_or(default.x),
        y: data.y.clone().unwrap_or(default.y),
        group: data.group.clone(),
        group_block: data.group_block,
        channels: data.channels.clone(),
        drop: data.drop.clone(),
        deny_contradictory: data.deny_contradictory.unwrap_or(default.deny_contradictory),
        attribute: data.attribute.unwrap_or(default.attribute),
        resize: data.resize,
        limits: data.limits.unwrap_or(default.limits),
    }
}
