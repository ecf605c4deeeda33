//! Parts of a network: which nodes a name means, and the network up to a node.

use taxel_base::names::nearest;

use crate::error::{Error, Result};
use crate::graph::{Graph, Node, NodeId};
use crate::op::Op;

impl Graph {
    /// Marks the nodes that `names` cover: of each the node of that name, and all whose names start with it and a point
    /// (`stem` is every node `stem.…`). Only nodes with tensors are covered.
    ///
    /// # Errors
    /// A name without a node that has tensors.
    pub fn covered(&self, names: &[String]) -> Result<Vec<bool>> {
        let mut covered = vec![false; self.nodes.len()];
        for name in names {
            let mut found = false;
            for (covered, node) in covered.iter_mut().zip(&self.nodes) {
                let rest = node.name.strip_prefix(name.as_str());
                let here = rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
                if here && !node.params.is_empty() {
                    (*covered, found) = (true, true);
                }
            }
            if !found {
                let reason = format!("cannot freeze `{name}`: no node with tensors has that name");
                return Err(Error::node(&self.name, reason));
            }
        }
        Ok(covered)
    }

    /// Returns the network up to a node, which becomes its only output and gives it its name. All inputs stay.
    ///
    /// `node` is the name of a node, or of a block: then the last node whose name starts with it and a
    /// point, before anything that pools globally or flattens.
    ///
    /// # Errors
    /// No such node.
    pub fn cut(&self, node: &str) -> Result<Graph> {
        let exact = self.nodes.iter().position(|n| n.name == node);
        let ends = |op: &Op| {
            matches!(
                op,
                Op::GlobalAveragePool
                    | Op::GlobalStandardDeviation { .. }
                    | Op::AdaptiveAveragePool { .. }
                    | Op::Flatten
                    | Op::Dropout { .. }
            )
        };
        let follows = |name: &str, before: &str, mark| {
            name.strip_prefix(before).is_some_and(|rest: &str| rest.starts_with(mark))
        };
        // What comes after an end without a name of its own carries the name of the end.
        let ended: Vec<&str> = self.nodes.iter().filter(|n| ends(&n.op)).map(|n| n.name.as_str()).collect();
        let inside = |n: &Node| {
            follows(&n.name, node, '.') && !ends(&n.op) && !ended.iter().any(|end| follows(&n.name, end, '/'))
        };
        let Some(end) = exact.or_else(|| self.nodes.iter().rposition(inside)) else {
            return Err(Error::node(&self.name, format!("has no node `{node}`{}", self.meant(node))));
        };
        let mut kept = self.up_to(end);
        self.inputs.iter().for_each(|&input| kept[input] = true);
        let at = |id: NodeId| kept[..id].iter().filter(|kept| **kept).count();
        let moved = |(_, node): (&bool, &Node)| Node {
            inputs: node.inputs.iter().map(|&id| at(id)).collect(),
            ..node.clone()
        };
        let nodes = kept.iter().zip(&self.nodes).filter(|(kept, _)| **kept).map(moved).collect();
        Graph::new(self.name.clone(), nodes, vec![(self.nodes[end].name.clone(), at(end))], vec![1.0])
    }

    /// Marks the node `end` and all that it is computed from.
    pub(crate) fn up_to(&self, end: NodeId) -> Vec<bool> {
        let mut before = vec![false; self.nodes.len()];
        before[end] = true;
        for id in (0..=end).rev() {
            if before[id] {
                self.nodes[id].inputs.iter().for_each(|&input| before[input] = true);
            }
        }
        before
    }

    /// Returns "; did you mean …?" with the names of nodes and blocks that are nearest to `name`, or else
    /// "; its nodes are …" with the first and the last.
    fn meant(&self, name: &str) -> String {
        let mut names: Vec<&str> = vec![];
        for node in &self.nodes {
            let blocks = node.name.match_indices('.').map(|(end, _)| &node.name[..end]);
            names.extend(blocks.filter(|block| !block.contains('/')).chain([node.name.as_str()]));
        }
        names.dedup();
        match nearest(name, names.iter().copied()).as_slice() {
            [] => {
                let ends: Vec<&str> = [names.first(), names.last()].into_iter().flatten().copied().collect();
                format!("; its nodes are `{}`", ends.join("` to `"))
            }
            names => format!("; did you mean `{}`?", names.join("` or `")),
        }
    }

    /// Returns the names of the tensors of the heads: of each output, those between the last convolution, linear or
    /// recurrent layer and the output, that layer's included.
    pub fn head_tensors(&self) -> Vec<&str> {
        let mut names = vec![];
        for &(_, output) in &self.outputs {
            let mut id = output;
            loop {
                let node = &self.nodes[id];
                names.extend(node.params.iter().map(|p| p.name.as_str()));
                let layer =
                    matches!(node.op, Op::Conv { .. } | Op::Linear { .. } | Op::Lstm { .. } | Op::Gru { .. });
                match node.inputs[..] {
                    [input] if !layer => id = input,
                    _ => break,
                }
            }
        }
        names
    }
}
