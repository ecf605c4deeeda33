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

use std::cell::RefCell;
use std::rc::Rc;

use crate::error::{Error, Result};
use crate::fill::Fill;
use crate::graph::{Graph, Init, Kind, Node, NodeId, Param};
use crate::op::{Activation, Conv, Extent, Op, Pool, Window, axis_names, describe};

/// PyTorch's default ε of batch normalisation.
pub const BATCH_NORM_EPS: f32 = 1e-5;
/// PyTorch's default momentum of batch normalisation.
pub const BATCH_NORM_MOMENTUM: f32 = 0.1;

#[derive(Debug, Default)]
struct State {
    name: String,
    nodes: Vec<Node>,
    inputs: Vec<NodeId>,
    error: Option<Error>,
    /// Weight and bias of convolutions, then of linear layers.
    conv: (Fill, Fill),
    linear: (Fill, Fill),
}

/// A network under construction.
#[derive(Debug, Clone)]
pub struct Network {
    state: Rc<RefCell<State>>,
}

/// The tensor that flows through a network under construction; cheap to clone for branches.
#[derive(Debug, Clone)]
pub struct Flow {
    state: Rc<RefCell<State>>,
    node: NodeId,
    scope: String,
}

impl Network {
    /// Starts a network with its registry name.
    pub fn new(name: &str) -> Self {
        Network { state: Rc::new(RefCell::new(State { name: name.into(), ..State::default() })) }
    }

    /// Adds an input of `shape`, batch axis left out.
    pub fn input(&self, name: &str, shape: &[usize]) -> Flow {
        let mut state = self.state.borrow_mut();
        if axis_names(shape.len()).is_empty() || shape.contains(&0) {
            state.error.get_or_insert(Error::node(
                name,
                format!("an input needs 1 to 4 axes of at least 1, got {shape:?}"),
            ));
        }
        let node = state.nodes.len();
        state.nodes.push(Node {
            name: name.into(),
            op: Op::Input,
            inputs: vec![],
            shape: shape.to_vec(),
            params: vec![],
        });
        state.inputs.push(node);
        Flow { state: Rc::clone(&self.state), node, scope: String::new() }
    }

    /// How weights and biases of the convolutions that follow are drawn, in place of PyTorch's default.
    ///
    /// The run's [`crate::Scheme`] must leave the choice to the network (`pytorch`).
    pub fn conv_init(&self, weight: Fill, bias: Fill) {
        self.state.borrow_mut().conv = (weight, bias);
    }

    /// The same for the linear layers that follow.
    pub fn linear_init(&self, weight: Fill, bias: Fill) {
        self.state.borrow_mut().linear = (weight, bias);
    }

    /// Joins flows along channels (or features). All other axes must agree.
    pub fn concat(&self, name: &str, flows: &[&Flow]) -> Flow {
        let Some(first) = flows.first() else {
            let mut state = self.state.borrow_mut();
            state.error.get_or_insert(Error::node(name, "nothing to concatenate"));
            return Flow { state: Rc::clone(&self.state), node: 0, scope: String::new() };
        };
        let inputs: Vec<NodeId> = flows.iter().map(|f| f.node).collect();
        let shapes: Vec<Vec<usize>> = flows.iter().map(|f| f.shape()).collect();
        let root = Flow { scope: String::new(), ..(*first).clone() };
        root.push(name, Op::Concat, inputs, |node| {
            let mut shape = shapes[0].clone();
            for other in &shapes[1..] {
                if other.len() != shape.len() || other[1..] != shape[1..] {
                    return Err(Error::node(
                        node,
                        format!(
                            "cannot join {} and {} along channels",
                            describe(&shapes[0]),
                            describe(other)
                        ),
                    ));
                }
                shape[0] += other[0];
            }
            Ok((shape, vec![]))
        })
    }

    /// Ends the description: the graph, or the first step that did not fit. Every output counts 1 in training.
    pub fn finish(self, outputs: &[(&str, Flow)]) -> Result<Graph> {
        let weights = vec![1.0; outputs.len()];
        self.finish_weighted(outputs, &weights)
    }

