//! Output shape and tensors of an operation, inferred from its inputs, or why they do not fit.
//!
//! The builder and the reader of files both infer here, so that neither accepts a network that the other refuses.

use crate::error::{Error, Result};
use crate::fill::Fill;
use crate::graph::{Init, Node, NodeId, Param, TensorKind};
use crate::op::{Activation, Op};
use crate::shape::{axis_names, check_count, describe};
use crate::window::{Window, check_axes};

impl Node {
    /// Makes an input of the network with `shape`.
    pub(crate) fn input(name: String, shape: Vec<usize>) -> Result<Node> {
        if axis_names(shape.len()).is_empty() || shape.contains(&0) {
            let reason = format!("an input needs 1 to 4 axes of at least 1, got {shape:?}");
            return Err(Error::node(&name, reason));
        }
        check_count(&name, "an input", &shape)?;
        Ok(Node { name, op: Op::Input, inputs: vec![], shape, params: vec![] })
    }

    /// Makes the node that does `op` to `inputs` out of the `earlier` nodes. Its tensors start as PyTorch's.
    pub(crate) fn computed(name: String, op: Op, inputs: Vec<NodeId>, earlier: &[Node]) -> Result<Node> {
        let mut shapes = vec![];
        for &input in &inputs {
            let Some(node) = earlier.get(input) else {
                let reason = format!("input {input} is none of the {} nodes before it", earlier.len());
                return Err(Error::node(&name, reason));
            };
            shapes.push(node.shape.as_slice());
        }
        let (shape, params) = Inference { node: &name, op: &op, inputs: &shapes }.infer()?;
        check_count(&name, "an output", &shape)?;
        Ok(Node { name, op, inputs, shape, params })
    }

    /// Makes the node of this name that does `op` to `inputs` out of the `earlier` nodes; its tensors start as this
    /// one's.
    pub(crate) fn again(&self, op: Op, inputs: Vec<NodeId>, earlier: &[Node]) -> Result<Node> {
        if op == Op::Input {
            return Ok(self.clone());
        }
        let mut node = Node::computed(self.name.clone(), op, inputs, earlier)?;
        node.params.iter_mut().zip(&self.params).for_each(|(param, original)| param.init = original.init);
        Ok(node)
    }
}

/// Output shape and tensors.
type Inferred = Result<(Vec<usize>, Vec<Param>)>;

struct Inference<'a> {
    node: &'a str,
    op: &'a Op,
    inputs: &'a [&'a [usize]],
}

impl<'a> Inference<'a> {
    fn infer(&self) -> Inferred {
        match self.op {
            Op::Input => self.refuse("an input is given, not computed"),
            Op::Concat => self.concat(),
            Op::Add => self.add(),
            Op::SwitchScale => self.switch_scale(),
            op => {
                let x = self.only()?;
                match op {
                    Op::Conv { filters, window, dilation, groups, bias } => {
                        self.conv(x, *filters, (window, dilation), *groups, *bias)
                    }
                    Op::BatchNorm { eps, momentum } => self.batch_norm(x, *eps, *momentum),
                    Op::LayerNorm { eps } => self.layer_norm(x, *eps),
                    Op::Activation(activation) => self.activation(x, *activation),
                    Op::Dropout { probability } => self.dropout(x, *probability),
                    Op::MaxPool(window) => self.pool(x, window, &window.padding),
                    Op::AveragePool { window, counted } => self.pool(x, window, counted),
                    Op::GlobalAveragePool => Ok((vec![self.spatial(x)?[0]], vec![])),
                    Op::GlobalStandardDeviation { eps } => self.deviation(x, *eps),
                    Op::AdaptiveAveragePool { output } => self.adaptive_average_pool(x, output),
                    // An input's values are counted, so that this product does not overflow.
                    Op::Flatten => Ok((vec![x.iter().product()], vec![])),
                    Op::Linear { outputs, bias } => self.linear(x, *outputs, *bias),
                    Op::Lstm { hidden, steps } => self.recurrent(x, 4, *hidden, *steps),
                    Op::Gru { hidden, steps } => self.recurrent(x, 3, *hidden, *steps),
                    Op::Scale => Ok((x.to_vec(), vec![self.constant(self.node.into(), 1, 1.0)])),
                    Op::ChannelShuffle { groups } => self.channel_shuffle(x, *groups),
                    Op::Slice { start, len } => self.slice(x, *start, *len),
                    Op::Standardize { mean, std } => {
                        let buffer =
                            |name: &String, value| self.buffer(self.constant(name.clone(), x[0], value));
                        Ok((x.to_vec(), vec![buffer(mean, 0.0), buffer(std, 1.0)]))
                    }
                    Op::Relu | Op::Input | Op::Concat | Op::Add | Op::SwitchScale => Ok((x.to_vec(), vec![])),
                }
            }
        }
    }

