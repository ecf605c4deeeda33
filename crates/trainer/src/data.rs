//! The `[data]` table: a simulated scene or recordings on disk.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use taxel_base::names::unknown;
use taxel_data::{Layout, ReadOptions, TargetNames};
use taxel_learn::{Check, Problem, require, within};
use toml::{Table, Value};

use crate::merge::leaves;
use crate::misread::Misread;
use crate::read::{one_line, read};

/// Recordings to simulate where nothing else is said: the number of Kaewrakmuk and Srinonchat 2026, section 4.
pub const SAMPLES: usize = 1500;

/// The source of the samples, and the labels that are learned.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Data {
    /// A scene, or recordings on disk.
    #[serde(flatten)]
    #[schemars(skip)]
    pub origin: Origin,
    /// The largest possible reading, for `scale = "full-scale"`; a scene knows its own, and so does a data
    /// set with `full_scale` in its labels.json.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f64>,
    /// Axes of a sample, where the data set does not say them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layout: Option<Layout>,
    /// Readings per second in Hz, where the data set does not say it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Takes every frame of a squeeze for a sample of its own, as single images are learned from (Pastor et al. 2019).
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(default)]
    pub each_frame: bool,
    /// Learns every column of labels `[N, k]`, under these names: the two levels of Zhang et al. 2022.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Option<Vec<String>>")]
    pub attributes: Vec<String>,
    /// Keeps the samples of these classes only, in this order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub classes: Option<Vec<String>>,
    /// Groups of classes that look alike, by name: the results tell mistakes within from those between.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "Option<BTreeMap<String, Vec<String>>>")]
    pub look_alikes: BTreeMap<String, Vec<String>>,
}

/// A scene, or recordings on disk: each takes its own keys only.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Origin {
    /// `data.scene`.
    Scene(SceneOrigin),
    /// `data.path`.
    Recordings(Box<RecordingsOrigin>),
}

/// A simulated world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneOrigin {
    /// A scene of `taxel simulate`.
    pub scene: String,
    /// Recordings to simulate, 1 to 10 million. Default 1500.
    #[serde(default = "samples")]
    pub samples: usize,
    /// True values that are learned in place of the classes: `shore`, or several as a list.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<TargetNames>,
    /// Settings of the scene.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: Table,
    /// Effects of the scene to leave out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
}

fn samples() -> usize {
    SAMPLES
}

/// Recordings on disk, and how they are read.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RecordingsOrigin {
    /// A file or folder of recordings; `${NAME}` is replaced by the environment variable. A relative path
    /// starts at the config's folder.
    pub path: String,
    /// The options of the reader; layout, rate and attributes are those of [`Data`].
    #[serde(flatten)]
    pub options: ReadOptions,
}

/// Settings of scenes that are paths.
pub(crate) const SCENE_PATHS: [&str; 1] = ["meshes"];

/// Keys of a scene that recordings in its place do not have.
pub(crate) const SCENE_KEYS: [&str; 4] = ["scene", "samples", "without", "set"];

/// Keys of either origin.
const SHARED_KEYS: [&str; 7] =
    ["full_scale", "layout", "rate", "each_frame", "attributes", "classes", "look_alikes"];

/// Returns options as values for `--set`: `data.x="images"`. A table of columns and a rule replace those of a config whole;
/// limits are set one by one.
pub fn settings(options: &ReadOptions) -> Vec<String> {
    let mut keys = Table::try_from(options).unwrap_or_default();
    let limits = match keys.remove("limits") {
        Some(Value::Table(limits)) => leaves(&limits),
        _ => vec![],
    };
    let limits = limits.into_iter().map(|(key, value)| (format!("limits.{key}"), value));
    keys.into_iter().chain(limits).map(|(key, value)| format!("data.{key}={value}")).collect()
}

