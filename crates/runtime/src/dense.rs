//! Convolutions and linear layers whose products are of floats or of bf16.

use std::ops::Range;

use taxel_kernels::frozen::{self, Route, half};
use taxel_kernels::{Rectifier, Window3};

use crate::lower::Purpose;
use crate::step::Conv;

/// A convolution in which filters see several channels.
pub(crate) enum DenseConv {
    Floats(frozen::Conv),
    Half(half::Conv),
}

impl DenseConv {
    /// Makes the convolution of a step along `route`, over `window`: its own, or that of a band.
    pub fn new(conv: &Conv, window: &Window3, route: Route, purpose: Purpose) -> Self {
        let Conv { dilation, groups, weight, bias, .. } = conv;
        if purpose == Purpose::Half && half::Conv::takes(route.from.channels, *groups) {
            return DenseConv::Half(half::Conv::new(window, *dilation, *groups, weight, bias, route));
        }
        DenseConv::Floats(frozen::Conv::new(window, *dilation, *groups, weight, bias, route))
    }

    /// Returns the number of values of scratch that [`DenseConv::run`] needs.
    pub fn work_len(&self) -> usize {
        match self {
            DenseConv::Floats(_) => 0,
            DenseConv::Half(conv) => conv.work_len(),
        }
    }

    pub fn run(&self, x: &[f32], addend: Option<&[f32]>, work: &mut [f32], y: &mut [f32]) {
        match self {
            DenseConv::Floats(conv) => conv.run(x, addend, y),
            DenseConv::Half(conv) => conv.run(x, addend, work, y),
        }
    }
}

/// A linear layer.
pub(crate) enum DenseLinear {
    Floats(frozen::Linear),
    Half(half::Linear),
}

impl DenseLinear {
    /// Makes a layer; `weight` lies as inputs × outputs.
    pub fn new(inputs: usize, outputs: usize, weight: &[f32], purpose: Purpose) -> Self {
        if purpose == Purpose::Half {
            return DenseLinear::Half(half::Linear::new(inputs, outputs, weight));
        }
        DenseLinear::Floats(frozen::Linear::new(inputs, outputs, weight))
    }

    /// Returns the number of panels of neighbouring outputs, each of which can be computed by itself.
    pub fn panels(&self) -> usize {
        match self {
            DenseLinear::Floats(linear) => linear.panels(),
            DenseLinear::Half(linear) => linear.panels(),
        }
    }

    /// Returns the number of values of scratch that [`DenseLinear::run`] needs.
    pub fn work_len(&self) -> usize {
        match self {
            DenseLinear::Floats(_) => 0,
            DenseLinear::Half(linear) => linear.work_len(),
        }
    }

    /// Computes the outputs of `panels`.
    pub fn run(
        &self,
        panels: Range<usize>,
        x: &[f32],
        start: &[f32],
        rectifier: Rectifier,
        work: &mut [f32],
        y: &mut [f32],
    ) {
        match self {
            DenseLinear::Floats(linear) => linear.run_panels(panels, x, start, rectifier, y),
            DenseLinear::Half(linear) => linear.run(panels, x, start, rectifier, work, y),
        }
    }
}
