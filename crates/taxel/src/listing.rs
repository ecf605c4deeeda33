//! Networks and their costs as JSON, for `taxel zoo --format json` and `taxel cost --format json`.

use serde_json::{Value, json};
use taxel_graph::{Cost, Graph};
use taxel_zoo::{Registry, Settings};

use crate::error::Result;

/// Lists every network of a registry: name, family, paper, inputs with their shapes, parameters, bytes, MACs, FLOPs.
///
/// # Errors
/// A network that its own defaults do not build.
pub fn listing(registry: &Registry) -> Result<Value> {
    let one = |entry: &taxel_zoo::Entry| {
        let graph = entry.graph(&Settings::new())?;
        let cost = graph.cost();
        let shapes: Vec<_> = graph.inputs().map(|n| json!({"name": n.name, "shape": n.shape})).collect();
        Ok(json!({
            "name": entry.name, "family": entry.family, "paper": entry.paper, "inputs": shapes,
            "parameters": cost.parameters, "bytes": cost.bytes(), "macs": cost.macs, "flops": cost.flops,
            "activation_bytes": cost.activation_bytes(),
        }))
    };
    registry.entries().map(one).collect()
}

/// Returns the costs of a network, layer by layer and in total: parameters, buffers, bytes, MACs, FLOPs, activation bytes.
pub fn costs(graph: &Graph) -> Value {
    let object = |cost: Cost| {
        json!({
            "parameters": cost.parameters, "buffers": cost.buffers, "bytes": cost.bytes(),
            "macs": cost.macs, "flops": cost.flops, "activation_bytes": cost.activation_bytes(),
        })
    };
    let layers = taxel_zoo::matlab::layers(graph).map(|(number, node)| {
        json!({
            "number": number, "name": node.name, "operation": node.op.kind(), "shape": node.shape,
            "cost": object(node.cost()),
        })
    });
    let layers: Vec<_> = layers.collect();
    json!({"model": graph.name(), "layers": layers, "total": object(graph.cost())})
}