    /// The same with what each output counts in training (see [`Graph::loss_weights`]).
    pub fn finish_weighted(self, outputs: &[(&str, Flow)], loss_weights: &[f32]) -> Result<Graph> {
        let state = self.state.borrow();
        if let Some(error) = &state.error {
            return Err(error.clone());
        }
        if outputs.is_empty() || outputs.len() != loss_weights.len() {
            return Err(Error::node(&state.name, "needs at least one output, and a loss weight for each"));
        }
        let mut seen = std::collections::HashSet::new();
        for node in &state.nodes {
            if !seen.insert(node.name.as_str()) {
                return Err(Error::node(&node.name, "two nodes carry this name"));
            }
        }
        Ok(Graph {
            name: state.name.clone(),
            nodes: state.nodes.clone(),
            inputs: state.inputs.clone(),
            outputs: outputs.iter().map(|(name, flow)| (name.to_string(), flow.node)).collect(),
            loss_weights: loss_weights.to_vec(),
        })
    }
}

impl Flow {
    /// Current shape without the batch axis.
    pub fn shape(&self) -> Vec<usize> {
        self.state.borrow().nodes.get(self.node).map(|n| n.shape.clone()).unwrap_or_default()
    }

    /// Puts `prefix.` before the names of all following nodes.
    pub fn within(mut self, prefix: &str) -> Self {
        self.scope = if self.scope.is_empty() { prefix.into() } else { format!("{}.{prefix}", self.scope) };
        self
    }

    /// Puts nothing before the names of all following nodes.
    pub fn outside(mut self) -> Self {
        self.scope.clear();
        self
    }

    /// Convolution `name`, drawn as [`Network::conv_init`] says.
    pub fn conv(&self, name: &str, conv: Conv) -> Flow {
        let shape = self.shape();
        let Conv { filters, window, groups, bias } = conv;
        let resolved = window.resolve(&self.full(name), &shape);
        let placeholder = Window { kernel: vec![], stride: vec![], padding: vec![] };
        let op = Op::Conv { window: resolved.clone().unwrap_or(placeholder), groups, bias };
        let fills = self.state.borrow().conv;
        self.push(name, op, vec![self.node], |node| {
            let window = resolved?;
            let channels = shape[0];
            if filters == 0
                || groups == 0
                || !channels.is_multiple_of(groups)
                || !filters.is_multiple_of(groups)
            {
                return Err(Error::node(
                    node,
                    format!("{groups} groups must divide {channels} input and {filters} output channels"),
                ));
            }
            let mut out = vec![filters];
            out.extend(window.positions(&shape[1..]));
            let mut weight = vec![filters, channels / groups];
            weight.extend(&window.kernel);
            let fan_in = channels / groups * window.volume();
            let fan_out = filters / groups * window.volume();
            Ok((out, weight_and_bias(node, weight, (fan_in, fan_out), bias, fills)?))
        })
    }

    /// Fully connected layer `name`, drawn as [`Network::linear_init`] says.
    pub fn linear(&self, name: &str, outputs: usize) -> Flow {
        self.dense(name, outputs, true)
    }

    /// Fully connected layer `name` without a bias.
    pub fn linear_no_bias(&self, name: &str, outputs: usize) -> Flow {
        self.dense(name, outputs, false)
    }

    fn dense(&self, name: &str, outputs: usize, bias: bool) -> Flow {
        let shape = self.shape();
        let fills = self.state.borrow().linear;
        self.push(name, Op::Linear { bias }, vec![self.node], |node| {
            let &[inputs] = shape.as_slice() else {
                return Err(Error::node(node, format!("needs features, the input is {}", describe(&shape))));
            };
            if outputs == 0 {
                return Err(Error::node(node, "must have at least one output"));
            }
            let weight = vec![outputs, inputs];
            Ok((vec![outputs], weight_and_bias(node, weight, (inputs, outputs), bias, fills)?))
        })
    }

    /// Batch normalisation `name` with PyTorch's ε and momentum.
    pub fn batch_norm(&self, name: &str) -> Flow {
        self.batch_norm_with(name, BATCH_NORM_EPS, BATCH_NORM_MOMENTUM)
    }

