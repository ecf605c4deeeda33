//! Settings from Python, as JSON, to a checked experiment.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use taxel::learn::Encoding;
use taxel::{Experiment, Overrides, Registry};

use pyo3::PyResult;

use crate::raise::{raised, refused};

/// Reads settings that Python has written as JSON; `ValueError` names the key that cannot be read.
pub fn settings<T: DeserializeOwned>(text: &str) -> PyResult<T> {
    let value: Value = serde_json::from_str(text).map_err(refused)?;
    serde_path_to_error::deserialize(value).map_err(refused)
}

/// Reads the experiment that a JSON object describes, key by key as a config file does; `place` is its name in messages.
///
/// # Errors
/// `ValueError` for an unknown key or a value of the wrong type or out of its range.
pub fn experiment(config: &str, place: &str) -> PyResult<Experiment> {
    let config: Map<String, Value> = serde_json::from_str(config).map_err(refused)?;
    parsed(config, place)
}

/// Makes one as [`experiment`] does; the encoding is that of [`Encoding::of`] for these samples, except for keys that the
/// config has.
///
/// # Errors
/// As [`experiment`], and a file that is to hold a network and does not.
pub fn experiment_on(config: &str, place: &str, dataset: &taxel::Dataset) -> PyResult<Experiment> {
    let mut config: Map<String, Value> = serde_json::from_str(config).map_err(refused)?;
    let mut inputs: Vec<String> = vec![];
    for network in config.get("networks").and_then(Value::as_array).into_iter().flatten() {
        inputs.extend(reads(network)?);
    }
    let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
    let mut encoding = serde_json::to_value(Encoding::of(&dataset.spec, &inputs)).map_err(refused)?;
    match (config.remove("encoding"), &mut encoding) {
        (Some(Value::Object(given)), Value::Object(encoding)) => encoding.extend(given),
        (None | Some(Value::Null), _) => {}
        (Some(other), _) => encoding = other,
    }
    config.insert("encoding".into(), encoding);
    parsed(config, place)
}

/// Returns the names of the inputs of a network of a config; none where there is no such network.
fn reads(network: &Value) -> PyResult<Vec<String>> {
    let text = |key: &str| network.get(key).and_then(Value::as_str);
    if let Some(file) = text("file").or(text("onnx")) {
        let (graph, _) = taxel::experiment::read_network(file.as_ref()).map_err(raised)?;
        return Ok(graph.inputs().map(|node| node.name.clone()).collect());
    }
    let registry = Registry::built_in();
    let entry = text("name").and_then(|name| registry.find(name).ok());
    Ok(entry.map_or(vec![], |entry| entry.inputs.iter().map(|input| input.name.clone()).collect()))
}

fn parsed(config: Map<String, Value>, place: &str) -> PyResult<Experiment> {
    let config = without_null(Value::Object(config));
    let table = toml::Table::try_from(config).map_err(refused)?;
    Experiment::parse(&table.to_string(), place, &Overrides::default(), &Registry::built_in()).map_err(raised)
}

/// Leaves out keys whose value is null.
fn without_null(value: Value) -> Value {
    match value {
        Value::Object(map) => map
            .into_iter()
            .filter(|(_, value)| !value.is_null())
            .map(|(key, value)| (key, without_null(value)))
            .collect(),
        Value::Array(list) => list.into_iter().map(without_null).collect(),
        other => other,
    }
}
