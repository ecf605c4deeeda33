//! Which tensors of a network are in fewer bits, where some are.

use taxel_graph::{Graph, Op};

/// Returns the names of the tensors that values are multiplied with: those of convolutions and linear layers.
pub(super) fn multiplied(graph: &Graph) -> Vec<&str> {
    let multiplies = |op: &Op| matches!(op, Op::Conv { .. } | Op::Linear { .. });
    let nodes = graph.nodes().iter().filter(|node| multiplies(&node.op));
    nodes.filter_map(|node| node.params.first()).map(|param| param.name.as_str()).collect()
}