    /// Batch normalisation `name`; ε above 0, momentum (weight of the new batch) in 0..=1.
    pub fn batch_norm_with(&self, name: &str, eps: f32, momentum: f32) -> Flow {
        let shape = self.shape();
        self.push(name, Op::BatchNorm { eps, momentum }, vec![self.node], |node| {
            if !(eps > 0.0 && eps.is_finite() && (0.0..=1.0).contains(&momentum)) {
                return Err(Error::node(
                    node,
                    format!("ε {eps} must be above 0 and momentum {momentum} in 0..=1"),
                ));
            }
            let tensor = |suffix: &str, kind, value| Param {
                name: format!("{node}.{suffix}"),
                shape: vec![shape[0]],
                kind,
                init: Init::Constant(value),
                fan: None,
            };
            let params = vec![
                tensor("weight", Kind::Parameter, 1.0),
                tensor("bias", Kind::Parameter, 0.0),
                tensor("running_mean", Kind::Buffer, 0.0),
                tensor("running_var", Kind::Buffer, 1.0),
            ];
            Ok((shape.clone(), params))
        })
    }

    /// Rectified linear unit.
    pub fn relu(&self) -> Flow {
        let shape = self.shape();
        self.push_unnamed(Op::Relu, vec![self.node], |_| Ok((shape, vec![])))
    }

    /// A function of each value.
    pub fn activation(&self, activation: Activation) -> Flow {
        let shape = self.shape();
        self.push_unnamed(Op::Activation(activation), vec![self.node], |node| match activation {
            Activation::LeakyRelu { slope } if !slope.is_finite() => {
                Err(Error::node(node, format!("slope {slope} must be finite")))
            }
            _ => Ok((shape, vec![])),
        })
    }

    /// Dropout; `probability` is the share of values dropped, in 0..1.
    pub fn dropout(&self, probability: f32) -> Flow {
        let shape = self.shape();
        self.push_unnamed(Op::Dropout { probability }, vec![self.node], |node| {
            if !(0.0..1.0).contains(&probability) {
                return Err(Error::node(
                    node,
                    format!("drop probability {probability} must be at least 0 and below 1"),
                ));
            }
            Ok((shape, vec![]))
        })
    }

    /// LSTM layer `name` over the length axis: channels × length → `hidden` features after the last step.
    ///
    /// All tensors start uniform in ±1/√hidden, as in PyTorch. Under [`crate::Scheme::Glorot`] and
    /// [`crate::Scheme::He`] the four gates count as outputs and biases are zero; MATLAB's orthogonal
    /// recurrent weights and forget bias of 1 are not among the schemes.
    pub fn lstm(&self, name: &str, hidden: usize) -> Flow {
        let shape = self.shape();
        let op = Op::Lstm { hidden, steps: shape.get(1).copied().unwrap_or_default() };
        self.push(name, op, vec![self.node], |node| {
            let &[channels, _] = shape.as_slice() else {
                return Err(Error::node(
                    node,
                    format!("needs channels × length, the input is {}", describe(&shape)),
                ));
            };
            if hidden == 0 {
                return Err(Error::node(node, "must have at least one hidden unit"));
            }
            let gates = 4 * hidden;
            let tensor = |suffix: &str, shape, fan| Param {
                name: format!("{node}.{suffix}"),
                shape,
                kind: Kind::Parameter,
                init: Init::Uniform { bound: 1.0 / (hidden as f32).sqrt() },
                fan,
            };
            let params = vec![
                tensor("weight_ih_l0", vec![gates, channels], Some((channels, gates))),
                tensor("weight_hh_l0", vec![gates, hidden], Some((hidden, gates))),
                tensor("bias_ih_l0", vec![gates], None),
                tensor("bias_hh_l0", vec![gates], None),
            ];
            Ok((vec![hidden], params))
        })
    }

    /// The flow times one learned scalar, a tensor of one value called `name` that starts at `initial`.
    pub fn scale(&self, name: &str, initial: f32) -> Flow {
        let shape = self.shape();
        self.push(name, Op::Scale, vec![self.node], |node| {
            let scalar = Param {
                name: node.into(),
                shape: vec![1],
                kind: Kind::Parameter,
                init: Init::Constant(initial),
                fan: None,
            };
            Ok((shape, vec![scalar]))
        })
    }

    /// Channels of `groups` groups dealt out in turn, as in ShuffleNet.
    pub fn channel_shuffle(&self, groups: usize) -> Flow {
        let shape = self.shape();
        self.push_unnamed(Op::ChannelShuffle { groups }, vec![self.node], |node| {
            if groups == 0 || !shape[0].is_multiple_of(groups) {
                let described = describe(&shape);
                return Err(Error::node(
                    node,
                    format!("{groups} groups must divide the channels; the input is {described}"),
                ));
            }
            Ok((shape, vec![]))
        })
    }

