//! A network as a list that others read: its steps, their numbers and the places of their values.

use taxel_graph::{Graph, Weights};
use taxel_kernels::frozen::bytes::ByteScale;
use taxel_kernels::frozen::{ImagePlace, Pooling, Reach};
use taxel_kernels::simd::{Level, level};
use taxel_kernels::{Rectifier, Window3, lstm};

use crate::byte_kernel::Whole;
use crate::error::Result;
use crate::lower::{Purpose, lower};
use crate::places::ValuePlaces;
use crate::quantize::quantize;
use crate::ranges::Ranges;
use crate::step::{Algorithm, Conv, FrozenStep, StepId, StepOp};

/// The steps that [`Frozen::quantized`](crate::Frozen::quantized) or [`Frozen::new`](crate::Frozen::new) takes, in order.
#[derive(Debug, Clone)]
pub struct Blueprint {
    /// Name of the network.
    pub name: String,
    /// Whether all values are floats: then scales and shifts are fused products and sums. In a network in eight bits they are
    /// single operations.
    pub in_floats: bool,
    /// Names and shapes of the inputs, without the batch axis.
    pub inputs: Vec<(String, Vec<usize>)>,
    /// All steps; each reads values of earlier ones.
    pub steps: Vec<PlannedStep>,
    /// Names of the outputs, and the steps that compute them.
    pub outputs: Vec<(String, usize)>,
}

/// Checks whether products of floats are fused with sums on this processor: then networks in floats predict the same bits on all
/// others of that kind.
pub fn has_fused_products() -> bool {
    level() != Level::Portable
}

/// A step and the value that it computes.
#[derive(Debug, Clone)]
pub struct PlannedStep {
    /// The node whose value it is; empty where no node has it.
    pub name: String,
    /// The operation.
    pub op: PlannedOp,
    /// Numbers of the steps whose values it reads.
    pub inputs: Vec<usize>,
    /// How the value is written in bytes; none for floats.
    pub scale: Option<ByteScale>,
    /// The step in whose memory the value lies, and where in it. Margins hold the byte that means 0.
    pub memory: usize,
    /// Where the value lies in that memory.
    pub place: ImagePlace,
}

/// The operation of a step.
#[derive(Debug, Clone)]
pub enum PlannedOp {
    /// The network's input of this number, channels last.
    Input(usize),
    /// A convolution of bytes; a second input is added before the rectifier.
    Conv(Box<PlannedConv>),
    /// Scale and shift per channel, where they are not all 1 and 0; or another way of writing the same values.
    Map {
        /// Scales and shifts.
        affine: Option<(Vec<f32>, Vec<f32>)>,
        /// The rectifier.
        rectifier: Rectifier,
    },
    /// The sum of two values.
    Add(Rectifier),
    /// The largest value or the mean of each window, over depth, rows, columns.
    Pool {
        /// Which of both.
        pooling: Pooling,
        /// Inputs of each output.
        axes: [Vec<Reach>; 3],
    },
    /// Standard deviation over all positions, with what is added to the variance.
    Deviation(f32),
    /// Values side by side along the channels; most lie there already.
    Concat,
    /// Some channels of the input, which lie in its memory.
    Slice,
    /// Channel shuffle of so many groups.
    Shuffle(usize),
    /// Channels last to features with channels first.
    Flatten,
    /// A convolution of floats: each sum begins with the bias and adds one product after the other, fused, in the order of kernel
    /// and channels; then a second input is added.
    FloatConv(Box<PlannedFloatConv>),
    /// A linear layer of floats.
    FloatLinear(PlannedFloatLinear),
    /// An LSTM, of which the last hidden state remains.
    Lstm(Box<PlannedLstm>),
    /// Layer normalisation of features.
    LayerNorm {
        /// Number that is added to the variance.
        eps: f32,
        /// One per feature.
        weight: Vec<f32>,
        /// One per feature.
        bias: Vec<f32>,
    },
    /// An operation that others do not have, in words.
    Floats(&'static str),
}

/// A convolution of floats.
#[derive(Debug, Clone)]
pub struct PlannedFloatConv {
    /// Its window.
    pub window: Window3,
    /// Distance of the inputs that neighbouring kernel values meet.
    pub dilation: [usize; 3],
    /// Groups of channels.
    pub groups: usize,
    /// Group × kernel × channels in × channels out; depthwise kernel × channels.
    pub weight: Vec<f32>,
    /// One per filter.
    pub bias: Vec<f32>,
    /// The rectifier of the sums.
    pub rectifier: Rectifier,
    /// Whether each filter reads one channel, its own.
    pub is_depthwise: bool,
    /// Whether the runtime takes fewer products than the definition, so that sums have another order.
    pub has_fewer_products: bool,
}

/// A linear layer of floats, whose sums run side by side as in [`Linear`](taxel_kernels::frozen::Linear).
#[derive(Debug, Clone)]
pub struct PlannedFloatLinear {
    /// Inputs × outputs; inputs lie channels last.
    pub weight: Vec<f32>,
    /// One per output.
    pub bias: Vec<f32>,
    /// The rectifier of the sums.
    pub rectifier: Rectifier,
}

/// An LSTM layer with PyTorch's weights.
#[derive(Debug, Clone)]
pub struct PlannedLstm {
    /// Its sizes.
    pub sizes: lstm::Lstm,
    /// Input weights (4·hidden × channels), recurrent weights (4·hidden × hidden) and both biases; gates in the order i, f, g, o.
    pub weights: [Vec<f32>; 4],
}

/// A convolution, or a linear layer as one whose window is the whole image.
#[derive(Debug, Clone)]
pub struct PlannedConv {
    /// Its window.
    pub window: Window3,
    /// Distance of the inputs that neighbouring kernel values meet.
    pub dilation: [usize; 3],
    /// Groups of channels.
    pub groups: usize,
    /// Group × kernel × channels in × channels out; depthwise kernel × channels.
    pub weight: Vec<i8>,
    /// One unit of the sums of each filter.
    pub unit: Vec<f32>,
    /// One per filter, in those units.
    pub bias: Vec<i32>,
    /// The rectifier of the sums.
    pub rectifier: Rectifier,
    /// Whether each filter reads one channel, its own.
    pub is_depthwise: bool,
}

impl Blueprint {
    /// Lists the steps of `graph` in eight bits.
    ///
    /// # Errors
    /// Weights that do not fit the graph.
    pub fn new(graph: &Graph, weights: &Weights, ranges: &Ranges) -> Result<Self> {
        weights.check(graph)?;
        let (steps, outputs) = lower(graph, weights, Purpose::Bytes);
        let (steps, outputs) = quantize(steps, &outputs, ranges);
        Ok(Self::of(graph, steps, outputs, false))
    }

