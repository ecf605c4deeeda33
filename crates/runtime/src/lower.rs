//! From a graph to steps: norms, rectifiers and sums become part of the step before them.

use taxel_graph::{Activation, Graph, Node, NodeId, Op, Weights, Window};
use taxel_kernels::frozen::{self, Pooling, half};
use taxel_kernels::{Rectifier, Window3, axes3, conv, gru, lstm};

use crate::merge::merge;
use crate::step::{Algorithm, Conv, FrozenStep, StepId, StepOp, ValueShape};
use crate::weights;

/// The purpose of the steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Answers in floats.
    Floats,
    /// The same with products of bf16.
    Half,
    /// Answers in bytes, or to see what values those will hold: convolutions are computed by their definition.
    Bytes,
}

/// Returns the steps of a graph, and the steps of its outputs. `weights` have been checked against it.
pub(crate) fn lower(graph: &Graph, weights: &Weights, purpose: Purpose) -> (Vec<FrozenStep>, Vec<StepId>) {
    let mut uses = vec![0; graph.nodes().len()];
    graph.nodes().iter().flat_map(|node| &node.inputs).for_each(|&input| uses[input] += 1);
    // What callers read stays as it is.
    graph.outputs().iter().for_each(|(_, id)| uses[*id] += 2);
    let mut lower = Lower { weights, purpose, uses, steps: vec![], seen: vec![], inputs: 0 };
    for node in graph.nodes() {
        let seen = lower.node(node);
        if !seen.flat {
            lower.steps[seen.step].name = node.name.clone();
        }
        lower.seen.push(seen);
    }
    let outputs: Vec<StepId> = graph.outputs().iter().map(|(_, id)| lower.output(*id)).collect();
    let (steps, now) = merge(lower.steps);
    (steps, outputs.into_iter().map(|output| now[output]).collect())
}

/// How a node's value is found.
#[derive(Clone, Copy)]
struct NodeValue {
    step: StepId,
    /// Whether it is that value with channels first, as features.
    flat: bool,
}

struct Lower<'a> {
    weights: &'a Weights,
    purpose: Purpose,
    /// Readers of every node.
    uses: Vec<usize>,
    steps: Vec<FrozenStep>,
    seen: Vec<NodeValue>,
    inputs: usize,
}

