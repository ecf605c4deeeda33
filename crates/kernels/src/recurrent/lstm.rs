//! One LSTM layer over a batch of sequences: the hidden state after the last step, and its gradients.
//!
//! Values lie as batch × steps × channels. Weights are PyTorch's: 4·hidden × channels and
//! 4·hidden × hidden, gates in the order i, f, g, o.

use crate::activation::{sigmoid_of, tanh_of};
use crate::half::{self, HalfMatrix};
use crate::layout;
use crate::lengths::{at_least, exactly, whole_rows};
use crate::matmul::{Matrix, few_rows, matmul};
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};

use super::TOGETHER;
pub use super::Weights;

/// Sizes of an LSTM layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lstm {
    /// Inputs of one step.
    pub channels: usize,
    /// Length of a sequence, at least 1.
    pub steps: usize,
    /// Hidden units.
    pub hidden: usize,
}

/// The values that the backward pass needs, for a batch of any size up to the one it was made for. The first axis is the
/// step, so that the values of one step lie together.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Gates after their functions, steps × batch × [`Lstm::gates_row`]; [`Lstm::backward_gates`] puts the
    /// gradients before the functions in their place.
    gates: Vec<f32>,
    /// Cell states before the first step and after each, (steps + 1) × batch × hidden.
    cells: Vec<f32>,
    /// Their hyperbolic tangents.
    tanh: Vec<f32>,
    /// The factors of each step, steps × batch × (channels + 1 + hidden): input, 1, hidden state before.
    factors: Vec<f32>,
    /// Gradients of one step's hidden and cell state, batch × hidden each.
    dh: Vec<f32>,
    dc: Vec<f32>,
    /// Weights of those factors, (channels + 1 + hidden) × 4·hidden.
    turned: Vec<f32>,
    /// Their gradients, 4·hidden × (channels + 1 + hidden).
    dturned: Vec<f32>,
    /// The weights of factors and the recurrent weights as bf16, where products are of those.
    halves: Option<Box<[HalfMatrix; 2]>>,
}

impl Trace {
    /// Makes room for `batch` sequences.
    pub fn new(lstm: &Lstm, batch: usize) -> Self {
        let states = batch * lstm.steps * lstm.hidden;
        Trace {
            gates: vec![0.0; batch * lstm.steps * lstm.gates_row()],
            cells: vec![0.0; states + batch * lstm.hidden],
            tanh: vec![0.0; states],
            factors: [vec![0.0; lstm.channels], vec![1.0], vec![0.0; lstm.hidden]]
                .concat()
                .repeat(batch * lstm.steps),
            dh: vec![0.0; batch * lstm.hidden],
            dc: vec![0.0; batch * lstm.hidden],
            turned: vec![0.0; 4 * lstm.hidden * lstm.factors()],
            dturned: vec![0.0; 4 * lstm.hidden * lstm.factors()],
            halves: None,
        }
    }

    /// Makes room for `batch` sequences whose products are of bf16. Panics where [`crate::half::supported`] is an error.
    pub fn half(lstm: &Lstm, batch: usize) -> Self {
        half::assert_supported();
        Trace { halves: Some(Box::default()), ..Trace::new(lstm, batch) }
    }
}

impl Lstm {
    /// Returns the number of multiply–accumulates of one sequence.
    pub fn macs(&self) -> usize {
        self.steps * 4 * self.hidden * (self.channels + self.hidden)
    }

    /// Returns how many numbers a gate of one step is a weighted sum of: input, 1 for the bias, hidden state.
    fn factors(&self) -> usize {
        self.channels + 1 + self.hidden
    }

    /// Returns the distance of two rows of gates. Rows a power of two apart would all want the same few lines of the
    /// cache.
    fn gates_row(&self) -> usize {
        4 * self.hidden + 16
    }

