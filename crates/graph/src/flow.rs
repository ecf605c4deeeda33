//! The tensor that flows through a network under construction, and the operations it can meet.

use std::sync::{Arc, Mutex};

use crate::error::Result;
use crate::fill::Fill;
use crate::graph::{Node, NodeId};
use crate::op::{Activation, Op};
use crate::spec::{Conv, Extent, Pool, WindowSpec};
use crate::state::{NetworkState, drawn, fresh};

/// PyTorch's default ε of batch normalisation.
pub const BATCH_NORM_EPS: f32 = 1e-5;
/// PyTorch's ε of a layer norm.
const LAYER_NORM_EPS: f32 = 1e-5;
/// PyTorch's default momentum of batch normalisation.
pub const BATCH_NORM_MOMENTUM: f32 = 0.1;

/// The tensor that flows through a network under construction; cheap to clone for branches.
#[derive(Debug, Clone)]
pub struct Flow {
    state: Arc<Mutex<NetworkState>>,
    node: NodeId,
    scope: String,
}

impl Flow {
    pub(crate) fn new(state: &Arc<Mutex<NetworkState>>, node: NodeId) -> Self {
        Flow { state: Arc::clone(state), node, scope: String::new() }
    }

    pub(crate) fn node(&self) -> NodeId {
        self.node
    }

    /// Returns the current shape without the batch axis; empty after a step that did not fit.
    pub fn shape(&self) -> Vec<usize> {
        NetworkState::of(&self.state).shape(self.node).to_vec()
    }

    /// Puts `prefix.` before the names of all following nodes.
    pub fn within(mut self, prefix: &str) -> Self {
        self.scope = self.full(prefix);
        self
    }

    /// Puts nothing before the names of all following nodes.
    pub fn outside(mut self) -> Self {
        self.scope.clear();
        self
    }

    /// Adds convolution `name`, drawn as [`crate::Network::conv_init`] says.
    pub fn conv(&self, name: &str, conv: Conv) -> Flow {
        let Conv { filters, window, dilation, groups, bias } = conv;
        let fills = NetworkState::of(&self.state).conv;
        self.push(
            |_| self.full(name),
            fills,
            |node, shape| {
                let mut dilation = dilation.over(shape.len().saturating_sub(1));
                if dilation.iter().all(|&step| step == 1) {
                    dilation.clear();
                }
                let window = window.resolve_dilated(node, shape, &dilation)?;
                Ok(Op::Conv { filters, window, dilation, groups, bias })
            },
        )
    }

    /// Adds fully connected layer `name`, drawn as [`crate::Network::linear_init`] says.
    pub fn linear(&self, name: &str, outputs: usize) -> Flow {
        self.dense(name, outputs, true)
    }

    /// Adds fully connected layer `name` without a bias.
    pub fn linear_no_bias(&self, name: &str, outputs: usize) -> Flow {
        self.dense(name, outputs, false)
    }

    fn dense(&self, name: &str, outputs: usize, bias: bool) -> Flow {
        let fills = NetworkState::of(&self.state).linear;
        self.push(|_| self.full(name), fills, |_, _| Ok(Op::Linear { outputs, bias }))
    }

    /// Adds batch normalisation `name` with PyTorch's ε and momentum.
    pub fn batch_norm(&self, name: &str) -> Flow {
        self.batch_norm_with(name, BATCH_NORM_EPS, BATCH_NORM_MOMENTUM)
    }

    /// Adds batch normalisation `name`; ε above 0, momentum (weight of the new batch) in 0..=1.
    pub fn batch_norm_with(&self, name: &str, eps: f32, momentum: f32) -> Flow {
        self.computed(|_| self.full(name), Op::BatchNorm { eps, momentum }, &[])
    }

    /// Adds layer normalisation `name` of features, with PyTorch's ε.
    pub fn layer_norm(&self, name: &str) -> Flow {
        self.layer_norm_with(name, LAYER_NORM_EPS)
    }

    /// Adds layer normalisation `name` of features; ε above 0.
    pub fn layer_norm_with(&self, name: &str, eps: f32) -> Flow {
        self.computed(|_| self.full(name), Op::LayerNorm { eps }, &[])
    }

    /// Adds a rectified linear unit.
    pub fn relu(&self) -> Flow {
        self.unnamed(Op::Relu, &[])
    }

    /// Applies a function to each value.
    pub fn activation(&self, activation: Activation) -> Flow {
        self.unnamed(Op::Activation(activation), &[])
    }

    /// Adds dropout; `probability` is the share of values dropped, in 0..1.
    pub fn dropout(&self, probability: f32) -> Flow {
        self.unnamed(Op::Dropout { probability }, &[])
    }

    /// Adds LSTM layer `name` over the last axis: channels × length → `hidden` features after the last step.
    ///
    /// All tensors start uniform in ±1/√hidden, as in PyTorch. Under [`crate::Scheme::Glorot`] and
    /// [`crate::Scheme::He`] the gates count as outputs and biases are zero; MATLAB's orthogonal
    /// recurrent weights and forget bias of 1 are not among the schemes.
    pub fn lstm(&self, name: &str, hidden: usize) -> Flow {
        let steps = self.shape().last().copied().unwrap_or_default();
        self.computed(|_| self.full(name), Op::Lstm { hidden, steps }, &[])
    }

    /// Adds GRU layer `name` over the last axis: channels × length → `hidden` features after the last step.
    pub fn gru(&self, name: &str, hidden: usize) -> Flow {
        let steps = self.shape().last().copied().unwrap_or_default();
        self.computed(|_| self.full(name), Op::Gru { hidden, steps }, &[])
    }

