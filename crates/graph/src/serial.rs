//! A graph as a file: what is written, and what is checked when it is read.
//!
//! The format, as JSON (any format of serde's will do):
//!
//! ```json
//! {
//!   "name": "tiny",
//!   "nodes": [
//!     {"name": "signal", "op": "input", "shape": [5, 50]},
//!     {"name": "conv", "op": {"conv": {"out_channels": 8, "window": {"kernel_size": [3], "stride": [1],
//!       "padding": [[1, 1]]}, "groups": 1, "bias": false}}, "inputs": [0], "shape": [8, 50],
//!       "params": [{"name": "conv.weight", "shape": [8, 5, 3], "kind": "parameter",
//!         "init": {"uniform": {"bound": 0.2581989}}}]},
//!     {"name": "conv/global_average_pool", "op": "global_average_pool", "inputs": [1], "shape": [8]}
//!   ],
//!   "outputs": [{"name": "features", "node": 2, "loss_weight": 1.0}]
//! }
//! ```
//!
//! Operations carry their names in `Op::kind` and PyTorch's names of attributes; functions of one value are
//! `{"activation": "relu6"}`. `inputs` count nodes from 0; what is left out is empty. A graph's inputs are its
//! `input` nodes in their order. Shapes and tensors follow from the operations all the same: they are there for
//! readers that are not taxel, and as a check.
//!
//! Files come from strangers: every node is inferred anew from those before it, as the builder does, and has to
//! state just that. Nothing is allocated by a number in the file.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error as _, SeqAccess, Visitor};
use serde::{Serialize, Serializer};

use crate::error::{Error, Result};
use crate::graph::{Graph, Init, Node, NodeId, Param, TensorKind};
use crate::op::Op;
use crate::shape::describe;

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct GraphForm {
    name: String,
    #[serde(deserialize_with = "named")]
    nodes: Vec<NodeForm>,
    outputs: Vec<OutputForm>,
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct NodeForm {
    name: String,
    op: Op,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    inputs: Vec<NodeId>,
    shape: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    params: Vec<ParamForm>,
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct ParamForm {
    name: String,
    shape: Vec<usize>,
    kind: TensorKind,
    init: Init,
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct OutputForm {
    name: String,
    node: NodeId,
    loss_weight: f32,
}

impl Serialize for Graph {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let outputs = self.outputs().iter().zip(self.loss_weights());
        let output = |((name, node), weight): (&(String, NodeId), &f32)| OutputForm {
            name: name.clone(),
            node: *node,
            loss_weight: *weight,
        };
        let form = GraphForm {
            name: self.name().into(),
            nodes: self.nodes().iter().map(NodeForm::of).collect(),
            outputs: outputs.map(output).collect(),
        };
        form.serialize(serializer)
    }
}

impl NodeForm {
    fn of(node: &Node) -> NodeForm {
        let param = |param: &Param| ParamForm {
            name: param.name.clone(),
            shape: param.shape.clone(),
            kind: param.kind,
            init: param.init,
        };
        NodeForm {
            name: node.name.clone(),
            op: node.op.clone(),
            inputs: node.inputs.clone(),
            shape: node.shape.clone(),
            params: node.params.iter().map(param).collect(),
        }
    }

    /// Returns the node, which has to be what its operation makes of the `earlier` ones.
    fn check(self, earlier: &[Node]) -> Result<Node> {
        let NodeForm { name, op, inputs, shape, params } = self;
        let mut node = match op {
            Op::Input if inputs.is_empty() => Node::input(name, shape.clone())?,
            _ => Node::computed(name, op, inputs, earlier)?,
        };
        let refuse = |reason: String| Err(Error::node(&node.name, reason));
        if node.shape != shape {
            let (stated, inferred) = (describe(&shape), describe(&node.shape));
            return refuse(format!("states the shape {stated}, `{}` makes {inferred}", node.op.kind()));
        }
        if node.params.len() != params.len() {
            let (stated, inferred) = (params.len(), node.params.len());
            return refuse(format!("states {stated} tensors, `{}` has {inferred}", node.op.kind()));
        }
        for (param, stated) in node.params.iter().zip(&params) {
            if (&param.name, &param.shape, param.kind) != (&stated.name, &stated.shape, stated.kind) {
                let text = |name, shape, kind| format!("{kind:?} `{name}` {shape:?}").to_lowercase();
                let ours = text(&param.name, &param.shape, param.kind);
                let theirs = text(&stated.name, &stated.shape, stated.kind);
                return refuse(format!("states the {theirs}, `{}` has the {ours}", node.op.kind()));
            }
            stated.init.check(&stated.name)?;
        }
        node.params.iter_mut().zip(params).for_each(|(param, stated)| param.init = stated.init);
        Ok(node)
    }
}

impl<'de> Deserialize<'de> for Graph {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        GraphForm::deserialize(deserializer)?.check().map_err(D::Error::custom)
    }
}

impl GraphForm {
    fn check(self) -> Result<Graph> {
        let mut nodes = vec![];
        for node in self.nodes {
            nodes.push(node.check(&nodes)?);
        }
        let loss_weights = self.outputs.iter().map(|output| output.loss_weight).collect();
        let outputs = self.outputs.into_iter().map(|output| (output.name, output.node)).collect();
        Graph::new(self.name, nodes, outputs, loss_weights)
    }
}

/// Reads nodes; what is wrong with one as JSON is reported with the name of the one before it.
fn named<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Vec<NodeForm>, D::Error> {
    struct Nodes;

    impl<'de> Visitor<'de> for Nodes {
        type Value = Vec<NodeForm>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a list of nodes")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<Self::Value, A::Error> {
            let mut nodes: Vec<NodeForm> = vec![];
            loop {
                match list.next_element() {
                    Ok(Some(node)) => nodes.push(node),
                    Ok(None) => return Ok(nodes),
                    Err(error) => {
                        let before = nodes.last().map_or("the first node".into(), |node| {
                            format!("the node after `{}`", node.name)
                        });
                        return Err(A::Error::custom(format!("{before}: {error}")));
                    }
                }
            }
        }
    }

    deserializer.deserialize_seq(Nodes)
}
