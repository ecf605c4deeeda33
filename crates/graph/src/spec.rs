//! Convolutions and pools as a network file writes them, before the size of their input is known.

use crate::error::Result;
use crate::window::Window;

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
    /// Returns one size per axis; of [`Extent::Each`] as many as there are.
    pub(crate) fn over(&self, axes: usize) -> Vec<usize> {
        match self {
            Extent::All(size) => vec![*size; axes],
            Extent::Each(sizes) => sizes.clone(),
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
    /// Returns the window over `shape` (channels first), or why it does not fit.
    pub fn resolve(&self, node: &str, shape: &[usize]) -> Result<Window> {
        self.resolve_dilated(node, shape, &[])
    }

    /// Returns the same for a kernel whose values meet inputs `dilation` apart (empty: neighbours).
    pub fn resolve_dilated(&self, node: &str, shape: &[usize], dilation: &[usize]) -> Result<Window> {
        let size = shape.get(1..).unwrap_or_default();
        let (kernel, stride) = (self.kernel.over(size.len()), self.stride.over(size.len()));
        let padding = match &self.padding {
            Padding::Valid => vec![(0, 0); size.len()],
            Padding::Both(extent) => extent.over(size.len()).into_iter().map(|pad| (pad, pad)).collect(),
            Padding::Same => {
                let same = |((&size, &kernel), &stride)| same(size, kernel, stride);
                let extent = Window { kernel: kernel.clone(), stride: vec![], padding: vec![] };
                size.iter().zip(&extent.dilated(dilation).kernel).zip(&stride).map(same).collect()
            }
        };
        let mut window = Window { kernel, stride, padding };
        window.fit_dilated(node, shape, dilation)?;
        if self.round_up {
            round_up(&mut window, size);
        }
        Ok(window)
    }
}

/// Computes the padding that makes the size `ceil(size / stride)`.
fn same(size: usize, kernel: usize, stride: usize) -> (usize, usize) {
    // A stride of 0 is refused when the window is fitted.
    let last = size.div_ceil(stride.max(1)).saturating_sub(1).saturating_mul(stride);
    let total = last.saturating_add(kernel).saturating_sub(size);
    (total / 2, total - total / 2)
}

/// Pads after the end where a last window hangs over it, but starts inside (PyTorch's `ceil_mode`).
fn round_up(window: &mut Window, size: &[usize]) {
    for (a, pad) in window.padding.iter_mut().enumerate() {
        let (kernel, stride) = (window.kernel[a], window.stride[a]);
        let padded = size[a] + pad.0 + pad.1;
        let rest = (padded - kernel) % stride;
        if rest > 0 && padded - kernel - rest + stride < size[a] + pad.0 {
            pad.1 += stride - rest;
        }
    }
}

/// A convolution as a network file writes it: `Conv::new(16, 3).same()`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conv {
    pub(crate) filters: usize,
    pub(crate) window: WindowSpec,
    pub(crate) dilation: Extent,
    pub(crate) groups: usize,
    pub(crate) bias: bool,
}

impl Conv {
    /// Makes a convolution of `filters` output channels, stride 1, no padding, with bias.
    pub fn new(filters: usize, kernel: impl Into<Extent>) -> Self {
        Conv {
            filters,
            window: WindowSpec {
                kernel: kernel.into(),
                stride: Extent::All(1),
                padding: Padding::Valid,
                round_up: false,
            },
            dilation: Extent::All(1),
            groups: 1,
            bias: true,
        }
    }

    /// Pads so that the size is kept (divided by the stride, rounding up).
    pub fn same(mut self) -> Self {
        self.window.padding = Padding::Same;
        self
    }

    /// Pads both sides with zeros, as in PyTorch.
    pub fn pad(mut self, padding: impl Into<Extent>) -> Self {
        self.window.padding = Padding::Both(padding.into());
        self
    }

    /// Sets the step of the kernel.
    pub fn stride(mut self, stride: impl Into<Extent>) -> Self {
        self.window.stride = stride.into();
        self
    }

    /// Sets the steps between the inputs that neighbouring kernel values meet (PyTorch's `dilation`).
    pub fn dilation(mut self, dilation: impl Into<Extent>) -> Self {
        self.dilation = dilation.into();
        self
    }

    /// Sets the number of channel groups.
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
    /// Makes a window of `kernel` with the stride equal to the kernel, no padding, rounding down.
    pub fn new(kernel: impl Into<Extent>) -> Self {
        let kernel = kernel.into();
        Pool {
            window: WindowSpec { stride: kernel.clone(), kernel, padding: Padding::Valid, round_up: false },
            count_padding: true,
        }
    }

    /// Sets the step of the window.
    pub fn stride(mut self, stride: impl Into<Extent>) -> Self {
        self.window.stride = stride.into();
        self
    }

    /// Pads both sides, as in PyTorch.
    pub fn pad(mut self, padding: impl Into<Extent>) -> Self {
        self.window.padding = Padding::Both(padding.into());
        self
    }

    /// Keeps a last window that hangs over the end (PyTorch's `ceil_mode`, MATLAB's `same` for 2/2).
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