    /// Returns the number of samples of a batch by its length; panics unless they are whole and `trace` has room for
    /// them.
    fn samples(&self, what: &str, len: usize, sample: usize, trace: &Trace) -> usize {
        whole_rows(what, len, sample);
        let n = len / sample;
        let states = n * self.steps * self.hidden;
        at_least("gates of a trace", trace.gates.len(), n * self.steps * self.gates_row());
        at_least("cells of a trace", trace.cells.len(), states + n * self.hidden);
        at_least("tangents of a trace", trace.tanh.len(), states);
        at_least("factors of a trace", trace.factors.len(), n * self.steps * self.factors());
        exactly("weights of a trace", trace.turned.len(), 4 * self.hidden * self.factors());
        n
    }

    fn check(&self, weights: &Weights) {
        let Lstm { channels, hidden, .. } = *self;
        exactly("input weights", weights.ih.len(), 4 * hidden * channels);
        exactly("recurrent weights", weights.hh.len(), 4 * hidden * hidden);
        exactly("first bias", weights.bias_ih.len(), 4 * hidden);
        exactly("second bias", weights.bias_hh.len(), 4 * hidden);
    }

    /// Computes the last hidden states: x [n × steps × channels] → y [n × hidden], n by the length of `y`. Remembers
    /// the way in `trace`.
    pub fn forward(&self, x: &[f32], weights: &Weights, trace: &mut Trace, y: &mut [f32]) {
        let Lstm { channels, steps, hidden } = *self;
        let n = self.samples("hidden states", y.len(), hidden, trace);
        exactly("sequences", x.len(), n * steps * channels);
        self.check(weights);
        let all = self.factors();
        let Trace { factors, cells, turned, halves, .. } = &mut *trace;
        for (sample, x) in x.chunks_exact(steps * channels).enumerate() {
            for (step, x) in x.chunks_exact(channels).enumerate() {
                factors[(step * n + sample) * all..][..channels].copy_from_slice(x);
            }
        }
        // No state lies before the first step, whatever an earlier batch left.
        cells[..n * hidden].fill(0.0);
        factors[..n * all].chunks_exact_mut(all).for_each(|row| row[channels + 1..].fill(0.0));
        self.turn(weights, turned);
        if let Some(halves) = halves {
            halves[0].pack(Matrix::new(turned, all, 4 * hidden));
        }
        self.run_steps(n, trace, y);
    }

    /// Writes the weights in the order of the factors: input, bias, hidden state.
    fn turn(&self, weights: &Weights, turned: &mut [f32]) {
        let Lstm { channels, hidden, .. } = *self;
        let width = 4 * hidden;
        let (ih, rest) = turned.split_at_mut(channels * width);
        let (bias, hh) = rest.split_at_mut(width);
        layout::transpose(width, channels, weights.ih, ih, false);
        layout::transpose(width, hidden, weights.hh, hh, false);
        for (bias, (a, b)) in bias.iter_mut().zip(weights.bias_ih.iter().zip(weights.bias_hh)) {
            *bias = a + b;
        }
    }

    /// Runs all steps of `n` sequences whose inputs and first states are in `trace`.
    fn run_steps(&self, n: usize, trace: &mut Trace, y: &mut [f32]) {
        let Lstm { channels, steps, hidden } = *self;
        let (width, all) = (4 * hidden, self.factors());
        let Trace { gates, cells, tanh, factors, turned, halves, .. } = trace;
        let stride = self.gates_row();
        for step in 0..steps {
            let (seen, later) = factors[step * n * all..].split_at_mut(n * all);
            let gates = &mut gates[step * n * stride..][..n * stride];
            let seen = Matrix::new(seen, n, all);
            match halves {
                Some(halves) => halves[0].multiply(gates, stride, seen, false),
                None => few_rows(gates, stride, seen, Matrix::new(turned, all, width), false),
            }
            let (old, new) = cells[step * n * hidden..].split_at_mut(n * hidden);
            let tanh = &mut tanh[step * n * hidden..];
            for sample in 0..n {
                let h = if step + 1 < steps {
                    &mut later[sample * all + channels + 1..][..hidden]
                } else {
                    &mut y[sample * hidden..][..hidden]
                };
                let at = sample * hidden..(sample + 1) * hidden;
                let gates = &mut gates[sample * stride..][..width];
                cell(gates, &old[at.clone()], &mut new[at.clone()], &mut tanh[at], h);
            }
        }
    }

