//! One GRU layer over a batch of sequences: the hidden state after the last step, and its gradients.
//!
//! Values lie as batch × steps × channels. Weights are PyTorch's: 3·hidden × channels and
//! 3·hidden × hidden, gates in the order r, z, n.

use crate::activation::{sigmoid_of, tanh_of};
use crate::half::{self, HalfMatrix};
use crate::layout;
use crate::lengths::{at_least, exactly, whole_rows};
use crate::matmul::{Matrix, few_rows, matmul};
use crate::reduce::add_columns;
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};

use super::TOGETHER;
pub use super::Weights;

/// Sizes of a GRU layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gru {
    /// Inputs of one step.
    pub channels: usize,
    /// Length of a sequence, at least 1.
    pub steps: usize,
    /// Hidden units.
    pub hidden: usize,
}

/// The values that the backward pass needs, for a batch of any size up to the one it was made for. Rows are steps of
/// samples, those of one sample together.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Gates after their functions, batch × steps × 3·hidden; [`Gru::backward_gates`] puts the gradients of what the
    /// inputs give to them in their place.
    gates: Vec<f32>,
    /// The part of the gates that the hidden state gives, of the same size; later its gradients.
    states: Vec<f32>,
    /// Hidden states before each step, batch × steps × hidden.
    before: Vec<f32>,
    /// Gradients of one step's hidden state, batch × hidden.
    dh: Vec<f32>,
    /// Input weights and recurrent weights, rows and columns exchanged.
    turned: [Vec<f32>; 2],
    /// Those two and the recurrent weights as bf16, where products are of those.
    halves: Option<Box<[HalfMatrix; 3]>>,
}

impl Trace {
    /// Makes room for `batch` sequences.
    pub fn new(gru: &Gru, batch: usize) -> Self {
        let Gru { channels, steps, hidden } = *gru;
        Trace {
            gates: vec![0.0; batch * steps * gru.width()],
            states: vec![0.0; batch * steps * gru.width()],
            before: vec![0.0; batch * steps * hidden],
            dh: vec![0.0; batch * hidden],
            turned: [channels, hidden].map(|rows| vec![0.0; rows * gru.width()]),
            halves: None,
        }
    }

    /// Makes room for `batch` sequences whose products are of bf16. Panics where [`crate::half::supported`] is an error.
    pub fn half(gru: &Gru, batch: usize) -> Self {
        half::assert_supported();
        Trace { halves: Some(Box::default()), ..Trace::new(gru, batch) }
    }
}

impl Gru {
    /// Returns the number of gates of one step.
    fn width(&self) -> usize {
        3 * self.hidden
    }

    /// Returns the number of samples of a batch by its length; panics unless they are whole and `trace` has room for
    /// them.
    fn samples(&self, what: &str, len: usize, sample: usize, trace: &Trace) -> usize {
        whole_rows(what, len, sample);
        let n = len / sample;
        let rows = n * self.steps;
        at_least("gates of a trace", trace.gates.len(), rows * self.width());
        at_least("states of a trace", trace.states.len(), rows * self.width());
        at_least("hidden states of a trace", trace.before.len(), rows * self.hidden);
        exactly("input weights of a trace", trace.turned[0].len(), self.channels * self.width());
        exactly("recurrent weights of a trace", trace.turned[1].len(), self.hidden * self.width());
        n
    }

    fn check(&self, weights: &Weights) {
        exactly("input weights", weights.ih.len(), self.width() * self.channels);
        exactly("recurrent weights", weights.hh.len(), self.width() * self.hidden);
        exactly("first bias", weights.bias_ih.len(), self.width());
        exactly("second bias", weights.bias_hh.len(), self.width());
    }

    /// Computes the last hidden states: x [n × steps × channels] → y [n × hidden], n by the length of `y`. Remembers
    /// the way in `trace`.
    pub fn forward(&self, x: &[f32], weights: &Weights, trace: &mut Trace, y: &mut [f32]) {
        let Gru { channels, steps, hidden } = *self;
        let (n, width) = (self.samples("hidden states", y.len(), hidden, trace), self.width());
        exactly("sequences", x.len(), n * steps * channels);
        self.check(weights);
        let Trace { gates, states, turned: [ih, hh], halves, .. } = &mut *trace;
        layout::transpose(width, channels, weights.ih, ih, false);
        layout::transpose(width, hidden, weights.hh, hh, false);
        if let Some(halves) = halves {
            halves[0].pack(Matrix::new(ih, channels, width));
            halves[1].pack(Matrix::new(hh, hidden, width));
        }
        let gates = &mut gates[..n * steps * width];
        for (values, bias) in [(&mut *gates, weights.bias_ih), (states, weights.bias_hh)] {
            values.chunks_exact_mut(width).for_each(|row| row.copy_from_slice(bias));
        }
        let x = Matrix::new(x, n * steps, channels);
        match halves {
            Some(halves) => halves[0].multiply(gates, width, x, true),
            None => few_rows(gates, width, x, Matrix::new(ih, channels, width), true),
        }
        self.run_steps(n, trace, y);
    }