    fn refuse<T>(&self, reason: impl Into<String>) -> Result<T> {
        Err(Error::node(self.node, reason))
    }

    /// Returns the shape of the one input.
    fn only(&self) -> Result<&'a [usize]> {
        match self.inputs {
            [x] => Ok(x),
            inputs => self.refuse(format!("reads one input, got {}", inputs.len())),
        }
    }

    /// Returns the shapes of the two inputs.
    fn pair(&self) -> Result<(&'a [usize], &'a [usize])> {
        match self.inputs {
            [a, b] => Ok((a, b)),
            inputs => self.refuse(format!("reads two inputs, got {}", inputs.len())),
        }
    }

    /// Returns the shape, which must have spatial axes.
    fn spatial(&self, x: &'a [usize]) -> Result<&'a [usize]> {
        if x.len() < 2 {
            return self.refuse(format!("needs a spatial axis, the input is {}", describe(x)));
        }
        Ok(x)
    }

    fn tensor(
        &self,
        suffix: &str,
        shape: Vec<usize>,
        init: Init,
        fan: Option<(usize, usize)>,
    ) -> Result<Param> {
        let name = format!("{}.{suffix}", self.node);
        check_count(self.node, &name, &shape)?;
        Ok(Param { name, shape, kind: TensorKind::Parameter, init, fan })
    }

    /// Makes a tensor of one axis that starts at one value.
    fn constant(&self, name: String, len: usize, value: f32) -> Param {
        Param { name, shape: vec![len], kind: TensorKind::Parameter, init: Init::Constant(value), fan: None }
    }

    fn buffer(&self, param: Param) -> Param {
        Param { kind: TensorKind::Buffer, ..param }
    }

    fn conv(
        &self,
        x: &[usize],
        filters: usize,
        (window, dilation): (&Window, &[usize]),
        groups: usize,
        bias: bool,
    ) -> Inferred {
        let positions = window.fit_dilated(self.node, x, dilation)?;
        let channels = x[0];
        if filters == 0 || groups == 0 || !channels.is_multiple_of(groups) || !filters.is_multiple_of(groups)
        {
            return self.refuse(format!(
                "{groups} groups must divide {channels} input and {filters} output channels"
            ));
        }
        let weight = [&[filters, channels / groups], &window.kernel[..]].concat();
        check_count(self.node, "a weight", &weight)?;
        let fan = (channels / groups * window.volume(), filters / groups * window.volume());
        let params = self.weight_and_bias(weight, fan, bias)?;
        Ok(([&[filters], &positions[..]].concat(), params))
    }

    fn linear(&self, x: &[usize], outputs: usize, bias: bool) -> Inferred {
        let &[inputs] = x else {
            return self.refuse(format!("needs features, the input is {}", describe(x)));
        };
        if outputs == 0 {
            return self.refuse("must have at least one output");
        }
        let params = self.weight_and_bias(vec![outputs, inputs], (inputs, outputs), bias)?;
        Ok((vec![outputs], params))
    }

    fn weight_and_bias(&self, weight: Vec<usize>, fan: (usize, usize), bias: bool) -> Result<Vec<Param>> {
        check_count(self.node, "a weight", &weight)?;
        let (outputs, init) = (weight[0], Fill::Pytorch.resolve(self.node, &weight)?);
        let mut params = vec![self.tensor("weight", weight, init, Some(fan))?];
        if bias {
            params.push(self.tensor("bias", vec![outputs], init, None)?);
        }
        Ok(params)
    }

    fn batch_norm(&self, x: &[usize], eps: f32, momentum: f32) -> Inferred {
        if !(eps > 0.0 && eps.is_finite() && (0.0..=1.0).contains(&momentum)) {
            return self.refuse(format!("ε {eps} must be above 0 and momentum {momentum} in 0..=1"));
        }
        let tensor = |suffix, value| self.constant(format!("{}.{suffix}", self.node), x[0], value);
        let params = vec![
            tensor("weight", 1.0),
            tensor("bias", 0.0),
            self.buffer(tensor("running_mean", 0.0)),
            self.buffer(tensor("running_var", 1.0)),
        ];
        Ok((x.to_vec(), params))
    }

    fn layer_norm(&self, x: &[usize], eps: f32) -> Inferred {
        let &[features] = x else {
            return self.refuse(format!("needs features, the input is {}", describe(x)));
        };
        if !(eps > 0.0 && eps.is_finite()) {
            return self.refuse(format!("ε {eps} must be above 0"));
        }
        let tensor = |suffix, value| self.constant(format!("{}.{suffix}", self.node), features, value);
        Ok((x.to_vec(), vec![tensor("weight", 1.0), tensor("bias", 0.0)]))
    }

    fn activation(&self, x: &[usize], activation: Activation) -> Inferred {
        match activation {
            Activation::LeakyRelu { slope } if !slope.is_finite() => {
                self.refuse(format!("slope {slope} must be finite"))
            }
            _ => Ok((x.to_vec(), vec![])),
        }
    }

    fn dropout(&self, x: &[usize], probability: f32) -> Inferred {
        if !(0.0..1.0).contains(&probability) {
            return self.refuse(format!("drop probability {probability} must be at least 0 and below 1"));
        }
        Ok((x.to_vec(), vec![]))
    }

    /// Infers the shape after a pool; `counted` is the padding that the divisor of a mean counts.
    fn pool(&self, x: &[usize], window: &Window, counted: &[(usize, usize)]) -> Inferred {
        let positions = window.fit(self.node, x)?;
        check_axes(self.node, "counted padding", counted, positions.len())?;
        for (a, &(before, after)) in window.padding.iter().enumerate() {
            if before > window.kernel[a] / 2 {
                return self.refuse("padding must be at most half of the kernel");
            }
            if (positions[a] - 1) * window.stride[a] >= x[1 + a] + before {
                return self.refuse("the last window starts after the end of the input");
            }
            if counted[a].0 > before || counted[a].1 > after {
                return self.refuse(format!("counts padding {counted:?} of {:?}", window.padding));
            }
        }
        Ok(([&x[..1], &positions].concat(), vec![]))
    }

    fn deviation(&self, x: &'a [usize], eps: f32) -> Inferred {
        if !(eps > 0.0 && eps.is_finite()) {
            return self.refuse(format!("ε {eps} must be above 0"));
        }
        Ok((vec![self.spatial(x)?[0]], vec![]))
    }

    fn adaptive_average_pool(&self, x: &'a [usize], output: &[usize]) -> Inferred {
        let axes = self.spatial(x)?.len() - 1;
        check_axes(self.node, "output", output, axes)?;
        if output.contains(&0) {
            return self.refuse(format!("output {output:?} must be at least 1"));
        }
        Ok(([&x[..1], output].concat(), vec![]))
    }

    fn recurrent(&self, x: &[usize], gates: usize, hidden: usize, steps: usize) -> Inferred {
        let &[channels, ref between @ .., length] = x else {
            return self.refuse(format!("needs channels × length, the input is {}", describe(x)));
        };
        if between.iter().any(|&size| size != 1) {
            let described = describe(x);
            return self.refuse(format!(
                "reads the last axis step by step, so all axes between it and the channels must be 1; the input is {described}"
            ));
        }
        if hidden == 0 {
            return self.refuse("must have at least one hidden unit");
        }
        if steps != length {
            return self.refuse(format!("{steps} steps, the input is {}", describe(x)));
        }
        check_count(self.node, "a weight", &[gates, hidden, hidden])?;
        let gates = gates * hidden;
        let init = Init::Uniform { bound: 1.0 / (hidden as f32).sqrt() };
        let params = vec![
            self.tensor("weight_ih_l0", vec![gates, channels], init, Some((channels, gates)))?,
            self.tensor("weight_hh_l0", vec![gates, hidden], init, Some((hidden, gates)))?,
            self.tensor("bias_ih_l0", vec![gates], init, None)?,
            self.tensor("bias_hh_l0", vec![gates], init, None)?,
        ];
        Ok((vec![hidden], params))
    }

    fn channel_shuffle(&self, x: &[usize], groups: usize) -> Inferred {
        if groups == 0 || !x[0].is_multiple_of(groups) {
            let described = describe(x);
            return self
                .refuse(format!("{groups} groups must divide the channels; the input is {described}"));
        }
        Ok((x.to_vec(), vec![]))
    }

    fn slice(&self, x: &[usize], start: usize, len: usize) -> Inferred {
        let inside = start.checked_add(len).is_some_and(|end| len > 0 && end <= x[0]);
        if !inside {
            let described = describe(x);
            return self.refuse(format!(
                "cannot take {len} channels from channel {start} on; the input is {described}"
            ));
        }
        Ok(([&[len], &x[1..]].concat(), vec![]))
    }

    fn switch_scale(&self) -> Inferred {
        let (x, stream) = self.pair()?;
        if stream.len() < 2 {
            return self.refuse(format!("the stream needs a spatial axis, it is {}", describe(stream)));
        }
        Ok((x.to_vec(), vec![]))
    }

    fn add(&self) -> Inferred {
        let (a, b) = self.pair()?;
        if a != b {
            return self.refuse(format!("cannot add {} and {}", describe(a), describe(b)));
        }
        Ok((a.to_vec(), vec![]))
    }

    fn concat(&self) -> Inferred {
        let Some((first, rest)) = self.inputs.split_first() else {
            return self.refuse("nothing to concatenate");
        };
        let mut shape = first.to_vec();
        for other in rest {
            if other.len() != shape.len() || other[1..] != shape[1..] {
                return self.refuse(format!(
                    "cannot join {} and {} along channels",
                    describe(first),
                    describe(other)
                ));
            }
            shape[0] += other[0];
        }
        Ok((shape, vec![]))
    }
}
