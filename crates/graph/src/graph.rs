//! The network as a value: nodes in the order they run, with shapes and named tensors.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::op::Op;

/// Position of a node in [`Graph::nodes`].
pub type NodeId = usize;

/// Whether training moves a tensor by its gradient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TensorKind {
    /// Trained by gradient.
    Parameter,
    /// Kept by the network itself: running statistics.
    Buffer,
}

/// How a fresh tensor is filled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Init {
    /// Every value the same.
    Constant(f32),
    /// Uniform in ±`bound`.
    Uniform {
        /// Largest absolute value.
        bound: f32,
    },
    /// Normal around zero.
    Normal {
        /// Standard deviation.
        sd: f32,
    },
}

impl Init {
    /// Refuses what no value can be drawn from, for tensor `name`.
    pub(crate) fn check(self, name: &str) -> Result<()> {
        let reason = match self {
            Init::Constant(value) if !value.is_finite() => format!("value {value} must be finite"),
            // A range wider than the largest number cannot be drawn from.
            Init::Uniform { bound } if !(0.0..=f32::MAX / 2.0).contains(&bound) => {
                format!("bound {bound} must be in 0..={:e}", f32::MAX / 2.0)
            }
            Init::Normal { sd } if sd.is_infinite() => format!("standard deviation {sd} must be finite"),
            Init::Normal { sd } if sd < 0.0 || sd.is_nan() => {
                format!("standard deviation {sd} must be at least 0")
            }
            _ => return Ok(()),
        };
        Err(Error::node(name, reason))
    }
}

/// One tensor of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Param {
    /// Full name as in a PyTorch `state_dict`: `stem.bn.running_mean`.
    pub name: String,
    /// Shape in PyTorch's axis order: out × in/groups × spatial axes.
    pub shape: Vec<usize>,
    /// Trained or kept.
    pub kind: TensorKind,
    /// PyTorch's default for this operation, unless the network says otherwise.
    pub init: Init,
    /// Inputs and outputs that meet in one weight (for Glorot and He); `None` for biases and norms.
    pub fan: Option<(usize, usize)>,
}

impl Param {
    /// Returns the number of values.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Checks whether it holds no value; never true for a tensor of a built graph.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// One operation with its inputs, output shape and tensors.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Unique name; nodes with tensors carry the prefix of their tensors (`stem.conv`).
    pub name: String,
    /// The operation.
    pub op: Op,
    /// Where its inputs come from, always earlier nodes.
    pub inputs: Vec<NodeId>,
    /// Output shape without the batch axis.
    pub shape: Vec<usize>,
    /// Its tensors, in PyTorch's order.
    pub params: Vec<Param>,
}

/// A network: nodes in topological order, inputs and outputs by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Graph {
    pub(crate) name: String,
    pub(crate) nodes: Vec<Node>,
    pub(crate) inputs: Vec<NodeId>,
    pub(crate) outputs: Vec<(String, NodeId)>,
    pub(crate) loss_weights: Vec<f32>,
}

impl Graph {
    /// Makes the network of `nodes`, of which each is built on those before it.
    ///
    /// # Errors
    /// No output, one that is no node, a loss weight that is not finite, or names that two nodes, tensors or
    /// outputs share.
    pub(crate) fn new(
        name: String,
        nodes: Vec<Node>,
        outputs: Vec<(String, NodeId)>,
        loss_weights: Vec<f32>,
    ) -> Result<Graph> {
        let refuse = |reason: String| Err(Error::node(&name, reason));
        if let Some(twice) = twice(nodes.iter().map(|node| &node.name)) {
            return Err(Error::node(twice, "two nodes carry this name"));
        }
        if let Some(twice) = twice(nodes.iter().flat_map(|node| &node.params).map(|param| &param.name)) {
            return Err(Error::node(twice, "two tensors carry this name"));
        }
        if let Some(twice) = twice(outputs.iter().map(|(name, _)| name)) {
            return refuse(format!("two outputs are called `{twice}`"));
        }
        if outputs.is_empty() {
            return refuse("needs at least one output".into());
        }
        for ((output, id), weight) in outputs.iter().zip(&loss_weights) {
            if *id >= nodes.len() {
                return refuse(format!("output `{output}` is node {id} of {}", nodes.len()));
            }
            if !weight.is_finite() {
                return refuse(format!("loss weight {weight} of output `{output}` must be finite"));
            }
        }
        let inputs = (0..nodes.len()).filter(|&id| nodes[id].op == Op::Input).collect();
        Ok(Graph { name, nodes, inputs, outputs, loss_weights })
    }

    /// Returns the registry name of the network.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns all nodes; every node's inputs come before it.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Returns the input nodes in the order in which callers pass tensors.
    pub fn inputs(&self) -> impl ExactSizeIterator<Item = &Node> {
        self.inputs.iter().map(|&id| &self.nodes[id])
    }

    /// Returns output names and the nodes that compute them.
    pub fn outputs(&self) -> &[(String, NodeId)] {
        &self.outputs
    }

    /// Returns the weight of each output in training, in their order: the loss is the sum of every output's loss
    /// against the same targets, times its weight.
    pub fn loss_weights(&self) -> &[f32] {
        &self.loss_weights
    }

    /// Returns every tensor, in order of the nodes: the names of a PyTorch `state_dict`.
    pub fn params(&self) -> impl Iterator<Item = &Param> {
        self.nodes.iter().flat_map(|node| &node.params)
    }

    /// Returns the number of trained values.
    pub fn parameter_count(&self) -> usize {
        self.params().filter(|p| p.kind == TensorKind::Parameter).map(Param::len).sum()
    }

    /// Returns the number of values kept by the network itself (running statistics).
    pub fn buffer_count(&self) -> usize {
        self.params().filter(|p| p.kind == TensorKind::Buffer).map(Param::len).sum()
    }
}

/// Finds the first name that comes a second time.
fn twice<'a>(names: impl Iterator<Item = &'a String>) -> Option<&'a str> {
    let mut seen = HashSet::new();
    names.map(String::as_str).find(|name| !seen.insert(*name))
}
