//! The network under construction so far.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Result};
use crate::fill::Fill;
use crate::graph::{Node, NodeId};
use crate::op::Op;

/// Nodes, the first step that did not fit, and how the layers that follow are drawn.
#[derive(Debug, Default)]
pub(crate) struct NetworkState {
    pub name: String,
    pub nodes: Vec<Node>,
    pub error: Option<Error>,
    /// Weight and bias of convolutions, then of linear layers.
    pub conv: (Fill, Fill),
    pub linear: (Fill, Fill),
}

impl NetworkState {
    /// Returns the network under construction as it is now; no step leaves it half done.
    pub fn of(shared: &Mutex<NetworkState>) -> MutexGuard<'_, NetworkState> {
        shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds what `make` makes of the nodes so far, unless a step before it did not fit. `None` where there is no
    /// new node.
    pub fn push(&mut self, make: impl FnOnce(&[Node]) -> Result<Node>) -> Option<NodeId> {
        if self.error.is_some() {
            return None;
        }
        match make(&self.nodes) {
            Ok(node) => {
                self.nodes.push(node);
                Some(self.nodes.len() - 1)
            }
            Err(error) => {
                self.error = Some(error);
                None
            }
        }
    }

    /// Returns the shape of a node, batch axis left out; nothing where a step before it did not fit.
    pub fn shape(&self, node: NodeId) -> &[usize] {
        self.nodes.get(node).map_or(&[], |node| &node.shape)
    }
}

/// Makes a name for a node without tensors: after its input, numbered when taken.
pub(crate) fn fresh(nodes: &[Node], input: NodeId, kind: &str) -> String {
    let base = format!("{}/{kind}", nodes.get(input).map_or("", |node| &node.name));
    let taken = |name: &str| nodes.iter().any(|node| node.name == name);
    let mut name = base.clone();
    for count in 2.. {
        if !taken(&name) {
            break;
        }
        name = format!("{base}{count}");
    }
    name
}

/// Makes the node that does `op` to `inputs`, its weight and bias drawn by `fills`.
pub(crate) fn drawn(
    name: String,
    op: Op,
    inputs: Vec<NodeId>,
    earlier: &[Node],
    fills: (Fill, Fill),
) -> Result<Node> {
    let mut node = Node::computed(name, op, inputs, earlier)?;
    let weight = node.params.first().map(|param| param.shape.clone()).unwrap_or_default();
    for (param, fill) in node.params.iter_mut().zip([fills.0, fills.1]) {
        param.init = fill.resolve(&param.name, &weight)?;
    }
    Ok(node)
}
