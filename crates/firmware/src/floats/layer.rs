//! The layers of floats that C computes. Weights lie as four neighbouring filters at a time, filled up with zeros.

use taxel_kernels::Rectifier;

/// The computation of a layer of floats.
#[derive(Debug, Clone)]
pub(crate) enum FloatWork {
    /// A convolution; a second input is added before the rectifier.
    Conv(FloatConv),
    /// A convolution in which each filter reads one channel.
    Depthwise(FloatDepthwise),
    /// A linear layer.
    Linear(FloatLinear),
    /// A fused product and sum per channel, where there is one, and a rectifier.
    Map { affine: Option<(Vec<f32>, Vec<f32>)>, rectifier: Rectifier },
    /// The standard deviation over all positions: a share of the sums, and what is added to the variance.
    Deviation { share: f32, eps: f32 },
    /// The last hidden state of an LSTM.
    Lstm(Lstm),
    /// Layer normalisation of features.
    Norm { eps: f32, weight: Vec<f32>, bias: Vec<f32> },
}

/// Weights of fours of filters, and where their sums begin.
#[derive(Debug, Clone)]
pub(crate) struct Fours {
    pub weight: Vec<f32>,
    pub bias: Vec<f32>,
}

/// A convolution.
#[derive(Debug, Clone)]
pub(crate) struct FloatConv {
    pub fours: Fours,
    /// Where the first window begins, in the input's memory.
    pub first: usize,
    /// Distance of the inputs of neighbouring outputs.
    pub step: usize,
    /// Stretches of inputs, their distance and their length.
    pub segments: usize,
    pub apart: usize,
    pub run: usize,
    pub groups: usize,
    /// Channels of a group.
    pub channels: usize,
    pub rectifier: Rectifier,
}

/// A depthwise convolution; weights lie as kernel × channels.
#[derive(Debug, Clone)]
pub(crate) struct FloatDepthwise {
    pub weight: Vec<f32>,
    pub bias: Vec<f32>,
    pub first: usize,
    pub step: usize,
    pub taps: usize,
    pub apart: usize,
    pub rectifier: Rectifier,
}

/// A linear layer.
#[derive(Debug, Clone)]
pub(crate) struct FloatLinear {
    pub fours: Fours,
    pub inputs: usize,
    pub rectifier: Rectifier,
}

/// An LSTM layer.
#[derive(Debug, Clone)]
pub(crate) struct Lstm {
    /// Weights of the inputs with both biases, and of the hidden state.
    pub inputs: Fours,
    pub hidden_weight: Vec<f32>,
    pub channels: usize,
    pub steps: usize,
    pub hidden: usize,
    /// The memory of its gates and cells.
    pub work: usize,
}

impl FloatWork {
    /// Checks whether products are fused with sums, for which a processor needs an FPU.
    pub fn is_fused(&self) -> bool {
        !matches!(self, FloatWork::Norm { .. })
    }

    /// Returns the products of weights and values of a layer that stores `positions` × `channels`.
    pub fn macs(&self, positions: usize, channels: usize) -> usize {
        match self {
            FloatWork::Conv(conv) => positions * channels * conv.segments * conv.run,
            FloatWork::Depthwise(conv) => positions * channels * conv.taps,
            FloatWork::Linear(linear) => channels * linear.inputs,
            FloatWork::Lstm(lstm) => 4 * lstm.hidden * lstm.steps * (lstm.channels + lstm.hidden),
            FloatWork::Map { .. } | FloatWork::Deviation { .. } | FloatWork::Norm { .. } => 0,
        }
    }
}
