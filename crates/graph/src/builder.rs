//! Writing a network down as its paper's table reads.
//!
//! ```
//! use taxel_graph::{Conv, Network, Pool};
//!
//! let net = Network::new("tiny");
//! let image = net.input("image", &[3, 50, 50]);
//! let features = image
//!     .conv("stem.conv", Conv::new(16, 3).same())
//!     .batch_norm("stem.bn")
//!     .relu()
//!     .max_pool(Pool::new(2).round_up());
//! assert_eq!(features.shape(), [16, 25, 25]);
//! let graph = net.finish(&[("logits", features.global_average_pool().linear("fc", 3))])?;
//! assert_eq!(graph.parameter_count(), 16 * 27 + 16 + 32 + 3 * 16 + 3);
//! # Ok::<(), taxel_graph::Error>(())
//! ```
//!
//! A step that does not fit is remembered and reported by [`Network::finish`], which names the node;
//! the steps after it do nothing.

use std::sync::{Arc, Mutex};

use crate::error::{Error, Result};
use crate::fill::Fill;
use crate::flow::Flow;
use crate::graph::{Graph, Node};
use crate::op::Op;
use crate::state::NetworkState;

/// A network under construction.
#[derive(Debug, Clone)]
pub struct Network {
    state: Arc<Mutex<NetworkState>>,
}

impl Network {
    /// Starts a network with its registry name.
    pub fn new(name: &str) -> Self {
        Network { state: Arc::new(Mutex::new(NetworkState { name: name.into(), ..NetworkState::default() })) }
    }

    /// Adds an input of `shape`, batch axis left out.
    pub fn input(&self, name: &str, shape: &[usize]) -> Flow {
        let node = NetworkState::of(&self.state).push(|_| Node::input(name.into(), shape.to_vec()));
        Flow::new(&self.state, node.unwrap_or(0))
    }

    /// Sets how weights and biases of the convolutions that follow are drawn, in place of PyTorch's default.
    ///
    /// The run's [`crate::Scheme`] must leave the choice to the network (`pytorch`).
    pub fn conv_init(&self, weight: Fill, bias: Fill) {
        NetworkState::of(&self.state).conv = (weight, bias);
    }

    /// Sets the same for the linear layers that follow.
    pub fn linear_init(&self, weight: Fill, bias: Fill) {
        NetworkState::of(&self.state).linear = (weight, bias);
    }

    /// Joins flows along channels (or features). All other axes must agree.
    pub fn concat(&self, name: &str, flows: &[&Flow]) -> Flow {
        let inputs = flows.iter().map(|flow| flow.node()).collect();
        let make = |nodes: &[Node]| Node::computed(name.into(), Op::Concat, inputs, nodes);
        let node = NetworkState::of(&self.state).push(make);
        Flow::new(&self.state, node.unwrap_or(0))
    }

    /// Adds the node `name` that does `op` to `flows`, which this network made: for readers of foreign formats, which
    /// know windows and paddings already.
    ///
    /// # Errors
    /// A step that does not fit, this one or one before it.
    pub fn operation(&self, name: &str, op: Op, flows: &[&Flow]) -> Result<Flow> {
        let inputs = flows.iter().map(|flow| flow.node()).collect();
        let node = NetworkState::of(&self.state).push(|nodes| Node::computed(name.into(), op, inputs, nodes));
        match (node, &NetworkState::of(&self.state).error) {
            (None, Some(error)) => Err(error.clone()),
            (node, _) => Ok(Flow::new(&self.state, node.unwrap_or(0))),
        }
    }

    /// Checks whether everything fits so far.
    ///
    /// # Errors
    /// The first step that did not.
    pub fn check(&self) -> Result<()> {
        NetworkState::of(&self.state).error.clone().map_or(Ok(()), Err)
    }

    /// Ends the description: the graph, or the first step that did not fit. Every output counts 1 in training.
    ///
    /// # Errors
    /// The first step that did not fit; no output, or names that two nodes, tensors or outputs share.
    pub fn finish(self, outputs: &[(&str, Flow)]) -> Result<Graph> {
        let weights = vec![1.0; outputs.len()];
        self.finish_weighted(outputs, &weights)
    }

    /// Ends the description likewise, with what each output counts in training (see [`Graph::loss_weights`]).
    ///
    /// # Errors
    /// As [`Network::finish`], and loss weights that are not finite or not one per output.
    pub fn finish_weighted(self, outputs: &[(&str, Flow)], loss_weights: &[f32]) -> Result<Graph> {
        let state = NetworkState::of(&self.state);
        if let Some(error) = &state.error {
            return Err(error.clone());
        }
        if outputs.len() != loss_weights.len() {
            let (count, weights) = (outputs.len(), loss_weights.len());
            return Err(Error::node(&state.name, format!("{weights} loss weights for {count} outputs")));
        }
        let outputs = outputs.iter().map(|(name, flow)| (name.to_string(), flow.node())).collect();
        Graph::new(state.name.clone(), state.nodes.clone(), outputs, loss_weights.to_vec())
    }
}
