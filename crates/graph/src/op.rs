//! The operations a network is made of, each with its one definition of meaning.
//!
//! Shapes leave the batch axis out. Axes are PyTorch's and the papers': features; channels × length;
//! channels × rows × columns; channels × rows × columns × frames. How a backend lays them out in
//! memory is its own business.

use crate::error::{Error, Result};

/// Names of the axes of a shape of `rank`, batch left out.
pub fn axis_names(rank: usize) -> &'static [&'static str] {
    match rank {
        1 => &["features"],
        2 => &["channels", "length"],
        3 => &["channels", "rows", "columns"],
        4 => &["channels", "rows", "columns", "frames"],
        _ => &[],
    }
}

/// A shape with its axis names: `channels 3 × rows 50 × columns 50`.
pub fn describe(shape: &[usize]) -> String {
    let names = axis_names(shape.len());
    if names.is_empty() {
        return format!("{shape:?}");
    }
    let axes: Vec<String> = names.iter().zip(shape).map(|(n, s)| format!("{n} {s}")).collect();
    axes.join(" × ")
}

/// A sliding window: how a kernel moves over the spatial axes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Window {
    /// Size per spatial axis.
    pub kernel: Vec<usize>,
    /// Step per spatial axis.
    pub stride: Vec<usize>,
    /// Padding (before, after) per spatial axis.
    pub padding: Vec<(usize, usize)>,
}

impl Window {
    /// Number of window positions along each spatial axis of `size`, with `(padded - kernel) / stride`
    /// rounded down. Rounding up is expressed as padding after the end (see [`crate::Pool`]).
    pub fn positions(&self, size: &[usize]) -> Vec<usize> {
        (0..size.len())
            .map(|a| {
                let padded = size[a] + self.padding[a].0 + self.padding[a].1;
                (padded - self.kernel[a]) / self.stride[a] + 1
            })
            .collect()
    }

    /// Number of values one window covers.
    pub fn volume(&self) -> usize {
        self.kernel.iter().product()
    }
}

