//! A network cut in two: a body that does not change, and a head that learns from the body's output.

use std::cmp::Reverse;

use crate::graph::{Graph, Node, NodeId, TensorKind};
use crate::op::Op;

/// A network cut in two at a node, which is the one output of the body and the one input of the head.
#[derive(Debug, Clone, PartialEq)]
pub struct Halves {
    /// All inputs and the layers that do not change.
    pub body: Graph,
    /// The rest, with all outputs.
    pub head: Graph,
}

impl Graph {
    /// Cuts the network so that the body makes the same of a sample in every pass: its nodes learn nothing, as
    /// `unchanged` says of every node, and drop nothing.
    ///
    /// The body has as many layers as it can have; of places as good it ends at the last of those with the fewest
    /// values. None if no layer is still from the inputs on, or if none is left to the head.
    pub fn halves(&self, unchanged: &[bool]) -> Option<Halves> {
        let layers = |before: &[bool]| {
            self.nodes.iter().zip(before).filter(|(node, before)| **before && !node.params.is_empty()).count()
        };
        let ends = (0..self.nodes.len()).filter(|&id| self.nodes[id].op != Op::Input);
        let places = ends.filter_map(|end| Some((end, self.body_before(end, unchanged)?)));
        let size = |id: NodeId| self.nodes[id].shape.iter().product::<usize>();
        let rank = |(end, before): &(NodeId, Vec<bool>)| (layers(before), Reverse(size(*end)), *end);
        let (end, before) = places.max_by_key(rank).filter(|(_, before)| layers(before) > 0)?;
        let place = |id: NodeId| {
            if id == end { 0 } else { 1 + before[..id].iter().filter(|before| !**before).count() }
        };
        let last = &self.nodes[end];
        let (inputs, params) = (vec![], vec![]);
        let first =
            Node { name: last.name.clone(), op: Op::Input, inputs, shape: last.shape.clone(), params };
        let rest = self.nodes.iter().zip(&before).filter(|(_, before)| !**before).map(|(node, _)| Node {
            inputs: node.inputs.iter().map(|&id| place(id)).collect(),
            ..node.clone()
        });
        let nodes = std::iter::once(first).chain(rest).collect();
        let outputs = self.outputs.iter().map(|(name, id)| (name.clone(), place(*id))).collect();
        let head = Graph::new(self.name.clone(), nodes, outputs, self.loss_weights.clone()).ok()?;
        Some(Halves { body: self.cut(&last.name).ok()?, head })
    }

    /// Marks the nodes of a body that ends at `end`; none if there is no such body.
    fn body_before(&self, end: NodeId, unchanged: &[bool]) -> Option<Vec<bool>> {
        let before = self.up_to(end);
        let marked = || self.nodes.iter().enumerate().zip(&before);
        let moves = |id: NodeId, node: &Node| match node.op {
            Op::Dropout { probability } => probability > 0.0,
            // Its statistics move even where its weight does not learn, or where it has none.
            Op::BatchNorm { .. } => !unchanged[id],
            _ => !unchanged[id] && node.params.iter().any(|param| param.kind == TensorKind::Parameter),
        };
        let is_deterministic = marked().all(|((id, node), before)| !before || !moves(id, node));
        let closed = marked().filter(|(_, before)| !**before).all(|((_, node), _)| {
            node.op != Op::Input && node.inputs.iter().all(|&input| input == end || !before[input])
        });
        let has_output = self.outputs.iter().any(|&(_, id)| before[id]);
        (is_deterministic && closed && !has_output).then_some(before)
    }
}
