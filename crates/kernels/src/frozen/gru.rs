//! One GRU layer over one sequence.

use crate::gru::{self, Weights, cell};
use crate::layout::transpose;
use crate::lengths::{at_least, exactly};
use crate::view::Rectifier;
use crate::window::Window3;

use super::conv::Conv;
use super::linear::Linear;
use super::place::{ImagePlace, Route};

/// A GRU layer with its weights.
pub struct Gru {
    sizes: gru::Gru,
    /// The part of the gates that the inputs of all steps give.
    inputs: Conv,
    /// The part of the gates that a hidden state gives.
    hidden: Linear,
    bias: Vec<f32>,
}

impl Gru {
    /// Makes a layer over what lies at `from`, whose columns are the steps.
    pub fn new(sizes: gru::Gru, weights: &Weights, from: ImagePlace) -> Self {
        let gru::Gru { channels, steps, hidden } = sizes;
        let width = 3 * hidden;
        assert!(from.size == [1, 1, steps] && from.channels == channels, "{sizes:?}: {from:?}");
        exactly("input weights", weights.ih.len(), width * channels);
        exactly("recurrent weights", weights.hh.len(), width * hidden);
        exactly("second bias", weights.bias_hh.len(), width);
        let (mut ih, mut hh) = (vec![0.0; width * channels], vec![0.0; width * hidden]);
        transpose(width, channels, weights.ih, &mut ih, false);
        transpose(width, hidden, weights.hh, &mut hh, false);
        let size = [1, 1, steps];
        let window = Window3 { input: size, output: size, kernel: [1; 3], stride: [1; 3], before: [0; 3] };
        let route = Route::new(from, ImagePlace::dense(size, width));
        let inputs = Conv::new(&window, [1; 3], 1, &ih, weights.bias_ih, route);
        Gru { sizes, inputs, hidden: Linear::new(hidden, width, &hh), bias: weights.bias_hh.to_vec() }
    }

    /// Returns the number of values of scratch that [`Gru::run`] needs.
    pub fn work_len(&self) -> usize {
        let gru::Gru { steps, hidden, .. } = self.sizes;
        // Gates of all steps by the inputs, those of one step by the hidden state, that state.
        3 * hidden * (steps + 1) + hidden
    }

    /// Writes the hidden state after the last step to `h`.
    pub fn run(&self, x: &[f32], work: &mut [f32], h: &mut [f32]) {
        let gru::Gru { steps, hidden, .. } = self.sizes;
        at_least("scratch of a GRU layer", work.len(), self.work_len());
        at_least("hidden state", h.len(), hidden);
        let (all, rest) = work.split_at_mut(3 * hidden * steps);
        let (states, rest) = rest.split_at_mut(3 * hidden);
        let (h, old) = (&mut h[..hidden], &mut rest[..hidden]);
        self.inputs.run(x, None, all);
        old.fill(0.0);
        for gates in all.chunks_exact_mut(3 * hidden) {
            self.hidden.run(old, &self.bias, Rectifier::None, states);
            cell(gates, states, old, h);
            old.copy_from_slice(h);
        }
    }
}