/// What a node computes.
#[derive(Debug, Clone, PartialEq)]
pub enum Op {
    /// A named input of the network.
    Input,
    /// Cross-correlation as in `torch.nn.Conv1d/2d/3d`; out-of-range inputs are zero.
    Conv {
        /// Kernel, stride, zero padding.
        window: Window,
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
    /// `max(x, 0)`; NaN stays NaN; the gradient at 0 is 0.
    Relu,
    /// Any other function of one value.
    Activation(Activation),
    /// In training every value is zero with `probability`, else multiplied by 1 / (1 − `probability`);
    /// in evaluation nothing happens (`torch.nn.Dropout`). Which are zero: [`crate::DropoutMask`]. A zero
    /// is a product, so that NaN stays NaN.
    Dropout {
        /// Share of values dropped (PyTorch's and MATLAB's meaning, not the share kept), in 0..1.
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
    /// Mean over windows that cut each spatial axis into a given number of parts
    /// (`torch.nn.AdaptiveAvgPool*d`): part i of n over a size s covers ⌊i·s/n⌋ to ⌈(i+1)·s/n⌉, so
    /// neighbours may share values, and n may exceed s.
    AdaptiveAveragePool {
        /// Parts per spatial axis.
        output: Vec<usize>,
    },
    /// All axes to features, channels first (PyTorch's order).
    Flatten,
    /// `x Wᵀ + b` on features.
    Linear {
        /// Whether a bias is added.
        bias: bool,
    },
    /// One LSTM layer over the length axis, from zero states: channels × length → features, the hidden
    /// state after the last step (`torch.nn.LSTM`, one layer, one direction).
    ///
    /// Tensors `weight_ih_l0` [4·hidden, channels], `weight_hh_l0` [4·hidden, hidden], `bias_ih_l0`,
    /// `bias_hh_l0` [4·hidden]; gates in the order i, f, g, o. Per step
    /// `c ← σ(f)·c + σ(i)·tanh(g)`, `h ← σ(o)·tanh(c)`.
    Lstm {
        /// Hidden units.
        hidden: usize,
        /// Steps: the length of the input.
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
    Standardize,
    /// The first input, times 0 in samples where each channel of the second is constant (its largest value is
    /// its smallest) and times 1 in all others: paper 001's switch-scale layer. NaN is not constant. No gradient
    /// reaches the second input.
    SwitchScale,
    /// Sum of inputs of one shape.
    Add,
    /// Inputs joined along channels (or features).
    Concat,
}

/// A function of one value. NaN stays NaN; gradients at the corners are PyTorch's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Activation {
    /// `min(max(x, 0), 6)`; the gradient at 0 and 6 is 0.
    Relu6,
    /// `x` above 0, else `slope · x`; the gradient at 0 is `slope`.
    LeakyRelu {
        /// Factor of values up to 0.
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
    /// Short name for tables: `conv`, `batch_norm`, `max_pool`, …
    pub fn kind(&self) -> &'static str {
        match self {
            Op::Input => "input",
            Op::Conv { .. } => "conv",
            Op::BatchNorm { .. } => "batch_norm",
            Op::Relu => "relu",
            Op::Activation(activation) => activation.kind(),
            Op::Dropout { .. } => "dropout",
            Op::MaxPool(_) => "max_pool",
            Op::AveragePool { .. } => "average_pool",
            Op::GlobalAveragePool => "global_average_pool",
            Op::AdaptiveAveragePool { .. } => "adaptive_average_pool",
            Op::Flatten => "flatten",
            Op::Linear { .. } => "linear",
            Op::Lstm { .. } => "lstm",
            Op::Scale => "scale",
            Op::ChannelShuffle { .. } => "channel_shuffle",
            Op::Slice { .. } => "slice",
            Op::Standardize => "standardize",
            Op::SwitchScale => "switch_scale",
            Op::Add => "add",
            Op::Concat => "concat",
        }
    }
}

/// A size per spatial axis: one number for all axes, or one each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Extent {
    /// The same along every spatial axis.
    All(usize),
    /// One per spatial axis, in the order of the shape.
    Each(Vec<usize>),
}

impl From<usize> for Extent {
    fn from(size: usize) -> Self {
        Extent::All(size)
    }
}

impl<const N: usize> From<[usize; N]> for Extent {
    fn from(sizes: [usize; N]) -> Self {
        Extent::Each(sizes.to_vec())
    }
}

impl Extent {
    pub(crate) fn resolve(&self, node: &str, what: &str, axes: usize) -> Result<Vec<usize>> {
        match self {
            Extent::All(size) => Ok(vec![*size; axes]),
            Extent::Each(sizes) if sizes.len() == axes => Ok(sizes.clone()),
            Extent::Each(sizes) => Err(Error::node(
                node,
                format!("{what} {sizes:?} has {} axes, the input has {axes} spatial axes", sizes.len()),
            )),
        }
    }
}

/// How the edges are filled before a window moves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Padding {
    /// Nothing is added (PyTorch 0, MATLAB `0`).
    Valid,
    /// Output size is `ceil(size / stride)`; an odd rest goes to the end (MATLAB and TensorFlow `same`).
    Same,
    /// That much on both sides (PyTorch).
    Both(Extent),
}

/// Kernel, stride, padding and rounding before the input's size is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct WindowSpec {
    pub kernel: Extent,
    pub stride: Extent,
    pub padding: Padding,
    pub round_up: bool,
}

