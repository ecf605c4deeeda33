//! The operations a network is made of, each with its one definition of meaning.

use serde::{Deserialize, Serialize};

use crate::window::Window;

/// The operation of a node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Op {
    /// A named input of the network.
    Input,
    /// Cross-correlation as in `torch.nn.Conv1d/2d/3d`; out-of-range inputs are zero. Kernel value k meets the
    /// input `dilation · k` after the window's first.
    Conv {
        /// Output channels.
        #[serde(rename = "out_channels")]
        filters: usize,
        /// Kernel, stride, zero padding.
        window: Window,
        /// Steps between the inputs that neighbouring kernel values meet, per spatial axis; empty: all 1.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        dilation: Vec<usize>,
        /// Channel groups; input and output channels are both divisible by it.
        groups: usize,
        /// Whether a bias is added per output channel.
        bias: bool,
    },
    /// Batch normalisation over batch and space, per channel (`torch.nn.BatchNorm*`).
    ///
    /// In training: batch mean and biased variance normalise; the running statistics move by
    /// `momentum` towards the batch mean and unbiased variance.
    BatchNorm {
        /// Added to the variance.
        eps: f32,
        /// Weight of the new batch in the running statistics.
        momentum: f32,
    },
    /// Layer normalisation of the features of each sample (`torch.nn.LayerNorm`): `(x − mean) / √(var + eps)`, by their
    /// mean and biased variance, times `weight`, plus `bias`. One NaN makes all of them NaN.
    LayerNorm {
        /// Added to the variance; above 0.
        eps: f32,
    },
    /// `max(x, 0)`; NaN stays NaN; the gradient at 0 is 0.
    Relu,
    /// Any other function of one value.
    Activation(Activation),
    /// In training every value is zero with `probability`, else multiplied by 1 / (1 − `probability`);
    /// in evaluation nothing happens (`torch.nn.Dropout`). Which are zero: [`crate::DropoutMask`]. A zero
    /// is a product, so that NaN stays NaN.
    Dropout {
        /// Share of values dropped (PyTorch's and MATLAB's meaning, not the share kept), in 0..1.
        #[serde(rename = "p")]
        probability: f32,
    },
    /// Maximum per window; padding never wins; the first of equals gets the gradient; NaN wins.
    MaxPool(Window),
    /// Mean per window; of the padding, the `counted` part enters the mean as zeros.
    AveragePool {
        /// Kernel, stride, padding.
        window: Window,
        /// Padding (before, after) per spatial axis that the divisor counts: all of it with PyTorch's
        /// `count_include_pad`, none without; never the overhang of rounding up.
        counted: Vec<(usize, usize)>,
    },
    /// Mean over all spatial axes: channels × … → features.
    GlobalAveragePool,
    /// Standard deviation over all spatial axes, divided by the number of positions and kept from 0 by `eps`:
    /// `√(mean((x − mean)²) + eps)`, channels × … → features. With the mean beside it, statistics pooling
    /// (Snyder et al., ICASSP 2018).
    GlobalStandardDeviation {
        /// Added to the variance, so that the gradient of a constant channel is 0; above 0.
        eps: f32,
    },
    /// Mean over windows that cut each spatial axis into a given number of parts
    /// (`torch.nn.AdaptiveAvgPool*d`): part i of n over a size s covers ⌊i·s/n⌋ to ⌈(i+1)·s/n⌉, so
    /// neighbours may share values, and n may exceed s.
    AdaptiveAveragePool {
        /// Parts per spatial axis.
        #[serde(rename = "output_size")]
        output: Vec<usize>,
    },
    /// All axes to features, channels first (PyTorch's order).
    Flatten,
    /// `x Wᵀ + b` on features.
    Linear {
        /// Output features.
        #[serde(rename = "out_features")]
        outputs: usize,
        /// Whether a bias is added.
        bias: bool,
    },
    /// One LSTM layer over the last axis, from zero states: channels × length → features, the hidden
    /// state after the last step (`torch.nn.LSTM`, one layer, one direction). Axes between channels and the last have
    /// size 1.
    ///
    /// Tensors `weight_ih_l0` [4·hidden, channels], `weight_hh_l0` [4·hidden, hidden], `bias_ih_l0`,
    /// `bias_hh_l0` [4·hidden]; gates in the order i, f, g, o. Per step
    /// `c ← σ(f)·c + σ(i)·tanh(g)`, `h ← σ(o)·tanh(c)`.
    Lstm {
        /// Hidden units.
        #[serde(rename = "hidden_size")]
        hidden: usize,
        /// Steps: the length of the last axis.
        steps: usize,
    },
    /// One GRU layer over the last axis, from a zero state: channels × length → features, the hidden state after the
    /// last step (`torch.nn.GRU`, one layer, one direction). Axes between channels and the last have size 1.
    ///
    /// Tensors `weight_ih_l0` [3·hidden, channels], `weight_hh_l0` [3·hidden, hidden], `bias_ih_l0`,
    /// `bias_hh_l0` [3·hidden]; gates in the order r, z, n. Of input `x` and state `h` each gate has the parts
    /// `a = W_ih x + b_ih` and `c = W_hh h + b_hh`. Per step `r = σ(aᵣ + cᵣ)`, `z = σ(a_z + c_z)`,
    /// `n = tanh(aₙ + r·cₙ)`, `h ← (1 − z)·n + z·h`.
    Gru {
        /// Hidden units.
        #[serde(rename = "hidden_size")]
        hidden: usize,
        /// Steps: the length of the last axis.
        steps: usize,
    },
    /// The whole input times one learned scalar, whose tensor carries the node's own name.
    Scale,
    /// Channel `g · channels/groups + i` becomes channel `i · groups + g` (ShuffleNet).
    ChannelShuffle {
        /// Groups; divides the channels.
        groups: usize,
    },
    /// Channels (or features) `start..start + len`.
    Slice {
        /// First channel.
        start: usize,
        /// Number of channels.
        len: usize,
    },
    /// `(x − mean) / std` per channel, with fixed tensors (z-score). The gradient is that of a product.
    Standardize {
        /// Name of the tensor of means, one per channel.
        mean: String,
        /// Name of the tensor of standard deviations, one per channel.
        std: String,
    },
    /// The first input, times 0 in samples where each channel of the second is constant (its largest value is its
    /// smallest) and times 1 in all others: the switch-scale layer of Rouhafzay et al. 2021. NaN is not constant. No
    /// gradient reaches the second input.
    SwitchScale,
    /// Sum of two inputs of one shape.
    Add,
    /// Inputs joined along channels (or features).
    Concat,
}

