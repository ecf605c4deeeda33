//! A network by its name: one of the zoo, or a file.

use std::error::Error;
use std::path::Path;

use taxel::base::FileError;
use taxel::experiment::read_network;
use taxel::learn::read_weights;
use taxel_graph::{Graph, Weights};

use crate::commands::arguments::settings::settings;

/// Returns the network `model`, and its weights where it is a file: `.onnx`, or a `.safetensors` with a network in it.
pub fn named(model: &str, set: &[String]) -> Result<(Graph, Option<Weights>), Box<dyn Error>> {
    if !is_file(model) {
        return Ok((taxel_zoo::find(model)?.graph(&settings(set)?)?, None));
    }
    if !set.is_empty() {
        return Err(format!("--set: {model} is a file; settings are for networks of the zoo").into());
    }
    let (graph, weights) = read_network(existing(model)?)?;
    Ok((graph, Some(weights)))
}

/// Returns the network `model` with weights: those of the file `weights`, or else its own.
pub fn weighted(
    model: &str,
    set: &[String],
    weights: Option<&Path>,
) -> Result<(Graph, Weights), Box<dyn Error>> {
    let (graph, stored) = named(model, set)?;
    let weights = match (weights, stored) {
        (Some(path), _) => weights_of(&graph, path)?,
        (None, Some(stored)) => stored,
        (None, None) => {
            let reason = "is a network of the zoo, which has no weights: give its --weights FILE, or name a model file \
                          that `taxel fit` made";
            return Err(format!("{model}: {reason}").into());
        }
    };
    Ok((graph, weights))
}

/// Reads the weights of a network, and checks that they fit it.
pub fn weights_of(graph: &Graph, path: &Path) -> Result<Weights, Box<dyn Error>> {
    let weights = read_weights(path)?;
    weights.check(graph).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(weights)
}

/// Checks whether a network is named by its file.
pub fn is_file(model: &str) -> bool {
    let ending = Path::new(model).extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ["onnx", "safetensors"].contains(&ending.to_lowercase().as_str()))
}

/// Returns the path of a network that is named by its file.
pub fn existing(model: &str) -> Result<&Path, FileError> {
    let path = Path::new(model);
    if path.exists() { Ok(path) } else { Err(FileError::missing(path)) }
}