    /// Computes the gradients of all gates before their functions, from `dy` [n × hidden]; once after
    /// [`Lstm::forward`], before the two methods below.
    pub fn backward_gates(&self, dy: &[f32], weights: &Weights, trace: &mut Trace) {
        let Lstm { steps, hidden, .. } = *self;
        let (n, width) = (self.samples("dy", dy.len(), hidden, trace), 4 * hidden);
        self.check(weights);
        let Trace { gates, cells, tanh, dh, dc, halves, .. } = trace;
        at_least("hidden gradients of a trace", dh.len(), n * hidden);
        at_least("cell gradients of a trace", dc.len(), n * hidden);
        dh[..n * hidden].copy_from_slice(dy);
        dc[..n * hidden].fill(0.0);
        let hh = Matrix::new(weights.hh, width, hidden);
        if let Some(halves) = halves {
            halves[1].pack(hh);
        }
        let stride = self.gates_row();
        for step in (0..steps).rev() {
            let gates = &mut gates[step * n * stride..][..n * stride];
            for sample in 0..n {
                let row = (step * n + sample) * hidden;
                let row_gates = &mut gates[sample * stride..][..width];
                let (dh, dc) = (&dh[sample * hidden..][..hidden], &mut dc[sample * hidden..][..hidden]);
                cell_backward(row_gates, &tanh[row..][..hidden], &cells[row..][..hidden], dh, dc);
            }
            if step > 0 {
                let gates = Matrix::strided(gates, n, width, stride);
                match halves {
                    Some(halves) => halves[1].multiply(dh, hidden, gates, false),
                    None => few_rows(dh, hidden, gates, hh, false),
                }
            }
        }
    }

    /// Writes the gradients of the weights and of either bias (both are equal) over what was there: sums over `n`
    /// sequences.
    pub fn backward_weights(
        &self,
        n: usize,
        trace: &mut Trace,
        dih: &mut [f32],
        dhh: &mut [f32],
        dbias: &mut [f32],
    ) {
        let Lstm { channels, steps, hidden } = *self;
        let (rows, width, all) = (n * steps, 4 * hidden, self.factors());
        self.samples("sequences", n, 1, trace);
        exactly("gradient of the input weights", dih.len(), width * channels);
        exactly("gradient of the recurrent weights", dhh.len(), width * hidden);
        exactly("gradient of the bias", dbias.len(), width);
        let Trace { gates, factors, dturned, halves, .. } = trace;
        let product = if halves.is_some() { half::multiply } else { few_rows };
        exactly("weight gradients of a trace", dturned.len(), width * all);
        let stride = self.gates_row();
        for from in (0..rows).step_by(TOGETHER) {
            let count = TOGETHER.min(rows - from);
            let dgates = Matrix::strided(&gates[from * stride..], count, width, stride).t();
            let factors = Matrix::new(&factors[from * all..(from + count) * all], count, all);
            product(dturned, all, dgates, factors, from > 0);
        }
        for (gate, row) in dturned.chunks_exact(all).enumerate() {
            dih[gate * channels..][..channels].copy_from_slice(&row[..channels]);
            dbias[gate] = row[channels];
            dhh[gate * hidden..][..hidden].copy_from_slice(&row[channels + 1..]);
        }
    }

    /// Computes the gradient of the input, written to or added to `dx`.
    pub fn backward_input(&self, trace: &Trace, weights: &Weights, dx: &mut [f32], accumulate: bool) {
        let Lstm { channels, steps, hidden } = *self;
        let (width, stride) = (4 * hidden, self.gates_row());
        let n = self.samples("dx", dx.len(), channels * steps, trace);
        self.check(weights);
        let ih = Matrix::new(weights.ih, width, channels);
        let product = if trace.halves.is_some() { half::multiply } else { matmul };
        for step in 0..steps {
            let dgates = Matrix::strided(&trace.gates[step * n * stride..], n, width, stride);
            product(&mut dx[step * channels..], steps * channels, dgates, ih, accumulate);
        }
    }
}