impl WindowSpec {
    /// The window over `shape` (channels first), or why it does not fit.
    pub fn resolve(&self, node: &str, shape: &[usize]) -> Result<Window> {
        if shape.len() < 2 {
            return Err(Error::node(
                node,
                format!("needs channels and at least one spatial axis, the input is {}", describe(shape)),
            ));
        }
        let (size, names) = (&shape[1..], &axis_names(shape.len())[1..]);
        let kernel = self.kernel.resolve(node, "kernel", size.len())?;
        let stride = self.stride.resolve(node, "stride", size.len())?;
        if kernel.contains(&0) || stride.contains(&0) {
            return Err(Error::node(
                node,
                format!("kernel {kernel:?} and stride {stride:?} must be at least 1"),
            ));
        }
        let both = match &self.padding {
            Padding::Both(extent) => extent.resolve(node, "padding", size.len())?,
            _ => vec![0; size.len()],
        };
        let mut padding = Vec::with_capacity(size.len());
        for a in 0..size.len() {
            let mut pad = (both[a], both[a]);
            if self.padding == Padding::Same {
                let total = (size[a].div_ceil(stride[a]).saturating_sub(1) * stride[a] + kernel[a])
                    .saturating_sub(size[a]);
                pad = (total / 2, total - total / 2);
            }
            let padded = size[a] + pad.0 + pad.1;
            if padded < kernel[a] {
                return Err(Error::node(
                    node,
                    format!(
                        "kernel {} along {} is larger than the padded size {padded}; the input is {}",
                        kernel[a],
                        names[a],
                        describe(shape)
                    ),
                ));
            }
            let rest = (padded - kernel[a]) % stride[a];
            // A last window may hang over the end, but must start inside (PyTorch's ceil_mode).
            if self.round_up && rest > 0 && padded - kernel[a] - rest + stride[a] < size[a] + pad.0 {
                pad.1 += stride[a] - rest;
            }
            padding.push(pad);
        }
        Ok(Window { kernel, stride, padding })
    }
}

/// A convolution as a network file writes it: `Conv::new(16, 3).same()`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conv {
    pub(crate) filters: usize,
    pub(crate) window: WindowSpec,
    pub(crate) groups: usize,
    pub(crate) bias: bool,
}

impl Conv {
    /// `filters` output channels, stride 1, no padding, with bias.
    pub fn new(filters: usize, kernel: impl Into<Extent>) -> Self {
        Conv {
            filters,
            window: WindowSpec {
                kernel: kernel.into(),
                stride: Extent::All(1),
                padding: Padding::Valid,
                round_up: false,
            },
            groups: 1,
            bias: true,
        }
    }

    /// Padding so that the size is kept (divided by the stride, rounding up).
    pub fn same(mut self) -> Self {
        self.window.padding = Padding::Same;
        self
    }

    /// Zeros on both sides, as in PyTorch.
    pub fn pad(mut self, padding: impl Into<Extent>) -> Self {
        self.window.padding = Padding::Both(padding.into());
        self
    }

    /// Step of the kernel.
    pub fn stride(mut self, stride: impl Into<Extent>) -> Self {
        self.window.stride = stride.into();
        self
    }

    /// Channel groups.
    pub fn groups(mut self, groups: usize) -> Self {
        self.groups = groups;
        self
    }

    /// Leaves the bias out.
    pub fn no_bias(mut self) -> Self {
        self.bias = false;
        self
    }
}

/// A pooling window as a network file writes it: `Pool::new(3).stride(2).pad(1)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pool {
    pub(crate) window: WindowSpec,
    pub(crate) count_padding: bool,
}

impl Pool {
    /// A window of `kernel` with the stride equal to the kernel, no padding, rounding down.
    pub fn new(kernel: impl Into<Extent>) -> Self {
        let kernel = kernel.into();
        Pool {
            window: WindowSpec { stride: kernel.clone(), kernel, padding: Padding::Valid, round_up: false },
            count_padding: true,
        }
    }

    /// Step of the window.
    pub fn stride(mut self, stride: impl Into<Extent>) -> Self {
        self.window.stride = stride.into();
        self
    }

    /// Padding on both sides, as in PyTorch.
    pub fn pad(mut self, padding: impl Into<Extent>) -> Self {
        self.window.padding = Padding::Both(padding.into());
        self
    }

    /// A last window that hangs over the end is kept (PyTorch's `ceil_mode`, MATLAB's `same` for 2/2).
    ///
    /// In an average the overhanging part is never counted, as in PyTorch.
    pub fn round_up(mut self) -> Self {
        self.window.round_up = true;
        self
    }

    /// Averages leave padding out (`count_include_pad=False`).
    pub fn ignore_padding(mut self) -> Self {
        self.count_padding = false;
        self
    }
}