impl Lower<'_> {
    fn node(&mut self, node: &Node) -> NodeValue {
        let at = |which: usize| node.inputs[which];
        match &node.op {
            Op::Input => {
                self.inputs += 1;
                self.push(StepOp::Input(self.inputs - 1), vec![], node)
            }
            Op::Conv { window, dilation, groups, bias, .. } => {
                self.conv(node, window, dilation, *groups, *bias)
            }
            Op::Linear { bias, .. } => {
                let seen = self.seen[at(0)];
                let positions = if seen.flat { self.steps[seen.step].shape.size.iter().product() } else { 1 };
                let weight = weights::linear(self.weights, node, positions);
                let bias = weights::bias(self.weights, node, *bias, node.shape[0]);
                self.push(StepOp::Linear { weight, bias, rectifier: Rectifier::None }, vec![seen.step], node)
            }
            &Op::Lstm { hidden, steps } => {
                let (input, channels, weights) = self.recurrent(node);
                let sizes = lstm::Lstm { channels, steps, hidden };
                self.push(StepOp::Lstm { sizes, weights }, vec![input], node)
            }
            &Op::Gru { hidden, steps } => {
                let (input, channels, weights) = self.recurrent(node);
                let sizes = gru::Gru { channels, steps, hidden };
                self.push(StepOp::Gru { sizes, weights }, vec![input], node)
            }
            Op::BatchNorm { eps, .. } => {
                let norm = weights::norm(self.weights, node, *eps);
                self.affine(node, &norm)
            }
            Op::Standardize { .. } => {
                let [mean, std] = [0, 1].map(|which| weights::values(self.weights, node, which));
                let one =
                    |(mean, std): (&f32, &f32)| (1.0 / f64::from(*std), -f64::from(*mean) / f64::from(*std));
                let norm: Vec<(f64, f64)> = mean.iter().zip(std).map(one).collect();
                self.affine(node, &norm)
            }
            Op::Scale => {
                let scale = f64::from(weights::values(self.weights, node, 0)[0]);
                self.affine(node, &vec![(scale, 0.0); node.shape[0]])
            }
            Op::LayerNorm { eps } => {
                let input = self.stored(at(0));
                let [weight, bias] = [0, 1].map(|which| weights::values(self.weights, node, which).to_vec());
                self.push(StepOp::LayerNorm { eps: *eps, weight, bias }, vec![input], node)
            }
            Op::Relu => self.rectify(node, Rectifier::Relu),
            Op::Activation(Activation::Relu6) => self.rectify(node, Rectifier::Relu6),
            Op::Activation(function) => {
                let input = self.stored(at(0));
                self.push(StepOp::Activation(*function), vec![input], node)
            }
            Op::Dropout { .. } => self.seen[at(0)],
            Op::MaxPool(window) => self.pool(node, Pooling::Max, window, &[]),
            Op::AveragePool { window, counted } => self.pool(node, Pooling::Mean, window, counted),
            Op::GlobalAveragePool => {
                let input = self.stored(at(0));
                let axes = frozen::parts(self.steps[input].shape.size, [1; 3]);
                self.push(StepOp::Pool { pooling: Pooling::Mean, axes }, vec![input], node)
            }
            Op::GlobalStandardDeviation { eps } => {
                let input = self.stored(at(0));
                self.push(StepOp::Deviation(*eps), vec![input], node)
            }
            Op::AdaptiveAveragePool { .. } => {
                let input = self.stored(at(0));
                let axes = frozen::parts(self.steps[input].shape.size, shape_of(node).size);
                self.push(StepOp::Pool { pooling: Pooling::Mean, axes }, vec![input], node)
            }
            Op::Flatten => {
                let input = self.stored(at(0));
                NodeValue { step: input, flat: true }
            }
            Op::ChannelShuffle { groups } => {
                let input = self.stored(at(0));
                self.push(StepOp::Shuffle(*groups), vec![input], node)
            }
            Op::Slice { start, .. } => {
                let input = self.stored(at(0));
                self.push(StepOp::Slice(*start), vec![input], node)
            }
            Op::SwitchScale => {
                let inputs = vec![self.stored(at(0)), self.stored(at(1))];
                self.push(StepOp::Switch, inputs, node)
            }
            Op::Add => self.add(node),
            Op::Concat => {
                let inputs = node.inputs.iter().map(|&input| self.stored(input)).collect();
                self.push(StepOp::Concat, inputs, node)
            }
        }
    }

    fn push(&mut self, work: StepOp, inputs: Vec<StepId>, node: &Node) -> NodeValue {
        self.steps.push(FrozenStep::new(work, inputs, shape_of(node)));
        NodeValue { step: self.steps.len() - 1, flat: false }
    }

    /// Returns the step that stores a node's value as it is; flattens it where no one has.
    fn stored(&mut self, id: NodeId) -> StepId {
        let NodeValue { step, flat } = self.seen[id];
        if flat {
            let step = self.flatten(step);
            self.seen[id] = NodeValue { step, flat: false };
        }
        self.seen[id].step
    }

    /// Adds the step that stores a value with channels first, as features.
    fn flatten(&mut self, step: StepId) -> StepId {
        let shape = ValueShape::features(self.steps[step].shape.len());
        self.steps.push(FrozenStep::new(StepOp::Flatten, vec![step], shape));
        self.steps.len() - 1
    }

    /// Returns the input of a recurrent layer, its channels, and the four tensors.
    fn recurrent(&mut self, node: &Node) -> (StepId, usize, [Vec<f32>; 4]) {
        let input = self.stored(node.inputs[0]);
        let weights = [0, 1, 2, 3].map(|which| weights::values(self.weights, node, which).to_vec());
        (input, self.steps[input].shape.channels, weights)
    }

    /// Returns the step that stores a node's value in the order in which callers read it.
    fn output(&mut self, id: NodeId) -> StepId {
        let step = self.stored(id);
        if self.steps[step].shape.size == [1; 3] { step } else { self.flatten(step) }
    }

    fn conv(
        &mut self,
        node: &Node,
        window: &Window,
        dilation: &[usize],
        groups: usize,
        has_bias: bool,
    ) -> NodeValue {
        let input = self.stored(node.inputs[0]);
        let (channels, filters) = (self.steps[input].shape.channels, node.shape[0]);
        let (window, dilation) =
            (window3(window, dilation, self.steps[input].shape.size), axes3(dilation, 1));
        let plan = conv::Conv::dilated(window, dilation, channels, filters, groups);
        let conv = Conv {
            window,
            dilation,
            groups,
            weight: weights::conv(self.weights, node, groups),
            bias: weights::bias(self.weights, node, has_bias, filters),
            rectifier: Rectifier::None,
            algorithm: match (Algorithm::of(plan), self.purpose) {
                (Algorithm::Winograd(_), Purpose::Bytes) => Algorithm::Direct,
                (Algorithm::Winograd(plan), Purpose::Half)
                    if !half::Winograd::pays(&window, plan.kind(), channels, filters) =>
                {
                    Algorithm::Direct
                }
                (algorithm, _) => algorithm,
            },
        };
        self.push(StepOp::Conv(conv), vec![input], node)
    }

    /// Checks whether nobody but one reader sees the value of `id` as its step stores it.
    fn is_private(&self, id: NodeId) -> bool {
        self.uses[id] == 1 && !self.seen[id].flat
    }

    /// Adds scale and shift per channel, or folds them into what comes before where nobody else sees that.
    fn affine(&mut self, node: &Node, norm: &[(f64, f64)]) -> NodeValue {
        let id = node.inputs[0];
        let seen = self.seen[id];
        if self.is_private(id) {
            let step = &mut self.steps[seen.step];
            match &mut step.work {
                StepOp::Conv(conv) if conv.rectifier == Rectifier::None && step.inputs.len() == 1 => {
                    // Depthwise weights are kernel × channels: one group of all.
                    let groups = if let Algorithm::Depthwise = conv.algorithm { 1 } else { conv.groups };
                    weights::fold(&mut conv.weight, &mut conv.bias, groups, norm);
                    return seen;
                }
                StepOp::Linear { weight, bias, rectifier: Rectifier::None } => {
                    weights::fold(weight, bias, 1, norm);
                    return seen;
                }
                _ => {}
            }
        }
        let input = self.stored(id);
        let scale = norm.iter().map(|(scale, shift)| (*scale as f32, *shift as f32)).unzip();
        self.push(StepOp::Affine { scale: Some(scale), rectifier: Rectifier::None }, vec![input], node)
    }

    /// Adds a rectifier, or leaves it to what comes before where nobody else sees that.
    fn rectify(&mut self, node: &Node, which: Rectifier) -> NodeValue {
        let id = node.inputs[0];
        let seen = self.seen[id];
        if self.is_private(id)
            && let Some(rectifier) = self.steps[seen.step].work.rectifier()
            && *rectifier == Rectifier::None
        {
            *rectifier = which;
            return seen;
        }
        let input = self.stored(id);
        self.push(StepOp::Affine { scale: None, rectifier: which }, vec![input], node)
    }

    /// Adds a sum, or leaves it to the later of two convolutions where nobody else sees what that stores.
    fn add(&mut self, node: &Node) -> NodeValue {
        let inputs: Vec<StepId> = node.inputs.iter().map(|&input| self.stored(input)).collect();
        for (mine, other) in [(0, 1), (1, 0)] {
            let (conv, addend) = (inputs[mine], inputs[other]);
            if !self.is_private(node.inputs[mine]) || addend >= conv {
                continue;
            }
            let step = &mut self.steps[conv];
            if let StepOp::Conv(Conv { algorithm, rectifier: Rectifier::None, .. }) = &step.work
                && step.inputs.len() == 1
                && (matches!(algorithm, Algorithm::Direct)
                    || self.purpose == Purpose::Half && matches!(algorithm, Algorithm::Winograd(_)))
            {
                step.inputs.push(addend);
                return NodeValue { step: conv, flat: false };
            }
        }
        self.push(StepOp::Add { rectifier: Rectifier::None }, inputs, node)
    }

    fn pool(
        &mut self,
        node: &Node,
        pooling: Pooling,
        window: &Window,
        counted: &[(usize, usize)],
    ) -> NodeValue {
        let input = self.stored(node.inputs[0]);
        let window = window3(window, &[], self.steps[input].shape.size);
        let axes = frozen::windows(&window, &axes3(counted, (0, 0)));
        self.push(StepOp::Pool { pooling, axes }, vec![input], node)
    }
}

/// Returns positions and channels of a node's value.
fn shape_of(node: &Node) -> ValueShape {
    ValueShape { size: axes3(&node.shape[1..], 1), channels: node.shape[0] }
}

/// Makes a window over (depth, rows, columns); its outputs are those of a kernel whose values meet inputs `dilation`
/// apart (empty: neighbours).
fn window3(window: &Window, dilation: &[usize], input: [usize; 3]) -> Window3 {
    let spatial = &input[3 - window.kernel.len()..];
    let before: Vec<usize> = window.padding.iter().map(|p| p.0).collect();
    let output = window.dilated(dilation).positions(spatial);
    Window3::over(spatial, &output, &window.kernel, &window.stride, &before)
}