    /// Lists the steps of `graph` in floats.
    ///
    /// # Errors
    /// Weights that do not fit the graph.
    pub fn floats(graph: &Graph, weights: &Weights) -> Result<Self> {
        weights.check(graph)?;
        let (steps, outputs) = lower(graph, weights, Purpose::Floats);
        Ok(Self::of(graph, steps, outputs, true))
    }

    fn of(graph: &Graph, steps: Vec<FrozenStep>, outputs: Vec<StepId>, in_floats: bool) -> Self {
        let places = ValuePlaces::new(&steps, &outputs);
        let shapes: Vec<([usize; 3], Option<ByteScale>)> =
            steps.iter().map(|step| (step.shape.size, step.scale)).collect();
        let planned = |(id, step): (usize, FrozenStep)| PlannedStep {
            name: step.name,
            op: operation(step.work, step.inputs.first().map(|&input| shapes[input])),
            inputs: step.inputs,
            scale: step.scale,
            memory: places.roots[id],
            place: places.values[id].0,
        };
        let names = graph.outputs().iter().map(|(name, _)| name.clone());
        Blueprint {
            name: graph.name().to_string(),
            in_floats,
            inputs: graph.inputs().map(|node| (node.name.clone(), node.shape.clone())).collect(),
            steps: steps.into_iter().enumerate().map(planned).collect(),
            outputs: names.zip(outputs).collect(),
        }
    }
}

/// Returns what a step does to an input of this size that is written so.
fn operation(work: StepOp, input: Option<([usize; 3], Option<ByteScale>)>) -> PlannedOp {
    let bytes = input.and_then(|(size, scale)| Some((size, scale?)));
    match (work, bytes) {
        (StepOp::Input(number), _) => PlannedOp::Input(number),
        (StepOp::Conv(conv), Some((_, scale))) => PlannedOp::Conv(Box::new(whole(conv, scale))),
        (StepOp::Linear { weight, bias, rectifier }, Some((size, scale))) => {
            let conv = Conv::over_all(size, weight, bias, rectifier);
            PlannedOp::Conv(Box::new(whole(conv, scale)))
        }
        (StepOp::Affine { scale, rectifier }, _) => PlannedOp::Map { affine: scale, rectifier },
        (StepOp::Add { rectifier }, _) => PlannedOp::Add(rectifier),
        (StepOp::Pool { pooling, axes }, _) => PlannedOp::Pool { pooling, axes },
        (StepOp::Deviation(eps), _) => PlannedOp::Deviation(eps),
        (StepOp::Concat, _) => PlannedOp::Concat,
        (StepOp::Slice(_), _) => PlannedOp::Slice,
        (StepOp::Shuffle(groups), _) => PlannedOp::Shuffle(groups),
        (StepOp::Flatten, _) => PlannedOp::Flatten,
        (StepOp::Conv(conv), None) => PlannedOp::FloatConv(Box::new(of_floats(conv))),
        (StepOp::Pair(_), _) => PlannedOp::Floats("two convolutions band by band"),
        (StepOp::Linear { weight, bias, rectifier }, None) => {
            PlannedOp::FloatLinear(PlannedFloatLinear { weight, bias, rectifier })
        }
        (StepOp::Lstm { sizes, weights }, _) => PlannedOp::Lstm(Box::new(PlannedLstm { sizes, weights })),
        (StepOp::Gru { .. }, _) => PlannedOp::Floats("a GRU"),
        (StepOp::Activation(_), _) => PlannedOp::Floats("an activation function other than a rectifier"),
        (StepOp::LayerNorm { eps, weight, bias }, _) => PlannedOp::LayerNorm { eps, weight, bias },
        (StepOp::Switch, _) => PlannedOp::Floats("a switch between two streams"),
    }
}

fn of_floats(conv: Conv) -> PlannedFloatConv {
    let Conv { window, dilation, groups, weight, bias, rectifier, algorithm } = conv;
    PlannedFloatConv {
        window,
        dilation,
        groups,
        weight,
        bias,
        rectifier,
        is_depthwise: matches!(algorithm, Algorithm::Depthwise),
        has_fewer_products: matches!(algorithm, Algorithm::Winograd(_)),
    }
}

fn whole(conv: Conv, input: ByteScale) -> PlannedConv {
    let Conv { window, dilation, groups, weight, bias, rectifier, algorithm } = conv;
    let is_depthwise = matches!(algorithm, Algorithm::Depthwise);
    let Whole { weight, unit, bias } = Whole::of(&weight, &bias, groups, input, is_depthwise);
    PlannedConv { window, dilation, groups, weight, unit, bias, rectifier, is_depthwise }
}
