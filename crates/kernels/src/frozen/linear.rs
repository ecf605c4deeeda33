//! Matrix times vector: weights in panels that are read once, in order.

use std::ops::Range;

use crate::buffer::Buffer;
use crate::half::assert_supported;
use crate::lengths::{at_least, exactly};
use crate::rows::{load, store};
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx512, Pairs};
use crate::simd::{Floats, Product, Simd, WIDEST, at_level, level};
use crate::view::{Rectifier, rectify};

/// Sums that run side by side: so many products must be under way to use all of a core.
const SIDE: usize = 8;

/// A fully connected layer with its weights.
pub struct Linear {
    inputs: usize,
    outputs: usize,
    panels: Vec<OutputPanel>,
    weights: Buffer,
}

/// Neighbouring outputs that are computed together.
#[derive(Debug, Clone, Copy)]
struct OutputPanel {
    first: usize,
    /// Vectors side by side: 8, 4, 2 or 1.
    vectors: usize,
    /// Where its weights start: inputs × vectors.
    weights: usize,
}

impl Linear {
    /// Makes a layer; `weight` lies as inputs × outputs.
    pub fn new(inputs: usize, outputs: usize, weight: &[f32]) -> Self {
        exactly("weights of a linear layer", weight.len(), inputs * outputs);
        let lanes = level().lanes();
        let (mut panels, mut first, mut len) = (vec![], 0, 0);
        while first < outputs {
            let left = (outputs - first).div_ceil(WIDEST);
            let vectors = [8, 4, 2, 1].into_iter().find(|&vectors| vectors <= left).unwrap_or(1);
            let end = outputs.min(first + vectors * WIDEST);
            // Narrower vectors cut a panel into pieces, so that its sums have one order on all CPUs.
            for first in (first..end).step_by(vectors * lanes) {
                panels.push(OutputPanel { first, vectors, weights: len });
                len += inputs * vectors * lanes;
            }
            first = end;
        }
        let mut weights = Buffer::zeros(len);
        for panel in &panels {
            let width = panel.vectors * lanes;
            let taken = width.min(outputs - panel.first);
            for (input, to) in weights[panel.weights..].chunks_exact_mut(width).take(inputs).enumerate() {
                to[..taken].copy_from_slice(&weight[input * outputs + panel.first..][..taken]);
            }
        }
        Linear { inputs, outputs, panels, weights }
    }

    /// Returns the number of panels of neighbouring outputs, each of which can be computed by itself.
    pub fn panels(&self) -> usize {
        self.panels.len()
    }

    /// Computes `y = rectifier(x W + start)`; `x` holds the inputs, `start` and `y` the outputs.
    pub fn run(&self, x: &[f32], start: &[f32], rectifier: Rectifier, y: &mut [f32]) {
        run(self, 0..self.panels.len(), x, start, rectifier, y);
    }

    /// Runs [`Linear::run`] for the outputs of some panels; the others stay as they are.
    pub fn run_panels(
        &self,
        panels: Range<usize>,
        x: &[f32],
        start: &[f32],
        rectifier: Rectifier,
        y: &mut [f32],
    ) {
        run(self, panels, x, start, rectifier, y);
    }

    /// Runs [`Linear::run`] of pairs of bf16 for the outputs of `panels`: inputs, and rows of weights, are pairs of them. Panics
    /// where the CPU has no products of bf16.
    pub(super) fn run_pairs(
        &self,
        panels: Range<usize>,
        x: &[f32],
        start: &[f32],
        rectifier: Rectifier,
        y: &mut [f32],
    ) {
        assert_supported();
        #[cfg(target_arch = "x86_64")]
        {
            // SAFETY: the features are there, as just asserted.
            unsafe { pairs_at(self, panels, x, start, rectifier, y) };
        }
        #[cfg(not(target_arch = "x86_64"))]
        run(self, panels, x, start, rectifier, y);
    }
}

/// Computes [`Linear::run_pairs`].
///
/// # Safety
/// The CPU has AVX512-BF16.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bf16")]
unsafe fn pairs_at(
    linear: &Linear,
    panels: Range<usize>,
    x: &[f32],
    start: &[f32],
    rectifier: Rectifier,
    y: &mut [f32],
) {
    // SAFETY: the caller has checked the features.
    unsafe { products::<Avx512, Pairs>(linear, panels, x, start, rectifier, y) }
}