at_level! {
    /// Runs one step of one sample from the cell state `old`: gates get their functions, `c` becomes the new cell,
    /// `tanh` its tangent, `h` the new hidden state.
    pub(crate) fn cell(gates: &mut [f32], old: &[f32], c: &mut [f32], tanh: &mut [f32], h: &mut [f32]) = cell_at
}

/// Runs [`cell`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn cell_at<S: Simd>(gates: &mut [f32], old: &[f32], c: &mut [f32], tanh: &mut [f32], h: &mut [f32]) {
    let hidden = c.len();
    exactly("gates of a cell", gates.len(), 4 * hidden);
    for len in [old.len(), tanh.len(), h.len()] {
        exactly("states of a cell", len, hidden);
    }
    vectors!(S, hidden, u, lanes, {
        // SAFETY: `u + lanes <= hidden`: the asserted length of every state, and a quarter of that of the
        // gates.
        unsafe {
            let i = sigmoid_of::<S>(load::<S>(gates, u, lanes));
            let f = sigmoid_of::<S>(load::<S>(gates, hidden + u, lanes));
            let g = tanh_of::<S>(load::<S>(gates, 2 * hidden + u, lanes));
            let o = sigmoid_of::<S>(load::<S>(gates, 3 * hidden + u, lanes));
            let new = S::fma(f, load::<S>(old, u, lanes), S::mul(i, g));
            let t = tanh_of::<S>(new);
            store::<S>(gates, u, lanes, i);
            store::<S>(gates, hidden + u, lanes, f);
            store::<S>(gates, 2 * hidden + u, lanes, g);
            store::<S>(gates, 3 * hidden + u, lanes, o);
            store::<S>(c, u, lanes, new);
            store::<S>(tanh, u, lanes, t);
            store::<S>(h, u, lanes, S::mul(o, t));
        }
    });
}

at_level! {
    /// Runs one step of one sample backwards: gates become their gradients before the functions; `dc` of the cell,
    /// whose tangent is `tanh`, becomes that of the cell before, `old`.
    fn cell_backward(gates: &mut [f32], tanh: &[f32], old: &[f32], dh: &[f32], dc: &mut [f32]) = cell_backward_at
}

/// Runs [`cell_backward`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn cell_backward_at<S: Simd>(
    gates: &mut [f32],
    tanh: &[f32],
    old: &[f32],
    dh: &[f32],
    dc: &mut [f32],
) {
    let hidden = tanh.len();
    exactly("gates of a cell", gates.len(), 4 * hidden);
    for len in [old.len(), dh.len(), dc.len()] {
        exactly("states of a cell", len, hidden);
    }
    vectors!(S, hidden, u, lanes, {
        // SAFETY: `u + lanes <= hidden`: the asserted length of every state, and a quarter of that of the
        // gates.
        unsafe {
            let one = S::splat(1.0);
            let (i, f) = (load::<S>(gates, u, lanes), load::<S>(gates, hidden + u, lanes));
            let (g, o) = (load::<S>(gates, 2 * hidden + u, lanes), load::<S>(gates, 3 * hidden + u, lanes));
            let (t, old) = (load::<S>(tanh, u, lanes), load::<S>(old, u, lanes));
            let (dh, after) = (load::<S>(dh, u, lanes), load::<S>(dc, u, lanes));
            let through_tanh = S::sub(one, S::mul(t, t));
            let dcell = S::fma(S::mul(dh, o), through_tanh, after);
            store::<S>(dc, u, lanes, S::mul(dcell, f));
            store::<S>(gates, u, lanes, S::mul(S::mul(dcell, g), S::mul(i, S::sub(one, i))));
            store::<S>(gates, hidden + u, lanes, S::mul(S::mul(dcell, old), S::mul(f, S::sub(one, f))));
            let dg = S::mul(S::mul(dcell, i), S::sub(one, S::mul(g, g)));
            store::<S>(gates, 2 * hidden + u, lanes, dg);
            store::<S>(gates, 3 * hidden + u, lanes, S::mul(S::mul(dh, t), S::mul(o, S::sub(one, o))));
        }
    });
}