    /// Runs all steps of `n` sequences whose gates in `trace` hold what the inputs give, and the states their bias.
    fn run_steps(&self, n: usize, trace: &mut Trace, y: &mut [f32]) {
        let (Gru { steps, hidden, .. }, width) = (*self, self.width());
        let Trace { gates, states, before, turned: [_, hh], halves, .. } = trace;
        // No state lies before the first step, whatever an earlier batch left.
        for sample in before.chunks_exact_mut(steps * hidden).take(n) {
            sample[..hidden].fill(0.0);
        }
        for step in 0..steps {
            let old = Matrix::strided(&before[step * hidden..], n, hidden, steps * hidden);
            let given = &mut states[step * width..];
            match halves {
                Some(halves) => halves[1].multiply(given, steps * width, old, true),
                None => few_rows(given, steps * width, old, Matrix::new(hh, hidden, width), true),
            }
            for sample in 0..n {
                let row = sample * steps + step;
                let (old, later) = before[row * hidden..].split_at_mut(hidden);
                let new = if step + 1 < steps { later } else { &mut y[sample * hidden..] };
                let at = row * width..(row + 1) * width;
                cell(&mut gates[at.clone()], &states[at], old, &mut new[..hidden]);
            }
        }
    }

    /// Computes the gradients of all gates before their functions, from `dy` [n × hidden]; once after
    /// [`Gru::forward`], before the two methods below.
    pub fn backward_gates(&self, dy: &[f32], weights: &Weights, trace: &mut Trace) {
        let Gru { steps, hidden, .. } = *self;
        let (n, width) = (self.samples("dy", dy.len(), hidden, trace), self.width());
        self.check(weights);
        let Trace { gates, states, before, dh, halves, .. } = trace;
        at_least("hidden gradients of a trace", dh.len(), n * hidden);
        dh[..n * hidden].copy_from_slice(dy);
        let hh = Matrix::new(weights.hh, width, hidden);
        if let Some(halves) = halves {
            halves[2].pack(hh);
        }
        for step in (0..steps).rev() {
            for sample in 0..n {
                let row = sample * steps + step;
                let at = row * width..(row + 1) * width;
                let (gates, states) = (&mut gates[at.clone()], &mut states[at]);
                let old = &before[row * hidden..(row + 1) * hidden];
                cell_backward(gates, states, old, &mut dh[sample * hidden..(sample + 1) * hidden]);
            }
            if step > 0 {
                let dstates = Matrix::strided(&states[step * width..], n, width, steps * width);
                match halves {
                    Some(halves) => halves[2].multiply(dh, hidden, dstates, true),
                    None => few_rows(dh, hidden, dstates, hh, true),
                }
            }
        }
    }

    /// Writes the gradients of the weights over what was there: sums over the sequences `x` [n × steps × channels].
    pub fn backward_weights(&self, x: &[f32], trace: &Trace, dih: &mut [f32], dhh: &mut [f32]) {
        let (Gru { channels, steps, hidden }, width) = (*self, self.width());
        let n = self.samples("sequences", x.len(), steps * channels, trace);
        exactly("gradient of the input weights", dih.len(), width * channels);
        exactly("gradient of the recurrent weights", dhh.len(), width * hidden);
        let product = if trace.halves.is_some() { half::multiply } else { few_rows };
        let Trace { gates, states, before, .. } = trace;
        for from in (0..n * steps).step_by(TOGETHER) {
            let count = TOGETHER.min(n * steps - from);
            let rows = |values, columns| Matrix::new(part(values, columns, from, count), count, columns);
            product(dih, channels, rows(gates, width).t(), rows(x, channels), from > 0);
            product(dhh, hidden, rows(states, width).t(), rows(before, hidden), from > 0);
        }
    }

    /// Writes the gradients of the two biases over what was there: sums over `n` sequences.
    pub fn backward_biases(&self, n: usize, trace: &Trace, dbias_ih: &mut [f32], dbias_hh: &mut [f32]) {
        self.samples("sequences", n, 1, trace);
        let len = n * self.steps * self.width();
        for (bias, values) in [(dbias_ih, &trace.gates), (dbias_hh, &trace.states)] {
            exactly("gradient of a bias", bias.len(), self.width());
            bias.fill(0.0);
            add_columns(self.width(), &values[..len], bias);
        }
    }

