//! One registered network: what it reads, and how settings become its graph.

use std::fmt;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use taxel_graph::{Architecture, Graph, InputKeys, Listing, NetworkCounts};

use crate::error::{Error, Result};

/// Configuration values by key; what is left out keeps the paper's value.
pub type Settings = serde_json::Map<String, Value>;

/// The setting of every network made by [`Entry::of`] that multiplies its channels ([`Graph::with_width`]); a network
/// with a setting of this name, such as MobileNetV2, gives it its own meaning.
pub const WIDTH_MULT: &str = "width_mult";

/// The setting of every network made by [`Entry::of`] that leaves out so many of its last residual blocks or dense
/// layers ([`Graph::without_blocks`]).
pub const WITHOUT_BLOCKS: &str = "without_blocks";

/// The setting of every network made by [`Entry::of`] that leaves out so many of its last plain layers
/// ([`Graph::without_layers`]).
pub const WITHOUT_LAYERS: &str = "without_layers";

/// One input of a network and the configuration keys that hold its axis sizes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Input {
    /// `signal` (channels × time), `image` (channels × rows × columns), `tensor` (channels × rows × columns × frames) or
    /// `rocket` (features).
    pub name: String,
    /// Keys of the axes in order; a single key means that the whole sample is flattened into it.
    pub keys: Vec<String>,
}

impl Input {
    /// Makes an input `name` whose axis sizes are the settings `keys`.
    pub fn new(name: &str, keys: &[&str]) -> Self {
        Input { name: name.into(), keys: keys.iter().map(|key| key.to_string()).collect() }
    }

    /// Makes the input `signal` `[in_channels, length]`.
    pub fn signal() -> Self {
        InputKeys::SIGNAL.into()
    }

    /// Makes the input `signal` flattened to `[1, in_features]`.
    pub fn flat() -> Self {
        InputKeys::FLAT.into()
    }

    /// Makes the input `image` `[in_channels, height, width]`.
    pub fn image() -> Self {
        InputKeys::IMAGE.into()
    }

    /// Makes the input `rocket` `[features]`.
    pub fn rocket() -> Self {
        InputKeys::ROCKET.into()
    }

    /// Makes the input `tensor` `[in_channels, height, width, frames]`.
    pub fn tensor() -> Self {
        InputKeys::TENSOR.into()
    }
}

impl From<InputKeys> for Input {
    fn from(input: InputKeys) -> Self {
        Input::new(input.name, input.keys)
    }
}

