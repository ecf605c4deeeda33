//! A kernel that slides over the spatial axes.

use std::fmt::Debug;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::shape::{axis_names, describe};

/// The largest kernel, stride and padding.
const MOST: usize = 1 << 24;

/// A sliding window: how a kernel moves over the spatial axes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// Size per spatial axis.
    #[serde(rename = "kernel_size")]
    pub kernel: Vec<usize>,
    /// Step per spatial axis.
    pub stride: Vec<usize>,
    /// Padding (before, after) per spatial axis.
    pub padding: Vec<(usize, usize)>,
}

impl Window {
    /// Counts the window positions along each spatial axis of `size`, with `(padded - kernel) / stride` rounded down.
    /// Rounding up is expressed as padding after the end (see [`crate::Pool`]).
    pub fn positions(&self, size: &[usize]) -> Vec<usize> {
        (0..size.len())
            .map(|a| {
                let padded = size[a] + self.padding[a].0 + self.padding[a].1;
                (padded - self.kernel[a]) / self.stride[a] + 1
            })
            .collect()
    }

    /// Counts the values that one window covers.
    pub fn volume(&self) -> usize {
        self.kernel.iter().product()
    }

    /// Returns the same for a kernel whose values meet inputs `dilation` apart (empty: neighbours): one that is longer.
    pub fn dilated(&self, dilation: &[usize]) -> Window {
        let mut window = self.clone();
        for (kernel, step) in window.kernel.iter_mut().zip(dilation) {
            *kernel = kernel.saturating_sub(1).saturating_mul(*step).saturating_add(1);
        }
        window
    }

    /// Returns [`Window::fit`] of the dilated window.
    pub(crate) fn fit_dilated(&self, node: &str, shape: &[usize], dilation: &[usize]) -> Result<Vec<usize>> {
        if dilation.is_empty() {
            return self.fit(node, shape);
        }
        check_axes(node, "dilation", dilation, shape.len().saturating_sub(1))?;
        check_axes(node, "kernel", &self.kernel, dilation.len())?;
        if self.kernel.contains(&0) || dilation.iter().any(|step| !(1..=MOST).contains(step)) {
            let kernel = &self.kernel;
            let reason = format!("kernel {kernel:?} must be at least 1, dilation {dilation:?} 1 to {MOST}");
            return Err(Error::node(node, reason));
        }
        if self.kernel.iter().any(|kernel| *kernel > MOST) {
            return self.fit(node, shape);
        }
        self.dilated(dilation).fit(node, shape)
    }

    /// Returns [`Window::positions`] over the spatial axes of an input of `shape`, or why the window does not fit.
    pub(crate) fn fit(&self, node: &str, shape: &[usize]) -> Result<Vec<usize>> {
        let refuse = |reason: String| Err(Error::node(node, reason));
        if shape.len() < 2 {
            let described = describe(shape);
            return refuse(format!("needs channels and at least one spatial axis, the input is {described}"));
        }
        let (size, names) = (&shape[1..], &axis_names(shape.len())[1..]);
        let Window { kernel, stride, padding } = self;
        check_axes(node, "kernel", kernel, size.len())?;
        check_axes(node, "stride", stride, size.len())?;
        check_axes(node, "padding", padding, size.len())?;
        if kernel.contains(&0) || stride.contains(&0) {
            return refuse(format!("kernel {kernel:?} and stride {stride:?} must be at least 1"));
        }
        let ends = padding.iter().flat_map(|&(before, after)| [before, after]);
        if kernel.iter().chain(stride).copied().chain(ends).any(|value| value > MOST) {
            return refuse(format!("kernel, stride and padding must be at most {MOST}"));
        }
        for a in 0..size.len() {
            let padded = size[a] + padding[a].0 + padding[a].1;
            if padded < kernel[a] {
                return refuse(format!(
                    "kernel {} along {} is larger than the padded size {padded}; the input is {}",
                    kernel[a],
                    names[a],
                    describe(shape)
                ));
            }
        }
        Ok(self.positions(size))
    }
}

/// Refuses a `what` that does not have one value per spatial axis.
pub(crate) fn check_axes<T: Debug>(node: &str, what: &str, values: &[T], axes: usize) -> Result<()> {
    if values.len() == axes {
        return Ok(());
    }
    let reason = format!("{what} {values:?} has {} axes, the input has {axes} spatial axes", values.len());
    Err(Error::node(node, reason))
}
