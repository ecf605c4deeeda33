//! One of an experiment's networks: of the zoo, or from a file.

use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use taxel_learn::{Check, Problem, Published, Recipe, file_name, require};
use taxel_zoo::{Registry, Settings};
use toml::{Table, Value};

use crate::merge::merged;
use crate::misread::Misread;
use crate::network_file::is_onnx;
use crate::read::{one_line, read};

/// One of `[[networks]]`.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Network {
    /// Name in the registry; of a network from a file its own, by default the file's.
    #[schemars(with = "Option<String>")]
    pub name: String,
    /// An ONNX file in place of a name in the registry, such as `torch.onnx.export` writes; `${NAME}` is an environment
    /// variable. Its last layer gets as many outputs as the data have classes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub onnx: Option<String>,
    /// The same from a `.safetensors` that `taxel import` wrote, or from a trained model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Whether fresh weights are drawn in place of those of `onnx` or `file`. Default false.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(default)]
    pub fresh: bool,
    /// Name in tables and files. Default `name`.
    #[schemars(with = "Option<String>")]
    pub label: String,
    /// Settings of the network other than its input and output sizes, which come from the data.
    #[serde(skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "Option<BTreeMap<String, serde_json::Value>>")]
    pub set: Table,
    /// Checkpoint that every fold starts from, `.safetensors` or `.pth`; `${NAME}` is an environment
    /// variable. A head for another number of classes is drawn. Default fresh weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<String>,
    /// How this network is trained, where it is not as `[train]` says: the same keys.
    #[schemars(with = "Option<Recipe>")]
    pub train: Recipe,
    /// Numbers that its authors report on their data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub published: Option<Published>,
}

/// A network as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawNetwork {
    name: Option<String>,
    onnx: Option<String>,
    file: Option<String>,
    #[serde(default)]
    fresh: bool,
    label: Option<String>,
    #[serde(default)]
    set: Table,
    weights: Option<String>,
    #[serde(default)]
    train: Table,
    published: Option<Published>,
}

impl RawNetwork {
    /// Resolves network `i` of the list on top of the experiment's `train`.
    pub(crate) fn resolve(self, i: usize, train: &Table) -> Result<Network, Misread> {
        let train = merged(train, &self.train);
        let path = self.onnx.as_deref().or(self.file.as_deref()).map(Path::new);
        let stem = path.and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
        let name = self.name.or(stem).ok_or_else(|| {
            let message = "needs `name`, a network of the zoo, or `onnx` or `file`, a network of your own";
            Misread::new(format!("networks.{i}"), message)
        })?;
        Ok(Network {
            label: self.label.unwrap_or_else(|| name.clone()),
            name,
            onnx: self.onnx,
            file: self.file,
            fresh: self.fresh,
            set: self.set,
            weights: self.weights,
            train: read(&format!("networks.{i}.train"), Value::Table(train))?,
            published: self.published,
        })
    }
}

impl Network {
    /// Returns key and path of the file that holds the network; none for one of the registry.
    pub(crate) fn source(&self) -> Option<(&'static str, &String)> {
        let onnx = self.onnx.as_ref().map(|path| ("onnx", path));
        onnx.or(self.file.as_ref().map(|path| ("file", path)))
    }

    /// Refuses settings that a network from a file does not have.
    fn check_file(&self, key: &str, path: &str) -> Check {
        let value = || format!("{path:?}");
        require(
            self.onnx.is_none() || self.file.is_none(),
            "file",
            value(),
            "`onnx` names a network already",
        )?;
        let is_onnx = is_onnx(Path::new(path));
        let reason = "must be an .onnx file; `file` names networks that `taxel import` wrote, and models";
        require(is_onnx || key != "onnx", key, value(), reason)?;
        require(!is_onnx || key != "file", key, value(), "is ONNX: write onnx in place of file")?;
        let reason = "a network from a file has no settings; leave it out";
        require(self.set.is_empty(), "set", one_line(&self.set), reason)?;
        let reason = "`weights` are given: leave one of them out";
        require(!(self.fresh && self.weights.is_some()), "fresh", "true", reason)
    }

    pub(crate) fn check(&self, registry: &Registry) -> Check {
        if let Some((key, path)) = self.source() {
            file_name("label", &self.label)?;
            self.check_file(key, path)?;
            return self.check_published();
        }
        let reason = "belongs to `onnx` and `file`: a network of the zoo starts fresh without `weights`";
        require(!self.fresh, "fresh", "true", reason)?;
        let name = format!("{:?}", self.name);
        let entry = registry.find(&self.name).map_err(|e| Problem::new("name", name, e.to_string()))?;
        file_name("label", &self.label)?;
        let sizes = entry.inputs.iter().flat_map(|input| &input.keys).map(String::as_str).chain(["classes"]);
        for key in sizes {
            let reason = "comes from the data and its encoding; leave it out";
            let value = self.set.get(key).map(ToString::to_string).unwrap_or_default();
            require(!self.set.contains_key(key), &format!("set.{key}"), value, reason)?;
        }
        if let Err(error @ taxel_zoo::Error::Settings { .. }) = entry.graph(&self.settings()) {
            return Err(Problem::new("set", one_line(&self.set), error.to_string()));
        }
        self.check_published()
    }

    fn check_published(&self) -> Check {
        match &self.published {
            Some(published) => published.check().map_err(|problem| problem.below("published")),
            None => Ok(()),
        }
    }

    /// Returns the settings as the registry reads them.
    pub(crate) fn settings(&self) -> Settings {
        let entries = self.set.iter();
        entries.map(|(key, value)| (key.clone(), serde_json::json!(value))).collect()
    }
}
