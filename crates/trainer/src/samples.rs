//! The samples of an experiment: simulated or recorded, with the label that says which.

use std::collections::HashMap;

use ndarray::{ArrayD, Axis};
use taxel_data::{
    Fold, Options, Shares, Shortcut, few_per_class, group_k_fold, random_group_split, random_split,
    stratified_k_fold,
};

use crate::config::{Data, Problem, ProtocolKind, Split};
use crate::error::Result;
use crate::experiment::Experiment;
use crate::labels::{Attribute, Labels};

/// Labelled samples, all of one shape, as read: nothing is scaled.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// `simulated: <scene>` or `real: <set>`: stands beside every score.
    pub source: String,
    /// Samples `[N, ..]` in the unit of the readings.
    pub x: ArrayD<f32>,
    /// What splits keep even: the class of each sample, or the combination of its levels.
    pub y: Vec<u32>,
    /// Names of a network's outputs: the classes, or `attribute:level` for several attributes.
    pub classes: Vec<String>,
    /// What networks learn.
    pub labels: Labels,
    /// Which samples the data set's authors test on, where they say so.
    pub official: Option<Vec<bool>>,
    /// Group (session, object, block) of each sample.
    pub groups: Option<Vec<u32>>,
    /// What stays in one fold even under a stratified split: exact copies share a number.
    pub units: Option<Vec<u32>>,
    /// The largest possible reading.
    pub full_scale: Option<f32>,
    /// Readings without contact, one for all or one per channel, where somebody says so.
    pub rest: Option<Vec<f32>>,
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
                let settings =
                    taxel_scenes::Settings::read(name, toml::Value::Table(config.data.set.clone()))?;
                let scene = settings.simulate(count, config.seed, &config.data.without)?;
                Self::from_scene(name, &config.data.without, scene)
            }
            (None, None) => {
                let reason = "needs scene = \"..\" or path = \"..\"".into();
                return Err(experiment.refuse(Problem { key: "data".into(), value: "{}".into(), reason }));
            }
        };
        samples.full_scale = full_scale.or(samples.full_scale);
        samples.learn_attributes(experiment)?;
        samples.keep_classes(experiment)?;
        Ok(samples)
    }

    /// With `data.attributes`, every column of labels is learned; without, the class alone.
    fn learn_attributes(&mut self, experiment: &Experiment) -> Result<()> {
        let names = &experiment.config().data.attributes;
        let refuse = |reason: String| {
            let (key, value) = ("data.attributes".into(), format!("{names:?}"));
            Err(experiment.refuse(Problem { key, value, reason }))
        };
        let columns = self.labels.attributes().len();
        if names.is_empty() {
            if columns > 1 {
                // The column that became the class.
                let attribute = Attribute { name: "class".into(), classes: self.classes.clone() };
                self.labels = Labels::new(vec![attribute], self.y.clone());
            }
            return Ok(());
        }
        if columns != names.len() || columns < 2 {
            return refuse(match columns {
                1 => format!("{} has one label per sample; leave the key out", self.source),
                _ => format!("{} has {columns} columns of labels; name each of them", self.source),
            });
        }
        let rows: Vec<usize> = (0..self.len()).collect();
        let values = self.labels.of(&rows);
        let attributes: Vec<Attribute> = self
            .labels
            .attributes()
            .iter()
            .zip(names)
            .map(|(attribute, name)| Attribute { name: name.clone(), classes: attribute.classes.clone() })
            .collect();
        self.classes = attributes
            .iter()
            .flat_map(|a| a.classes.iter().map(move |class| format!("{}:{class}", a.name)))
            .collect();
        // Splits spread the combinations of levels evenly.
        let mut combinations: Vec<&[u32]> = values.chunks_exact(columns).collect();
        combinations.sort_unstable();
        combinations.dedup();
        let number: HashMap<&[u32], u32> =
            combinations.into_iter().enumerate().map(|(i, levels)| (levels, i as u32)).collect();
        self.y = values.chunks_exact(columns).map(|levels| number[levels]).collect();
        self.labels = Labels::new(attributes, values);
        Ok(())
    }

    /// With `data.classes`, samples of other classes are left out.
    fn keep_classes(&mut self, experiment: &Experiment) -> Result<()> {
        let Some(wanted) = &experiment.config().data.classes else { return Ok(()) };
        let refuse = |value: String, reason: String| {
            Err(experiment.refuse(Problem { key: "data.classes".into(), value, reason }))
        };
        if self.labels.attributes().len() > 1 {
            return refuse("..".into(), "works with one class per sample; leave data.attributes out".into());
        }
        let mut new = vec![None; self.classes.len()];
        for (label, name) in wanted.iter().enumerate() {
            match self.classes.iter().position(|class| class == name) {
                Some(old) if new[old].is_none() => new[old] = Some(label as u32),
                Some(_) => return refuse(format!("{name:?}"), "is there twice".into()),
                None => {
                    let known = self.classes.join(", ");
                    return refuse(format!("{name:?}"), format!("no class has this name; known: {known}"));
                }
            }
        }
        if wanted.len() < 2 {
            return refuse(format!("{wanted:?}"), "needs two classes at least".into());
        }
        let kept: Vec<usize> = (0..self.len()).filter(|&row| new[self.y[row] as usize].is_some()).collect();
        let take = |values: &[u32]| kept.iter().map(|&row| values[row]).collect::<Vec<_>>();
        self.y = kept.iter().filter_map(|&row| new[self.y[row] as usize]).collect();
        self.x = self.x.select(Axis(0), &kept);
        self.groups = self.groups.as_deref().map(take);
        self.units = self.units.as_deref().map(take);
        self.official = self.official.as_ref().map(|test| kept.iter().map(|&row| test[row]).collect());
        self.origins = kept.iter().map(|&row| self.origins[row].clone()).collect();
        self.classes = wanted.clone();
        let attribute = Attribute { name: "class".into(), classes: wanted.clone() };
        self.labels = Labels::new(vec![attribute], self.y.clone());
        Ok(())
    }

    /// Samples of a data set on disk.
    pub fn from_dataset(dataset: taxel_data::Dataset) -> Self {
        let units = dataset.units();
        let labels = match &dataset.attributes {
            Some(values) => numbered(&dataset.attribute_classes, values.iter().copied().collect()),
            None => {
                let attribute = Attribute { name: "class".into(), classes: dataset.classes.clone() };
                Labels::new(vec![attribute], dataset.y.clone())
            }
        };
        Samples {
            labels,
            official: dataset.official,
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
            full_scale: dataset.full_scale.map(|v| v as f32),
            rest: None,
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
        let labels = match &scene.attributes {
            Some(own) => numbered(&own.class_names, own.y.iter().copied().collect()),
            None => {
                let attribute = Attribute { name: "class".into(), classes: scene.class_names.clone() };
                Labels::new(vec![attribute], scene.y.clone())
            }
        };
        if let Some(own) = &scene.attributes {
            hasher.update(&own.y.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>());
        }
        Samples {
            labels,
            official: None,
            source: format!("simulated: {name}{left_out}"),
            origins: (0..scene.y.len()).map(|i| format!("{name}[{i}]")).collect(),
            x: scene.x,
            y: scene.y,
            classes: scene.class_names,
            groups: Some(scene.group),
            units: None,
            full_scale: Some(scene.full_scale),
            rest: Some(scene.rest),
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

    /// How many samples a few global statistics tell apart, where that is so many that it makes real
    /// recordings suspicious. A simulated world has no recording that could differ.
    pub(crate) fn shortcut(&self) -> Option<Shortcut> {
        let shortcut = || Shortcut::of(&self.x, &self.y, self.groups.as_deref(), self.units.as_deref());
        let found = self.source.starts_with("real: ").then(shortcut).flatten();
        found.filter(Shortcut::is_suspicious)
    }

    /// Shape of one sample.
    pub fn shape(&self) -> &[usize] {
        self.x.shape().get(1..).unwrap_or_default()
    }

    /// What no part of a split may share with another: groups under `split = "group"`, otherwise exact
    /// copies, if there can be any.
    ///
    /// # Errors
    /// Groups that are asked for and not there.
    pub fn inseparable(&self, experiment: &Experiment) -> Result<Option<&[u32]>> {
        let protocol = &experiment.config().protocol;
        let by_group = protocol.split == Split::Group || protocol.kind == ProtocolKind::LeaveGroupOut;
        match (by_group, &self.groups) {
            (false, _) => Ok(self.units.as_deref()),
            (true, Some(groups)) => Ok(Some(groups)),
            (true, None) => {
                let (key, value) = match protocol.kind {
                    ProtocolKind::LeaveGroupOut => ("protocol.kind", "\"leave-group-out\""),
                    _ => ("protocol.split", "\"group\""),
                };
                Err(experiment.refuse(Problem {
                    key: key.into(),
                    value: value.into(),
                    reason: format!(
                        "{} has no groups; name the array that holds them (data.group = \"session\") or use \
                         split = \"stratified\"",
                        self.source
                    ),
                }))
            }
        }
    }

    /// Whether `y` counts combinations of levels: rare ones need not be in every part.
    fn has_combinations(&self) -> bool {
        self.labels.attributes().len() > 1
    }

    /// What is dealt as one where nothing else says so: exact copies, or each sample by itself.
    fn atoms(&self, units: Option<&[u32]>) -> Vec<u32> {
        units.map_or_else(|| (0..self.len() as u32).collect(), <[u32]>::to_vec)
    }

    /// The folds of one repetition of the experiment's protocol; under `few-samples` one per number of
    /// training samples per class.
    ///
    /// # Errors
    /// Groups or an official split that are not there, or too few samples or groups for the protocol.
    pub fn folds(&self, experiment: &Experiment, repetition: usize) -> Result<Vec<Fold>> {
        let config = experiment.config();
        let (protocol, seed, repetition) = (&config.protocol, config.seed, repetition as u32);
        let units = self.inseparable(experiment)?;
        let shares =
            Shares { test: protocol.test.unwrap_or(0.2), validation: protocol.validation.unwrap_or(0.0) };
        let cut = |shares: Shares| match (protocol.split, units) {
            (Split::Group, Some(groups)) => random_group_split(groups, &self.y, shares, seed, repetition),
            _ => match random_split(&self.y, shares, seed, repetition, units) {
                Err(taxel_data::Error::ClassNotInPart { .. }) if self.has_combinations() => {
                    random_group_split(&self.atoms(units), &self.y, shares, seed, repetition)
                }
                other => other,
            },
        };
        match (protocol.kind, protocol.split, units) {
            (ProtocolKind::KFold, Split::Group, Some(groups)) => {
                Ok(group_k_fold(groups, &self.y, protocol.folds.unwrap_or(5), seed, repetition)?)
            }
            (ProtocolKind::KFold, ..) => {
                let folds = protocol.folds.unwrap_or(5);
                match stratified_k_fold(&self.y, folds, seed, repetition, units) {
                    Err(taxel_data::Error::ClassTooSmall { .. }) if self.has_combinations() => {
                        Ok(group_k_fold(&self.atoms(units), &self.y, folds, seed, repetition)?)
                    }
                    other => Ok(other?),
                }
            }
            (ProtocolKind::LeaveGroupOut, _, groups) => {
                let groups = groups.unwrap_or_default();
                let mut names = groups.to_vec();
                names.sort_unstable();
                names.dedup();
                Ok(group_k_fold(groups, &self.y, names.len(), seed, repetition)?)
            }
            (ProtocolKind::RandomSplits, ..) => Ok(vec![cut(shares)?]),
            (ProtocolKind::FewSamples, ..) => {
                let whole = cut(Shares { validation: 0.0, ..shares })?;
                let few = |&count: &usize| -> Result<Fold> {
                    let train = few_per_class(&whole.train, &self.y, count, seed, repetition)?;
                    Ok(Fold { train, ..whole.clone() })
                };
                protocol.per_class.as_deref().unwrap_or(&[1, 2, 5, 10, 20]).iter().map(few).collect()
            }
            (ProtocolKind::Official, ..) => match &self.official {
                Some(test) => {
                    let (test, train) = (0..self.len()).partition(|&row| test[row]);
                    Ok(vec![Fold { train, test, validation: vec![] }])
                }
                None => Err(experiment.refuse(Problem {
                    key: "protocol.kind".into(),
                    value: "\"official\"".into(),
                    reason: format!(
                        "{} has no split of its own; name the array that marks test samples (data.test = \
                         \"test\") or use kind = \"k-fold\"",
                        self.source
                    ),
                })),
            },
        }
    }
}

/// Several attributes that have no names yet.
fn numbered(classes: &[Vec<String>], values: Vec<u32>) -> Labels {
    let attribute = |(i, classes): (usize, &Vec<String>)| Attribute {
        name: format!("attribute-{i}"),
        classes: classes.clone(),
    };
    Labels::new(classes.iter().enumerate().map(attribute).collect(), values)
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
        test: data.test.clone(),
        test_above: data.test_above,
        resize: data.resize,
        limits: data.limits.unwrap_or(default.limits),
    }
}
