//! A network with its weights in one file: what `taxel import` writes.
//!
//! The tensors under PyTorch's names, and as text `{"taxel": version, "network": graph}`.

use std::path::Path;

use serde_json::{Value, json};
use taxel_graph::{Graph, Weights};

use crate::error::{Cause, Error, Result};

/// Key of the text that holds the graph.
const NETWORK: &str = "network";

/// Writes a network and its weights as one `.safetensors`, whole or not at all.
///
/// # Errors
/// Weights that do not fit the graph, and a file that cannot be written.
pub fn write_network(path: &Path, graph: &Graph, weights: &Weights) -> Result<()> {
    crate::write_bytes(path, network_to_bytes(graph, weights))
}

/// Returns the bytes that [`write_network`] writes.
///
/// # Errors
/// Weights that do not fit the graph.
pub fn network_to_bytes(graph: &Graph, weights: &Weights) -> std::result::Result<Vec<u8>, Cause> {
    weights.check(graph).map_err(|e| Cause::Network(e.to_string()))?;
    let text = json!({"taxel": env!("CARGO_PKG_VERSION"), NETWORK: graph});
    crate::to_bytes(weights, &text.to_string())
}

/// Reads the bytes that [`network_to_bytes`] gave; none where they hold weights only, or a model.
///
/// # Errors
/// As [`read_network`].
pub fn network_from_bytes(bytes: &[u8]) -> std::result::Result<Option<(Graph, Weights)>, Cause> {
    let (weights, text) = crate::from_bytes(bytes)?;
    let Some(network) = text.as_deref().and_then(network) else { return Ok(None) };
    checked(network, weights).map(Some)
}

/// Returns the graph in the text of a file.
fn network(text: &str) -> Option<Value> {
    let Ok(Value::Object(mut text)) = serde_json::from_str(text) else { return None };
    text.remove(NETWORK)
}

fn checked(network: Value, weights: Weights) -> std::result::Result<(Graph, Weights), Cause> {
    let refuse = |e: &dyn std::fmt::Display| Cause::Network(e.to_string());
    let graph: Graph = serde_json::from_value(network).map_err(|e| refuse(&e))?;
    weights.check(&graph).map_err(|e| refuse(&e))?;
    let weights = weights.only(&graph);
    Ok((graph, weights))
}

/// Reads a network and its weights out of one file; none where the file holds weights alone, or a model.
///
/// # Errors
/// As [`read`](crate::read); a graph that is none, or whose tensors are not those of the file.
pub fn read_network(path: &Path) -> Result<Option<(Graph, Weights)>> {
    let Some(text) = crate::read_text(path)? else { return Ok(None) };
    let Some(network) = network(&text) else { return Ok(None) };
    let (weights, _) = crate::read(path)?;
    checked(network, weights).map(Some).map_err(|cause| Error::new(path, cause))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use taxel_graph::{Network, Scheme, Tensor, Weights};

    use super::*;

    #[test]
    fn a_network_comes_back_with_its_weights() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.safetensors");
        let net = Network::new("own");
        let logits = net.input("signal", &[4]).linear("fc", 2);
        let graph = net.finish(&[("logits", logits)]).unwrap();
        let weights = Weights::init(&graph, Scheme::Pytorch, 0, "own");
        write_network(&path, &graph, &weights).unwrap();
        assert_eq!(read_network(&path).unwrap(), Some((graph.clone(), weights.clone())));
        let bytes = network_to_bytes(&graph, &weights).unwrap();
        assert_eq!(bytes, std::fs::read(&path).unwrap());
        assert_eq!(network_from_bytes(&bytes).unwrap(), Some((graph.clone(), weights.clone())));
        assert!(network_from_bytes(&bytes[1..]).is_err());
        crate::write(&path, &weights, "").unwrap();
        assert_eq!(read_network(&path).unwrap(), None);
        assert_eq!(network_from_bytes(&std::fs::read(&path).unwrap()).unwrap(), None);
        let mut other = weights;
        other.insert("fc.bias", Tensor { shape: vec![3], data: vec![0.0; 3] });
        let text = json!({NETWORK: graph}).to_string();
        crate::write(&path, &other, &text).unwrap();
        let error = read_network(&path).unwrap_err().to_string();
        assert!(error.contains("own.safetensors") && error.contains("`fc.bias` has shape [3]"), "{error}");
        crate::write(&path, &other, r#"{"network": {"name": "x"}}"#).unwrap();
        assert!(read_network(&path).unwrap_err().to_string().contains("missing field"));
    }
}
