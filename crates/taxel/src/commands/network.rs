//! A network as commands name it: one of the zoo, or a file.

use std::path::Path;

use taxel::experiment::read_network;
use taxel_graph::{Graph, Weights};

/// The network `model`, and its weights where it is a file: `.onnx`, or a `.safetensors` with a network in it.
pub fn named(model: &str, set: &[String]) -> Result<(Graph, Option<Weights>), Box<dyn std::error::Error>> {
    if !is_file(model) {
        return Ok((taxel_zoo::find(model)?.graph(&super::settings(set)?)?, None));
    }
    if !set.is_empty() {
        return Err(format!("--set: {model} is a file; settings are for networks of the zoo").into());
    }
    let (graph, weights) = read_network(Path::new(model))?;
    Ok((graph, Some(weights)))
}

/// Whether a model is named by its file.
pub fn is_file(model: &str) -> bool {
    let ending = Path::new(model).extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ["onnx", "safetensors"].contains(&ending.to_lowercase().as_str()))
}