at_level! {
    fn run(
        linear: &Linear, panels: Range<usize>, x: &[f32], start: &[f32], rectifier: Rectifier, y: &mut [f32],
    ) = run_at
}

/// Computes the outputs of `panels` with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn run_at<S: Simd>(
    linear: &Linear,
    panels: Range<usize>,
    x: &[f32],
    start: &[f32],
    rectifier: Rectifier,
    y: &mut [f32],
) {
    // SAFETY: the caller has checked the features.
    unsafe { products::<S, Floats>(linear, panels, x, start, rectifier, y) }
}

/// Computes the outputs of `panels` with products `P`.
///
/// # Safety
/// The CPU has the features of `S` and `P`.
#[inline(always)]
unsafe fn products<S: Simd, P: Product<S>>(
    linear: &Linear,
    panels: Range<usize>,
    x: &[f32],
    start: &[f32],
    rectifier: Rectifier,
    y: &mut [f32],
) {
    at_least("input of a linear layer", x.len(), linear.inputs);
    at_least("start of a linear layer", start.len(), linear.outputs);
    at_least("output of a linear layer", y.len(), linear.outputs);
    let x = &x[..linear.inputs];
    for panel in &linear.panels[panels] {
        // SAFETY: the lengths are asserted above; the panels were made for this CPU's vectors.
        unsafe {
            match panel.vectors {
                8 => panel_at::<S, P, 8, 1>(linear, panel, x, start, rectifier, y),
                4 => panel_at::<S, P, 4, 2>(linear, panel, x, start, rectifier, y),
                2 => panel_at::<S, P, 2, 4>(linear, panel, x, start, rectifier, y),
                _ => panel_at::<S, P, 1, 8>(linear, panel, x, start, rectifier, y),
            }
        }
    }
}

/// Computes the outputs of one panel: `N` vectors, each as `U` sums over every `U`-th input.
///
/// # Safety
/// The CPU has the features of `P` and of `S`, for whose vectors the panels were made; `x` holds the inputs, `start` and `y` hold
/// the outputs.
#[inline(always)]
unsafe fn panel_at<S: Simd, P: Product<S>, const N: usize, const U: usize>(
    linear: &Linear,
    panel: &OutputPanel,
    x: &[f32],
    start: &[f32],
    rectifier: Rectifier,
    y: &mut [f32],
) {
    const { assert!(N * U == SIDE) };
    let width = N * S::LANES;
    // Rows of `width` weights, one per input.
    let weights = &linear.weights[panel.weights..][..x.len() * width];
    // SAFETY: `weights` has just been cut to a row per input. The last vector of all outputs may be cut off, which
    // `lanes` counts; those behind it are left out.
    unsafe {
        let mut sums = [[S::splat(0.0); N]; U];
        let whole = x.len() / U * U;
        for (block, x) in x[..whole].chunks_exact(U).enumerate() {
            for (u, (sums, x)) in sums.iter_mut().zip(x).enumerate() {
                let x = S::splat(*x);
                let at = (block * U + u) * width;
                for (n, sum) in sums.iter_mut().enumerate() {
                    *sum = P::add(x, S::load(weights.as_ptr().add(at + n * S::LANES)), *sum);
                }
            }
        }
        for (input, x) in x.iter().enumerate().skip(whole) {
            let x = S::splat(*x);
            for (n, sum) in sums[0].iter_mut().enumerate() {
                *sum = P::add(x, S::load(weights.as_ptr().add(input * width + n * S::LANES)), *sum);
            }
        }
        for n in 0..N {
            let at = panel.first + n * S::LANES;
            // The last piece of a panel may have vectors to spare.
            if at >= linear.outputs {
                break;
            }
            let lanes = S::LANES.min(linear.outputs - at);
            let mut sum = load::<S>(start, at, lanes);
            for sums in &sums {
                sum = S::add(sum, sums[n]);
            }
            store::<S>(y, at, lanes, rectify::<S>(rectifier, sum));
        }
    }
}