/// A function of one value. NaN stays NaN; gradients at the corners are PyTorch's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Activation {
    /// `min(max(x, 0), 6)`; the gradient at 0 and 6 is 0.
    Relu6,
    /// `x` above 0, else `slope · x`; the gradient at 0 is `slope`.
    LeakyRelu {
        /// Factor of values up to 0.
        #[serde(rename = "negative_slope")]
        slope: f32,
    },
    /// `1 / (1 + e⁻ˣ)`.
    Sigmoid,
    /// Hyperbolic tangent.
    Tanh,
    /// `x · min(max(x + 3, 0), 6) / 6`; the gradient is 0 at −3 and 1 at 3.
    HardSwish,
}

impl Activation {
    fn kind(self) -> &'static str {
        match self {
            Activation::Relu6 => "relu6",
            Activation::LeakyRelu { .. } => "leaky_relu",
            Activation::Sigmoid => "sigmoid",
            Activation::Tanh => "tanh",
            Activation::HardSwish => "hard_swish",
        }
    }
}

impl Op {
    /// Returns the short name for tables: `conv`, `batch_norm`, `max_pool`, …
    pub fn kind(&self) -> &'static str {
        match self {
            Op::Input => "input",
            Op::Conv { .. } => "conv",
            Op::BatchNorm { .. } => "batch_norm",
            Op::LayerNorm { .. } => "layer_norm",
            Op::Relu => "relu",
            Op::Activation(activation) => activation.kind(),
            Op::Dropout { .. } => "dropout",
            Op::MaxPool(_) => "max_pool",
            Op::AveragePool { .. } => "average_pool",
            Op::GlobalAveragePool => "global_average_pool",
            Op::GlobalStandardDeviation { .. } => "global_standard_deviation",
            Op::AdaptiveAveragePool { .. } => "adaptive_average_pool",
            Op::Flatten => "flatten",
            Op::Linear { .. } => "linear",
            Op::Lstm { .. } => "lstm",
            Op::Gru { .. } => "gru",
            Op::Scale => "scale",
            Op::ChannelShuffle { .. } => "channel_shuffle",
            Op::Slice { .. } => "slice",
            Op::Standardize { .. } => "standardize",
            Op::SwitchScale => "switch_scale",
            Op::Add => "add",
            Op::Concat => "concat",
        }
    }
}