/// Lists all keys that an unknown one of the table itself could have been.
fn with_shared(mut misread: Misread, others: &[&'static str]) -> Misread {
    let is_of_table = !misread.expected.is_empty() && misread.key.matches('.').count() == 1;
    let Some(field) = misread.unknown.as_ref().filter(|_| is_of_table) else { return misread };
    for key in others.iter().chain(&SHARED_KEYS) {
        if !misread.expected.contains(key) {
            misread.expected.push(key);
        }
    }
    misread.message = unknown("field", field, &misread.expected);
    misread
}

impl Data {
    /// Reads the `[data]` table.
    ///
    /// # Errors
    /// An unknown key, one that belongs to the other kind of origin, a value of the wrong type.
    pub(crate) fn read(mut table: Table) -> Result<Self, Misread> {
        fn take<T: serde::de::DeserializeOwned>(table: &mut Table, key: &str) -> Result<Option<T>, Misread> {
            table.remove(key).map(|value| read(&format!("data.{key}"), value)).transpose()
        }
        let full_scale = take(&mut table, "full_scale")?;
        let layout = take(&mut table, "layout")?;
        let rate = take(&mut table, "rate")?;
        let each_frame = take(&mut table, "each_frame")?.unwrap_or(false);
        let attributes = take(&mut table, "attributes")?.unwrap_or_default();
        let classes = take(&mut table, "classes")?;
        let look_alikes = take(&mut table, "look_alikes")?.unwrap_or_default();
        let origin = match (table.contains_key("scene"), table.contains_key("path")) {
            (true, true) => {
                return Err(Misread::new("data.path", "give either scene or path, not both"));
            }
            (false, false) => {
                return Err(Misread::new("data", "needs scene = \"..\" or path = \"..\""));
            }
            (true, false) => {
                let scene = read("data", Value::Table(table));
                Origin::Scene(scene.map_err(|misread| with_shared(misread, &[]))?)
            }
            (false, true) => {
                let path = take(&mut table, "path")?.unwrap_or_default();
                let options = read("data", Value::Table(table));
                let options = options.map_err(|misread| with_shared(misread, &["path"]))?;
                Origin::Recordings(Box::new(RecordingsOrigin { path, options }))
            }
        };
        Ok(Data { origin, full_scale, layout, rate, each_frame, attributes, classes, look_alikes })
    }

    /// Checks the values.
    ///
    /// # Errors
    /// A value outside its range.
    pub(crate) fn check(&self) -> Check {
        match &self.origin {
            Origin::Scene(scene) => {
                scene.check()?;
                let is_of_values = scene.y.is_some();
                let reason = "is for classes, and data.y learns true values of the scene; keep one of them";
                require(!is_of_values || self.attributes.is_empty(), "attributes", "[..]", reason)?;
                require(!is_of_values || self.classes.is_none(), "classes", "[..]", reason)?;
                require(!is_of_values || self.look_alikes.is_empty(), "look_alikes", "{ .. }", reason)?;
            }
            Origin::Recordings(recordings) => recordings.check(!self.attributes.is_empty())?,
        }
        if let Some(i) =
            (1..self.attributes.len()).find(|&i| self.attributes[..i].contains(&self.attributes[i]))
        {
            let reason = "is there twice; give every column of labels its own name";
            return Err(Problem::new(format!("attributes.{i}"), format!("{:?}", self.attributes[i]), reason));
        }
        if let Some(full) = self.full_scale {
            let reason = "must be positive and finite, such as 1023 for 10-bit counts";
            require(full > 0.0 && full <= f64::from(f32::MAX), "full_scale", full, reason)?;
        }
        match self.rate {
            Some(rate) => require(rate > 0.0 && rate.is_finite(), "rate", rate, "must be above 0, in Hz"),
            None => Ok(()),
        }
    }
}

impl SceneOrigin {
    fn check(&self) -> Check {
        let known = taxel_scenes::names();
        let hint = taxel_base::names::hint(&self.scene, known.iter().copied());
        let reason = format!("no scene has this name; {hint}");
        require(known.contains(&self.scene.as_str()), "scene", format!("{:?}", self.scene), reason)?;
        if let Err(error) = taxel_scenes::Settings::read(&self.scene, Value::Table(self.set.clone())) {
            let reason = error.to_string().trim().replace('\n', " ");
            return Err(Problem::new("set", one_line(&self.set), reason));
        }
        within("samples", self.samples, 1, 10_000_000)
    }
}

impl RecordingsOrigin {
    fn check(&self, several: bool) -> Check {
        let options = &self.options;
        let named = options.test_above.is_none() || options.test.is_some();
        require(named, "test_above", "..", "needs the name of an array in data.test")?;
        if let Some((key, value, reason)) = options.length.and_then(|rule| rule.problem()) {
            return Err(Problem::new(format!("length.{key}"), value.to_string(), reason));
        }
        let reason = "picks one column, data.attributes takes all; keep one of them";
        require(!several || options.attribute.is_none(), "attribute", "..", reason)
    }

    /// Returns the options of the reader, with those of [`Data`] for any samples.
    pub(crate) fn options(
        &self,
        layout: Option<Layout>,
        rate: Option<f64>,
        attributes: &[String],
    ) -> ReadOptions {
        ReadOptions { layout, rate, attributes: attributes.to_vec(), ..self.options.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_become_the_keys_that_somebody_has_said() {
        let options = ReadOptions {
            x: Some("images".into()),
            length: Some(taxel_data::Length::Resample { to: 300 }),
            table: "long,clock=ms".parse().unwrap_or_default(),
            limits: taxel_data::Limits { max_values: 9, ..Default::default() },
            ..ReadOptions::default()
        };
        assert_eq!(
            settings(&options),
            [
                "data.length={ kind = \"resample\", to = 300 }",
                "data.table={ clock = \"ms\", form = \"long\" }",
                "data.x=\"images\"",
                "data.limits.max_values=9"
            ]
        );
        assert_eq!(settings(&ReadOptions::default()), [""; 0]);
    }
}