    /// Channels (or features) `start..start + len`.
    pub fn slice(&self, start: usize, len: usize) -> Flow {
        let shape = self.shape();
        self.push_unnamed(Op::Slice { start, len }, vec![self.node], |node| {
            let end = start.checked_add(len).filter(|&end| len > 0 && end <= shape[0]);
            if end.is_none() {
                let described = describe(&shape);
                return Err(Error::node(
                    node,
                    format!("cannot take {len} channels from channel {start} on; the input is {described}"),
                ));
            }
            let mut out = shape.clone();
            out[0] = len;
            Ok((out, vec![]))
        })
    }

    /// Less a mean, over a standard deviation, per channel: tensors of those names, 0 and 1 until they are set.
    pub fn standardize(&self, mean: &str, std: &str) -> Flow {
        let shape = self.shape();
        let names = [self.full(mean), self.full(std)];
        self.push_unnamed(Op::Standardize, vec![self.node], |_| {
            let tensor = |name: &String, value| Param {
                name: name.clone(),
                shape: vec![shape[0]],
                kind: Kind::Buffer,
                init: Init::Constant(value),
                fan: None,
            };
            let params = vec![tensor(&names[0], 0.0), tensor(&names[1], 1.0)];
            Ok((shape.clone(), params))
        })
    }

    /// The flow, or zeros in samples where each channel of `stream` is constant.
    pub fn switch_scale(&self, stream: &Flow) -> Flow {
        let (shape, seen) = (self.shape(), stream.shape());
        self.push_unnamed(Op::SwitchScale, vec![self.node, stream.node], |node| {
            if seen.len() < 2 {
                return Err(Error::node(
                    node,
                    format!("the stream needs a spatial axis, it is {}", describe(&seen)),
                ));
            }
            Ok((shape, vec![]))
        })
    }

    /// Convolution `prefix.conv`, batch norm `prefix.bn`, ReLU.
    pub fn conv_bn_relu(&self, prefix: &str, conv: Conv) -> Flow {
        self.conv(&format!("{prefix}.conv"), conv).batch_norm(&format!("{prefix}.bn")).relu()
    }

    /// Batch norm `name`, ReLU: the pre-activation of DenseNet.
    pub fn bn_relu(&self, name: &str) -> Flow {
        self.batch_norm(name).relu()
    }

    /// Maximum over windows.
    pub fn max_pool(&self, pool: Pool) -> Flow {
        self.pool(pool, |window, _| Op::MaxPool(window))
    }

    /// Mean over windows.
    pub fn average_pool(&self, pool: Pool) -> Flow {
        self.pool(pool, |window, counted| Op::AveragePool { window, counted })
    }

    fn pool(&self, pool: Pool, op: impl FnOnce(Window, Vec<(usize, usize)>) -> Op) -> Flow {
        let shape = self.shape();
        let node = format!("{}.pool", self.name());
        let fitted = pool.window.resolve(&node, &shape);
        let unrounded = crate::op::WindowSpec { round_up: false, ..pool.window }.resolve(&node, &shape);
        let empty = || Window { kernel: vec![], stride: vec![], padding: vec![] };
        let counted = match &unrounded {
            Ok(window) if pool.count_padding => window.padding.clone(),
            Ok(window) => vec![(0, 0); window.padding.len()],
            Err(_) => vec![],
        };
        let op = op(fitted.clone().unwrap_or_else(|_| empty()), counted);
        self.push_unnamed(op, vec![self.node], |node| {
            let window = fitted?;
            if window.padding.iter().zip(&window.kernel).any(|(pad, kernel)| pad.0 > kernel / 2) {
                return Err(Error::node(node, "padding must be at most half of the kernel"));
            }
            let mut out = vec![shape[0]];
            out.extend(window.positions(&shape[1..]));
            Ok((out, vec![]))
        })
    }

    /// Mean over all spatial axes.
    pub fn global_average_pool(&self) -> Flow {
        let shape = self.shape();
        self.push_unnamed(Op::GlobalAveragePool, vec![self.node], |node| {
            if shape.len() < 2 {
                return Err(Error::node(
                    node,
                    format!("needs a spatial axis, the input is {}", describe(&shape)),
                ));
            }
            Ok((vec![shape[0]], vec![]))
        })
    }

