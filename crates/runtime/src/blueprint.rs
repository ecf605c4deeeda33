//! A network in eight bits as a list that others read: its steps, their whole numbers and the places of their values.

use taxel_graph::{Graph, Weights};
use taxel_kernels::frozen::bytes::ByteScale;
use taxel_kernels::frozen::{ImagePlace, Pooling, Reach};
use taxel_kernels::{Rectifier, Window3};

use crate::byte_kernel::Whole;
use crate::error::Result;
use crate::lower::{Purpose, lower};
use crate::places::ValuePlaces;
use crate::quantize::quantize;
use crate::ranges::Ranges;
use crate::step::{Algorithm, Conv, FrozenStep, StepOp};

/// The steps that [`Frozen::quantized`](crate::Frozen::quantized) takes, in order.
#[derive(Debug, Clone)]
pub struct Blueprint {
    /// Name of the network.
    pub name: String,
    /// Names and shapes of the inputs, without the batch axis.
    pub inputs: Vec<(String, Vec<usize>)>,
    /// All steps; each reads values of earlier ones.
    pub steps: Vec<PlannedStep>,
    /// Names of the outputs, and the steps that compute them.
    pub outputs: Vec<(String, usize)>,
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
    /// An operation between floats that has no fixed bits, in words.
    Floats(&'static str),
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
        Ok(Blueprint {
            name: graph.name().to_string(),
            inputs: graph.inputs().map(|node| (node.name.clone(), node.shape.clone())).collect(),
            steps: steps.into_iter().enumerate().map(planned).collect(),
            outputs: names.zip(outputs).collect(),
        })
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
        (StepOp::Conv(_) | StepOp::Pair(_), None) => PlannedOp::Floats("a convolution of floats"),
        (StepOp::Pair(_), _) => PlannedOp::Floats("two convolutions band by band"),
        (StepOp::Linear { .. }, None) => PlannedOp::Floats("a linear layer of floats"),
        (StepOp::Lstm { .. }, _) => PlannedOp::Floats("an LSTM"),
        (StepOp::Gru { .. }, _) => PlannedOp::Floats("a GRU"),
        (StepOp::Activation(_), _) => PlannedOp::Floats("an activation function other than a rectifier"),
        (StepOp::LayerNorm { .. }, _) => PlannedOp::Floats("a layer norm"),
        (StepOp::Switch, _) => PlannedOp::Floats("a switch between two streams"),
    }
}

fn whole(conv: Conv, input: ByteScale) -> PlannedConv {
    let Conv { window, dilation, groups, weight, bias, rectifier, algorithm } = conv;
    let is_depthwise = matches!(algorithm, Algorithm::Depthwise);
    let Whole { weight, unit, bias } = Whole::of(&weight, &bias, groups, input, is_depthwise);
    PlannedConv { window, dilation, groups, weight, unit, bias, rectifier, is_depthwise }
}