    /// Multiplies the flow by one learned scalar, a tensor of one value called `name` that starts at `initial`.
    pub fn scale(&self, name: &str, initial: f32) -> Flow {
        let fill = Fill::Constant(initial);
        self.push(|_| self.full(name), (fill, fill), |_, _| Ok(Op::Scale))
    }

    /// Deals out the channels of `groups` groups in turn, as in ShuffleNet.
    pub fn channel_shuffle(&self, groups: usize) -> Flow {
        self.unnamed(Op::ChannelShuffle { groups }, &[])
    }

    /// Takes channels (or features) `start..start + len`.
    pub fn slice(&self, start: usize, len: usize) -> Flow {
        self.unnamed(Op::Slice { start, len }, &[])
    }

    /// Subtracts a mean and divides by a standard deviation, per channel: tensors of those names, 0 and 1 until they
    /// are set.
    pub fn standardize(&self, mean: &str, std: &str) -> Flow {
        self.unnamed(Op::Standardize { mean: self.full(mean), std: self.full(std) }, &[])
    }

    /// Passes the flow on, or zeros in samples where each channel of `stream` is constant.
    pub fn switch_scale(&self, stream: &Flow) -> Flow {
        self.unnamed(Op::SwitchScale, &[stream])
    }

    /// Adds convolution `prefix.conv`, batch norm `prefix.bn`, ReLU.
    pub fn conv_bn_relu(&self, prefix: &str, conv: Conv) -> Flow {
        self.conv(&format!("{prefix}.conv"), conv).batch_norm(&format!("{prefix}.bn")).relu()
    }

    /// Adds batch norm `name`, ReLU: the pre-activation of DenseNet.
    pub fn bn_relu(&self, name: &str) -> Flow {
        self.batch_norm(name).relu()
    }

    /// Takes the maximum over windows.
    pub fn max_pool(&self, pool: Pool) -> Flow {
        self.push(self.fresh("max_pool"), Default::default(), |node, shape| {
            Ok(Op::MaxPool(pool.window.resolve(node, shape)?))
        })
    }

    /// Takes the mean over windows.
    pub fn average_pool(&self, pool: Pool) -> Flow {
        self.push(self.fresh("average_pool"), Default::default(), |node, shape| {
            let window = pool.window.resolve(node, shape)?;
            // The overhang of rounding up is never counted.
            let counted = if pool.count_padding {
                WindowSpec { round_up: false, ..pool.window }.resolve(node, shape)?.padding
            } else {
                vec![(0, 0); window.padding.len()]
            };
            Ok(Op::AveragePool { window, counted })
        })
    }

    /// Takes the mean over all spatial axes.
    pub fn global_average_pool(&self) -> Flow {
        self.unnamed(Op::GlobalAveragePool, &[])
    }

    /// Takes the standard deviation over all spatial axes; `eps` is added to the variance.
    pub fn global_standard_deviation(&self, eps: f32) -> Flow {
        self.unnamed(Op::GlobalStandardDeviation { eps }, &[])
    }

    /// Takes the mean over windows that cut each spatial axis into `output` parts.
    pub fn adaptive_average_pool(&self, output: impl Into<Extent>) -> Flow {
        let axes = self.shape().len().saturating_sub(1);
        self.unnamed(Op::AdaptiveAveragePool { output: output.into().over(axes) }, &[])
    }

    /// Turns all axes into features, channels first.
    pub fn flatten(&self) -> Flow {
        self.unnamed(Op::Flatten, &[])
    }

    /// Adds another flow of the same shape: a residual connection.
    pub fn add(&self, other: &Flow) -> Flow {
        self.unnamed(Op::Add, &[other])
    }

    /// Joins another flow along channels: a dense connection.
    pub fn concat(&self, other: &Flow) -> Flow {
        self.unnamed(Op::Concat, &[other])
    }

    fn full(&self, name: &str) -> String {
        if self.scope.is_empty() { name.into() } else { format!("{}.{name}", self.scope) }
    }

    /// Makes the name of a node without tensors after this one, among the nodes that it is added to.
    fn fresh(&self, kind: &'static str) -> impl FnOnce(&[Node]) -> String {
        move |nodes| fresh(nodes, self.node, kind)
    }

    /// Applies `op` to this flow and `others`, named after this one.
    fn unnamed(&self, op: Op, others: &[&Flow]) -> Flow {
        self.computed(self.fresh(op.kind()), op, others)
    }

    /// Applies `op` to this flow and `others`.
    fn computed(&self, name: impl FnOnce(&[Node]) -> String, op: Op, others: &[&Flow]) -> Flow {
        let inputs = std::iter::once(self.node).chain(others.iter().map(|flow| flow.node)).collect();
        self.then(|nodes| Node::computed(name(nodes), op, inputs, nodes))
    }

    /// Adds the node that `op` makes of the node's name and this flow's shape, with tensors drawn by `fills`.
    fn push<N, F>(&self, name: N, fills: (Fill, Fill), op: F) -> Flow
    where
        N: FnOnce(&[Node]) -> String,
        F: FnOnce(&str, &[usize]) -> Result<Op>,
    {
        self.then(|nodes| {
            let name = name(nodes);
            let shape = nodes.get(self.node).map_or(&[][..], |node| &node.shape);
            let op = op(&name, shape)?;
            drawn(name, op, vec![self.node], nodes, fills)
        })
    }

    fn then(&self, make: impl FnOnce(&[Node]) -> Result<Node>) -> Flow {
        let node = NetworkState::of(&self.state).push(make).unwrap_or(self.node);
        Flow { node, ..self.clone() }
    }
}