/// Settings that do not become a graph.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// An unknown key or a value of the wrong type.
    #[error(transparent)]
    Settings(#[from] serde_json::Error),
    /// A value out of range, or a node that does not fit.
    #[error(transparent)]
    Graph(#[from] taxel_graph::Error),
}

type Build = dyn Fn(&Settings) -> std::result::Result<Graph, BuildError> + Send + Sync;

/// A registered network.
#[derive(Clone)]
pub struct Entry {
    /// Name in configs, on the command line and in run folders.
    pub name: String,
    /// Family crate.
    pub family: String,
    /// Where it is published.
    pub paper: String,
    /// Its inputs.
    pub inputs: Vec<Input>,
    /// Counts at the published settings, where its file states them.
    pub counts: Option<NetworkCounts>,
    /// Sizes at which tests that walk every network take it; none are the published ones.
    pub quick: Settings,
    build: Arc<Build>,
    defaults: Settings,
}

impl fmt::Debug for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Entry").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Entry {
    /// Makes the entry of a network whose graph `build` makes of settings.
    pub fn new(
        name: &str,
        family: &str,
        paper: &str,
        inputs: impl Into<Vec<Input>>,
        build: impl Fn(&Settings) -> std::result::Result<Graph, BuildError> + Send + Sync + 'static,
    ) -> Self {
        Entry {
            name: name.into(),
            family: family.into(),
            paper: paper.into(),
            inputs: inputs.into(),
            counts: None,
            quick: Settings::new(),
            build: Arc::new(build),
            defaults: Settings::new(),
        }
    }

    /// Makes the entry of the network of `config`, with settings in place of its values, and [`WIDTH_MULT`],
    /// [`WITHOUT_BLOCKS`] and [`WITHOUT_LAYERS`] beside them.
    pub fn of<C>(config: C, name: &str, family: &str, paper: &str, inputs: impl Into<Vec<Input>>) -> Self
    where
        C: Architecture + Serialize + DeserializeOwned + Send + Sync + 'static,
    {
        let values = serde_json::to_value(&config).ok().and_then(|value| value.as_object().cloned());
        let entry = Entry::new(name, family, paper, inputs, move |settings| {
            let known: Settings = serde_json::from_value(serde_json::to_value(&config)?)?;
            let mut merged = known.clone();
            merged.extend(settings.clone());
            let mut beside = |key: &str| if known.contains_key(key) { None } else { merged.remove(key) };
            let [width_mult, without_blocks, without_layers] =
                [WIDTH_MULT, WITHOUT_BLOCKS, WITHOUT_LAYERS].map(&mut beside);
            let mut graph = config.with(serde_json::from_value(Value::Object(merged))?).graph()?;
            if let Some(value) = without_blocks {
                graph = graph.without_blocks(whole_number(WITHOUT_BLOCKS, &value)?)?;
            }
            if let Some(value) = without_layers {
                graph = graph.without_layers(whole_number(WITHOUT_LAYERS, &value)?)?;
            }
            if let Some(value) = width_mult {
                let wrong = || taxel_graph::Error::config(WIDTH_MULT, &value, "must be a number");
                graph = graph.with_width(value.as_f64().ok_or_else(wrong)?)?;
            }
            Ok(graph)
        });
        Entry { defaults: values.unwrap_or_default(), ..entry }
    }

    /// Makes the entry of the network that a family lists.
    pub(crate) fn listed<C>(network: Listing<C>) -> Self
    where
        C: Architecture + Serialize + DeserializeOwned + Send + Sync + 'static,
    {
        let Listing { name, family, paper, config, inputs, counts, quick } = network;
        let inputs: Vec<Input> = inputs.iter().copied().map(Input::from).collect();
        let quick = quick.iter().map(|(key, size)| (key.to_string(), (*size).into())).collect();
        Entry { counts: Some(counts), quick, ..Entry::of(config, name, family, paper, inputs) }
    }

    /// Returns a whole number among its own settings, such as a width, that does not come from the data: what it is
    /// where nothing else is said.
    pub fn number(&self, key: &str) -> Option<usize> {
        let is_size =
            self.inputs.iter().flat_map(|input| &input.keys).any(|size| size == key) || key == "classes";
        let value = self.defaults.get(key).filter(|_| !is_size)?.as_u64()?;
        usize::try_from(value).ok()
    }

    /// Returns its own settings, which do not come from the data, with their defaults: none for a network that [`Entry::new`]
    /// made.
    pub fn settings(&self) -> Settings {
        let is_size = |key: &str| {
            key == "classes" || self.inputs.iter().flat_map(|input| &input.keys).any(|size| size == key)
        };
        let mut settings = self.defaults.clone();
        settings.retain(|key, _| !is_size(key));
        if self.is_resizable() {
            for (key, value) in
                [(WIDTH_MULT, 1.0.into()), (WITHOUT_BLOCKS, 0.into()), (WITHOUT_LAYERS, 0.into())]
            {
                settings.entry(key).or_insert(value);
            }
        }
        settings
    }

    /// Returns the default of [`WIDTH_MULT`]; none for a network that [`Entry::new`] made.
    pub fn width_mult(&self) -> Option<f64> {
        match self.defaults.get(WIDTH_MULT) {
            Some(value) => value.as_f64(),
            None => self.is_resizable().then_some(1.0),
        }
    }

    /// Checks whether it takes [`WIDTH_MULT`], [`WITHOUT_BLOCKS`] and [`WITHOUT_LAYERS`]: those that [`Entry::of`] made
    /// do.
    pub fn is_resizable(&self) -> bool {
        !self.defaults.is_empty()
    }

    /// Builds the network with `settings` in place of the paper's values.
    ///
    /// # Errors
    /// An unknown key, a value of the wrong type or out of range, or sizes that a node does not fit.
    pub fn graph(&self, settings: &Settings) -> Result<Graph> {
        let model = self.name.clone();
        (self.build)(settings).map_err(|error| match error {
            BuildError::Settings(source) => Error::Settings { model, source },
            BuildError::Graph(source) => Error::Graph { model, source },
        })
    }

    /// Returns the settings that fit the network to samples: `shape_of` tells the shape of an input by name.
    ///
    /// # Errors
    /// An input that the data do not have, or with another number of axes.
    pub fn fit(&self, classes: usize, shape_of: impl Fn(&str) -> Option<Vec<usize>>) -> Result<Settings> {
        let mut settings = Settings::new();
        settings.insert("classes".into(), classes.into());
        for input in &self.inputs {
            let refuse = |reason: String| Error::Input {
                model: self.name.clone(),
                input: input.name.clone(),
                axes: input.keys.len(),
                reason,
            };
            let shape = shape_of(&input.name).ok_or_else(|| {
                refuse(format!("the experiment encodes no `{0}` (encoding.{0})", input.name))
            })?;
            if let [key] = &input.keys[..] {
                settings.insert(key.clone(), shape.iter().product::<usize>().into());
            } else if input.keys.len() == shape.len() {
                for (key, size) in input.keys.iter().zip(&shape) {
                    settings.insert(key.clone(), (*size).into());
                }
            } else {
                return Err(refuse(format!("the samples are {shape:?}")));
            }
        }
        Ok(settings)
    }
}

fn whole_number(key: &str, value: &Value) -> taxel_graph::Result<usize> {
    let count = value.as_u64().and_then(|count| usize::try_from(count).ok());
    count.ok_or_else(|| taxel_graph::Error::config(key, value, "must be a whole number"))
}