    /// Mean over windows that cut each spatial axis into `output` parts.
    pub fn adaptive_average_pool(&self, output: impl Into<Extent>) -> Flow {
        let shape = self.shape();
        let name = self.fresh("adaptive_average_pool");
        let resolved = match shape.len() {
            0 | 1 => {
                Err(Error::node(&name, format!("needs a spatial axis, the input is {}", describe(&shape))))
            }
            rank => output.into().resolve(&name, "output", rank - 1),
        };
        let op = Op::AdaptiveAveragePool { output: resolved.clone().unwrap_or_default() };
        self.push_unnamed(op, vec![self.node], |node| {
            let output = resolved?;
            if output.contains(&0) {
                return Err(Error::node(node, format!("output {output:?} must be at least 1")));
            }
            Ok(([&shape[..1], &output].concat(), vec![]))
        })
    }

    /// All axes to features, channels first.
    pub fn flatten(&self) -> Flow {
        let shape = self.shape();
        self.push_unnamed(Op::Flatten, vec![self.node], |_| Ok((vec![shape.iter().product()], vec![])))
    }

    /// Sum with another flow of the same shape: a residual connection.
    pub fn add(&self, other: &Flow) -> Flow {
        let (a, b) = (self.shape(), other.shape());
        self.push_unnamed(Op::Add, vec![self.node, other.node], |node| {
            if a != b {
                return Err(Error::node(node, format!("cannot add {} and {}", describe(&a), describe(&b))));
            }
            Ok((a, vec![]))
        })
    }

    /// Joined with another flow along channels: a dense connection.
    pub fn concat(&self, other: &Flow) -> Flow {
        let net = Network { state: Rc::clone(&self.state) };
        let joined = net.concat(&self.fresh("concat"), &[self, other]);
        Flow { scope: self.scope.clone(), ..joined }
    }

    fn name(&self) -> String {
        self.state.borrow().nodes.get(self.node).map(|n| n.name.clone()).unwrap_or_default()
    }

    fn full(&self, name: &str) -> String {
        if self.scope.is_empty() { name.into() } else { format!("{}.{name}", self.scope) }
    }

    /// A name for a node without tensors: after its input, numbered when taken.
    fn fresh(&self, kind: &str) -> String {
        let base = format!("{}/{kind}", self.name());
        let state = self.state.borrow();
        let taken = |name: &str| state.nodes.iter().any(|n| n.name == name);
        let mut name = base.clone();
        let mut count = 2;
        while taken(&name) {
            name = format!("{base}{count}");
            count += 1;
        }
        name
    }

    fn push_unnamed<F>(&self, op: Op, inputs: Vec<NodeId>, infer: F) -> Flow
    where
        F: FnOnce(&str) -> Result<(Vec<usize>, Vec<Param>)>,
    {
        let name = self.fresh(op.kind());
        let pushed = Flow { scope: String::new(), ..self.clone() }.push(&name, op, inputs, infer);
        Flow { scope: self.scope.clone(), ..pushed }
    }

    fn push<F>(&self, name: &str, op: Op, inputs: Vec<NodeId>, infer: F) -> Flow
    where
        F: FnOnce(&str) -> Result<(Vec<usize>, Vec<Param>)>,
    {
        let mut state = self.state.borrow_mut();
        if state.error.is_some() {
            return self.clone();
        }
        let name = self.full(name);
        match infer(&name) {
            Ok((shape, params)) => {
                let node = state.nodes.len();
                state.nodes.push(Node { name, op, inputs, shape, params });
                Flow { node, ..self.clone() }
            }
            Err(error) => {
                state.error = Some(error);
                self.clone()
            }
        }
    }
}

/// The tensors of a convolution or linear layer.
fn weight_and_bias(
    node: &str,
    shape: Vec<usize>,
    fan: (usize, usize),
    bias: bool,
    fills: (Fill, Fill),
) -> Result<Vec<Param>> {
    let (outputs, weight) = (shape[0], shape.clone());
    let tensor = |suffix: &str, shape, fan, fill: Fill| {
        let name = format!("{node}.{suffix}");
        let init = fill.resolve(&name, &weight)?;
        Ok(Param { name, shape, kind: Kind::Parameter, init, fan })
    };
    let mut params = vec![tensor("weight", shape, Some(fan), fills.0)?];
    if bias {
        params.push(tensor("bias", vec![outputs], None, fills.1)?);
    }
    Ok(params)
}
