//! Matrix times vector in bf16.

use std::ops::Range;

use crate::frozen::linear;
use crate::half::{assert_supported, pair_columns_of_rows, pair_rows};
use crate::lengths::{at_least, exactly};
use crate::view::Rectifier;

/// A fully connected layer with its weights in bf16.
pub struct Linear {
    inputs: usize,
    pairs: linear::Linear,
}

impl Linear {
    /// Makes a layer; `weight` lies as inputs × outputs and is rounded here.
    pub fn new(inputs: usize, outputs: usize, weight: &[f32]) -> Self {
        assert_supported();
        exactly("weights of a linear layer", weight.len(), inputs * outputs);
        let half = inputs.div_ceil(2);
        let mut packed = vec![0.0; half * outputs];
        pair_rows(inputs, outputs, outputs, weight, &mut packed);
        Linear { inputs, pairs: linear::Linear::new(half, outputs, &packed) }
    }

    /// Returns the number of panels of neighbouring outputs, each of which can be computed by itself.
    pub fn panels(&self) -> usize {
        self.pairs.panels()
    }

    /// Returns the number of values of scratch that runs need.
    pub fn work_len(&self) -> usize {
        self.inputs.div_ceil(2)
    }

    /// Computes `y = rectifier(x W + start)` for the outputs of `panels`; the others stay as they are.
    pub fn run(
        &self,
        panels: Range<usize>,
        x: &[f32],
        start: &[f32],
        rectifier: Rectifier,
        work: &mut [f32],
        y: &mut [f32],
    ) {
        at_least("scratch of a linear layer", work.len(), self.work_len());
        let work = &mut work[..self.work_len()];
        pair_columns_of_rows(self.inputs, self.inputs, x, work);
        self.pairs.run_pairs(panels, work, start, rectifier, y);
    }
}
