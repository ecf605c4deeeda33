//! A network as steps: what is computed between two stored values.

use taxel_graph::Activation;
use taxel_kernels::conv::{self, ConvKind};
use taxel_kernels::frozen::bytes::ByteScale;
use taxel_kernels::frozen::{self, Pooling, Reach};
use taxel_kernels::{Rectifier, Window3, gru, lstm};

/// Number of a step, and of the value that it computes.
pub(crate) type StepId = usize;

/// A stored value: positions × channels. Features are the channels of one position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ValueShape {
    pub size: [usize; 3],
    pub channels: usize,
}

impl ValueShape {
    pub fn features(channels: usize) -> Self {
        ValueShape { size: [1; 3], channels }
    }

    pub fn len(&self) -> usize {
        self.size.iter().product::<usize>() * self.channels
    }
}

/// A convolution with what was folded into it.
pub(crate) struct Conv {
    pub window: Window3,
    /// Distance of the inputs that neighbouring kernel values meet.
    pub dilation: [usize; 3],
    pub groups: usize,
    /// In the kernels' order.
    pub weight: Vec<f32>,
    pub bias: Vec<f32>,
    pub rectifier: Rectifier,
    pub algorithm: Algorithm,
}

impl Conv {
    /// Makes the convolution whose window is the whole image: a linear layer.
    pub fn over_all(size: [usize; 3], weight: Vec<f32>, bias: Vec<f32>, rectifier: Rectifier) -> Self {
        let window = Window3 { input: size, output: [1; 3], kernel: size, stride: [1; 3], before: [0; 3] };
        let algorithm = Algorithm::Direct;
        Conv { window, dilation: [1; 3], groups: 1, weight, bias, rectifier, algorithm }
    }
}

/// A pointwise convolution and the depthwise one that alone reads it.
pub(crate) struct Pair {
    pub first: Conv,
    pub second: Conv,
}

/// How a convolution is computed.
pub(crate) enum Algorithm {
    Direct,
    Depthwise,
    /// Fewer products, by the convolution that training uses.
    Winograd(Box<conv::Conv>),
}

impl Algorithm {
    /// Returns the convolution as training would run it.
    pub fn of(plan: conv::Conv) -> Self {
        match plan.kind() {
            ConvKind::Direct => Algorithm::Direct,
            ConvKind::Depthwise => Algorithm::Depthwise,
            ConvKind::Winograd => Algorithm::Winograd(Box::new(plan)),
        }
    }
}

/// The operation of a step.
pub(crate) enum StepOp {
    /// The network's input of this number.
    Input(usize),
    /// A convolution; a second input is added before the rectifier.
    Conv(Conv),
    /// Two convolutions, computed band after band.
    Pair(Box<Pair>),
    /// `x W + b`; weights are inputs × outputs, where inputs lie channels last.
    Linear {
        weight: Vec<f32>,
        bias: Vec<f32>,
        rectifier: Rectifier,
    },
    Lstm {
        sizes: lstm::Lstm,
        weights: [Vec<f32>; 4],
    },
    Gru {
        sizes: gru::Gru,
        weights: [Vec<f32>; 4],
    },
    /// Scale and shift per channel, where they are not all 1 and 0.
    Affine {
        scale: Option<(Vec<f32>, Vec<f32>)>,
        rectifier: Rectifier,
    },
    Activation(Activation),
    Pool {
        pooling: Pooling,
        axes: [Vec<Reach>; 3],
    },
    /// The sum of two values.
    Add {
        rectifier: Rectifier,
    },
    /// Inputs side by side along the channels.
    Concat,
    /// Channels from this one on.
    Slice(usize),
    /// Channel shuffle of so many groups.
    Shuffle(usize),
    /// Standard deviation over all positions, with what is added to the variance.
    Deviation(f32),
    /// Layer normalisation of features.
    LayerNorm {
        eps: f32,
        weight: Vec<f32>,
        bias: Vec<f32>,
    },
    /// Channels last to features with channels first.
    Flatten,
    /// The first input, or zeros where every channel of the second is constant.
    Switch,
}

impl StepOp {
    /// Returns the number of columns of zeros that a reader needs before and after the rows of its first input.
    pub fn margin(&self) -> [usize; 2] {
        match self {
            StepOp::Conv(Conv {
                window,
                dilation,
                algorithm: Algorithm::Direct | Algorithm::Depthwise,
                ..
            }) => frozen::margins(window, *dilation),
            _ => [0; 2],
        }
    }

    /// Checks whether inputs have to fill their buffers.
    pub fn needs_dense(&self) -> bool {
        match self {
            StepOp::Conv(conv) => matches!(conv.algorithm, Algorithm::Winograd(_)),
            StepOp::Linear { .. }
            | StepOp::LayerNorm { .. }
            | StepOp::Deviation(_)
            | StepOp::Activation(_)
            | StepOp::Shuffle(_)
            | StepOp::Flatten
            | StepOp::Switch => true,
            _ => false,
        }
    }

    /// Checks whether the output has to fill its buffer.
    pub fn makes_dense(&self) -> bool {
        matches!(self, StepOp::Activation(_) | StepOp::Shuffle(_) | StepOp::Flatten | StepOp::Switch)
    }

    /// Returns the rectifier of a step whose values could come out rectified at once.
    pub fn rectifier(&mut self) -> Option<&mut Rectifier> {
        match self {
            StepOp::Conv(Conv { rectifier, .. })
            | StepOp::Linear { rectifier, .. }
            | StepOp::Affine { rectifier, .. }
            | StepOp::Add { rectifier } => Some(rectifier),
            _ => None,
        }
    }
}

/// One step; its inputs are earlier steps.
pub(crate) struct FrozenStep {
    /// The node whose value it is; empty where no node has it.
    pub name: String,
    pub work: StepOp,
    pub inputs: Vec<StepId>,
    pub shape: ValueShape,
    /// How the value is written in bytes; none for floats.
    pub scale: Option<ByteScale>,
}

impl FrozenStep {
    /// Makes a step without a name, of floats.
    pub fn new(work: StepOp, inputs: Vec<StepId>, shape: ValueShape) -> Self {
        FrozenStep { name: String::new(), work, inputs, shape, scale: None }
    }

    /// Returns the same step where its inputs have the numbers `now`.
    pub fn renumbered(mut self, now: &[StepId]) -> Self {
        self.inputs.iter_mut().for_each(|input| *input = now[*input]);
        self
    }
}
