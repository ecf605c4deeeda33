//! One LSTM layer over one sequence.

use crate::layout::transpose;
use crate::lengths::{at_least, exactly};
use crate::lstm::{self, Weights, cell};
use crate::view::Rectifier;
use crate::window::Window3;

use super::conv::Conv;
use super::linear::Linear;
use super::place::{ImagePlace, Route};

/// An LSTM layer with its weights.
pub struct Lstm {
    sizes: lstm::Lstm,
    /// The part of the gates that the inputs of all steps give.
    inputs: Conv,
    /// The part of the gates that a hidden state gives.
    hidden: Linear,
}

impl Lstm {
    /// Makes a layer over what lies at `from`, whose columns are the steps.
    pub fn new(sizes: lstm::Lstm, weights: &Weights, from: ImagePlace) -> Self {
        let lstm::Lstm { channels, steps, hidden } = sizes;
        let width = 4 * hidden;
        assert!(from.size == [1, 1, steps] && from.channels == channels, "{sizes:?}: {from:?}");
        exactly("input weights", weights.ih.len(), width * channels);
        exactly("recurrent weights", weights.hh.len(), width * hidden);
        let bias: Vec<f32> = weights.bias_ih.iter().zip(weights.bias_hh).map(|(a, b)| a + b).collect();
        let (mut ih, mut hh) = (vec![0.0; width * channels], vec![0.0; width * hidden]);
        transpose(width, channels, weights.ih, &mut ih, false);
        transpose(width, hidden, weights.hh, &mut hh, false);
        let size = [1, 1, steps];
        let window = Window3 { input: size, output: size, kernel: [1; 3], stride: [1; 3], before: [0; 3] };
        let gates = ImagePlace::dense(size, width);
        let inputs = Conv::new(&window, [1; 3], 1, &ih, &bias, Route::new(from, gates));
        Lstm { sizes, inputs, hidden: Linear::new(hidden, width, &hh) }
    }

    /// Returns the number of values of scratch that [`Lstm::run`] needs.
    pub fn work_len(&self) -> usize {
        let lstm::Lstm { steps, hidden, .. } = self.sizes;
        // Gates of all steps, gates of one, two cell states and their tangent.
        4 * hidden * (steps + 1) + 3 * hidden
    }

    /// Writes the hidden state after the last step to `h`.
    pub fn run(&self, x: &[f32], work: &mut [f32], h: &mut [f32]) {
        let lstm::Lstm { steps, hidden, .. } = self.sizes;
        at_least("scratch of an LSTM layer", work.len(), self.work_len());
        at_least("hidden state", h.len(), hidden);
        let (all, rest) = work.split_at_mut(4 * hidden * steps);
        let (gates, rest) = rest.split_at_mut(4 * hidden);
        let (old, rest) = rest.split_at_mut(hidden);
        let (new, tanh) = rest.split_at_mut(hidden);
        let (h, tanh) = (&mut h[..hidden], &mut tanh[..hidden]);
        self.inputs.run(x, None, all);
        h.fill(0.0);
        old.fill(0.0);
        for start in all.chunks_exact(4 * hidden) {
            self.hidden.run(h, start, Rectifier::None, gates);
            cell(gates, old, new, tanh, h);
            old.copy_from_slice(new);
        }
    }
}
