//! Networks from files in place of the zoo's.

use std::path::Path;

use taxel_base::FileError;
use taxel_graph::{Graph, Weights};
use taxel_learn::Model;

use crate::error::Result;

/// Reads a network with its weights: an ONNX file (`.onnx`), what `taxel import` wrote, or a trained model.
///
/// # Errors
/// A file that is missing, damaged or holds no network: by file and, in ONNX, node and operation.
pub fn read_network(path: &Path) -> Result<(Graph, Weights)> {
    if is_onnx(path) {
        let read = taxel_onnx::read(path)?;
        return Ok((read.graph, read.weights));
    }
    if let Some(found) = taxel_checkpoint::read_network(path).map_err(taxel_learn::Error::from)? {
        return Ok(found);
    }
    let model = Model::open(path)?;
    match model.card().graph() {
        Some(graph) => Ok((graph.clone(), model.weights().clone())),
        None => {
            let reason = format!("holds the baseline {}, not a network", model.card().name);
            Err(FileError::new(path, reason).into())
        }
    }
}

/// Checks whether a file is ONNX by its name.
pub(crate) fn is_onnx(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("onnx"))
}