    /// Computes the gradient of the input, written to or added to `dx`.
    pub fn backward_input(&self, trace: &Trace, weights: &Weights, dx: &mut [f32], accumulate: bool) {
        let (Gru { channels, steps, .. }, width) = (*self, self.width());
        let n = self.samples("dx", dx.len(), channels * steps, trace);
        self.check(weights);
        let product = if trace.halves.is_some() { half::multiply } else { matmul };
        let dgates = Matrix::new(&trace.gates, n * steps, width);
        product(dx, channels, dgates, Matrix::new(weights.ih, width, channels), accumulate);
    }
}

/// Returns `count` rows of `columns` values, beginning with row `from`.
fn part(values: &[f32], columns: usize, from: usize, count: usize) -> &[f32] {
    &values[from * columns..(from + count) * columns]
}

at_level! {
    /// Runs one step of one sample from the hidden state `old`: `gates` hold what the inputs give and get their
    /// functions, `states` hold what `old` gives, `h` becomes the new hidden state.
    pub(crate) fn cell(gates: &mut [f32], states: &[f32], old: &[f32], h: &mut [f32]) = cell_at
}

/// Runs [`cell`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn cell_at<S: Simd>(gates: &mut [f32], states: &[f32], old: &[f32], h: &mut [f32]) {
    let hidden = h.len();
    exactly("gates of a cell", gates.len(), 3 * hidden);
    exactly("states of a cell", states.len(), 3 * hidden);
    exactly("hidden state of a cell", old.len(), hidden);
    vectors!(S, hidden, u, lanes, {
        // SAFETY: `u + lanes <= hidden`: the asserted length of both hidden states, and a third of that of the
        // gates and states.
        unsafe {
            let (reset, update) = (load::<S>(gates, u, lanes), load::<S>(gates, hidden + u, lanes));
            let r = sigmoid_of::<S>(S::add(reset, load::<S>(states, u, lanes)));
            let z = sigmoid_of::<S>(S::add(update, load::<S>(states, hidden + u, lanes)));
            let kept = load::<S>(states, 2 * hidden + u, lanes);
            let n = tanh_of::<S>(S::fma(r, kept, load::<S>(gates, 2 * hidden + u, lanes)));
            store::<S>(gates, u, lanes, r);
            store::<S>(gates, hidden + u, lanes, z);
            store::<S>(gates, 2 * hidden + u, lanes, n);
            store::<S>(h, u, lanes, S::fma(z, S::sub(load::<S>(old, u, lanes), n), n));
        }
    });
}

at_level! {
    /// Runs one step of one sample backwards: gates become the gradients of what the inputs give to them, `states`
    /// those of what the hidden state `old` gives; of `dh` that part is left that reaches `old` directly.
    fn cell_backward(gates: &mut [f32], states: &mut [f32], old: &[f32], dh: &mut [f32]) = cell_backward_at
}

/// Runs [`cell_backward`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn cell_backward_at<S: Simd>(gates: &mut [f32], states: &mut [f32], old: &[f32], dh: &mut [f32]) {
    let hidden = dh.len();
    exactly("gates of a cell", gates.len(), 3 * hidden);
    exactly("states of a cell", states.len(), 3 * hidden);
    exactly("hidden state of a cell", old.len(), hidden);
    vectors!(S, hidden, u, lanes, {
        // SAFETY: `u + lanes <= hidden`: the asserted length of both hidden states, and a third of that of the
        // gates and states.
        unsafe {
            let one = S::splat(1.0);
            let (r, z) = (load::<S>(gates, u, lanes), load::<S>(gates, hidden + u, lanes));
            let (n, kept) =
                (load::<S>(gates, 2 * hidden + u, lanes), load::<S>(states, 2 * hidden + u, lanes));
            let (old, after) = (load::<S>(old, u, lanes), load::<S>(dh, u, lanes));
            let dn = S::mul(S::mul(after, S::sub(one, z)), S::sub(one, S::mul(n, n)));
            let dz = S::mul(S::mul(after, S::sub(old, n)), S::mul(z, S::sub(one, z)));
            let dr = S::mul(S::mul(dn, kept), S::mul(r, S::sub(one, r)));
            for values in [&mut *gates, &mut *states] {
                store::<S>(values, u, lanes, dr);
                store::<S>(values, hidden + u, lanes, dz);
            }
            store::<S>(gates, 2 * hidden + u, lanes, dn);
            store::<S>(states, 2 * hidden + u, lanes, S::mul(dn, r));
            store::<S>(dh, u, lanes, S::mul(after, z));
        }
    });
}
