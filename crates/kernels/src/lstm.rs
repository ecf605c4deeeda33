//! One LSTM layer over a batch of sequences: the hidden state after the last step, and its gradients.
//!
//! Values lie as batch × steps × channels. Weights are PyTorch's: 4·hidden × channels and
//! 4·hidden × hidden, gates in the order i, f, g, o.

use crate::activation::{sigmoid_of, tanh_of};
use crate::matmul::{Matrix, matmul};
use crate::reduce;

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

/// The layer's tensors.
#[derive(Debug, Clone, Copy)]
pub struct Weights<'a> {
    /// Input weights, 4·hidden × channels.
    pub ih: &'a [f32],
    /// Recurrent weights, 4·hidden × hidden.
    pub hh: &'a [f32],
    /// First bias, 4·hidden.
    pub bias_ih: &'a [f32],
    /// Second bias, 4·hidden.
    pub bias_hh: &'a [f32],
}

/// What the backward pass needs, for a batch of any size up to the one it was made for.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Gates after their functions, batch × steps × 4·hidden; [`Lstm::backward_gates`] puts the gradients
    /// before the functions in their place.
    gates: Vec<f32>,
    /// Cell states after each step, batch × steps × hidden.
    cells: Vec<f32>,
    /// Hidden states before each step, batch × steps × hidden.
    before: Vec<f32>,
    /// Gradients of one step's hidden and cell state, batch × hidden each.
    dh: Vec<f32>,
    dc: Vec<f32>,
}

impl Trace {
    /// Room for `batch` sequences.
    pub fn new(lstm: &Lstm, batch: usize) -> Self {
        let states = batch * lstm.steps * lstm.hidden;
        Trace {
            gates: vec![0.0; 4 * states],
            cells: vec![0.0; states],
            before: vec![0.0; states],
            dh: vec![0.0; batch * lstm.hidden],
            dc: vec![0.0; batch * lstm.hidden],
        }
    }
}

impl Lstm {
    /// Multiply–accumulates of one sequence.
    pub fn macs(&self) -> usize {
        self.steps * 4 * self.hidden * (self.channels + self.hidden)
    }

    /// x [n × steps × channels] → y [n × hidden], n by the length of `y`; remembers the way in `trace`.
    pub fn forward(&self, x: &[f32], weights: &Weights, trace: &mut Trace, y: &mut [f32]) {
        let Lstm { channels, steps, hidden } = *self;
        let (n, width) = (y.len() / hidden, 4 * hidden);
        let Trace { gates, cells, before, .. } = trace;
        for row in gates[..n * steps * width].chunks_exact_mut(width) {
            for (gate, (a, b)) in row.iter_mut().zip(weights.bias_ih.iter().zip(weights.bias_hh)) {
                *gate = a + b;
            }
        }
        let ih = Matrix::new(weights.ih, width, channels);
        matmul(gates, width, Matrix::new(x, n * steps, channels), ih.t(), true);
        let hh = Matrix::new(weights.hh, width, hidden);
        for step in 0..steps {
            if step > 0 {
                let h = Matrix::strided(&before[step * hidden..], n, hidden, steps * hidden);
                matmul(&mut gates[step * width..], steps * width, h, hh.t(), true);
            }
            for sample in 0..n {
                let row = sample * steps + step;
                let (i, f, g, o) = quarters(&mut gates[row * width..][..width]);
                let (old, new) = cells.split_at_mut(row * hidden);
                let c = &mut new[..hidden];
                // The first step starts from zero, whatever an earlier batch left.
                match step {
                    0 => c.fill(0.0),
                    _ => c.copy_from_slice(&old[(row - 1) * hidden..]),
                }
                let h = if step + 1 < steps {
                    &mut before[(row + 1) * hidden..][..hidden]
                } else {
                    &mut y[sample * hidden..][..hidden]
                };
                cell(i, f, g, o, c, h);
            }
        }
    }

    /// Gradients of all gates before their functions, from `dy` [n × hidden]; once after
    /// [`Lstm::forward`], before the two methods below.
    pub fn backward_gates(&self, dy: &[f32], weights: &Weights, trace: &mut Trace) {
        let Lstm { steps, hidden, .. } = *self;
        let (n, width) = (dy.len() / hidden, 4 * hidden);
        let Trace { gates, cells, dh, dc, .. } = trace;
        dh[..n * hidden].copy_from_slice(dy);
        dc[..n * hidden].fill(0.0);
        let hh = Matrix::new(weights.hh, width, hidden);
        for step in (0..steps).rev() {
            for sample in 0..n {
                let row = sample * steps + step;
                let (i, f, g, o) = quarters(&mut gates[row * width..][..width]);
                let c = &cells[row * hidden..][..hidden];
                let dh = &dh[sample * hidden..][..hidden];
                let dc = &mut dc[sample * hidden..][..hidden];
                let old = (step > 0).then(|| &cells[(row - 1) * hidden..][..hidden]);
                for u in 0..hidden {
                    let old = old.map_or(0.0, |old| old[u]);
                    let t = tanh_of(c[u]);
                    let dcell = dc[u] + dh[u] * o[u] * (1.0 - t * t);
                    dc[u] = dcell * f[u];
                    let di = dcell * g[u] * (i[u] * (1.0 - i[u]));
                    let dg = dcell * i[u] * (1.0 - g[u] * g[u]);
                    f[u] = dcell * old * (f[u] * (1.0 - f[u]));
                    o[u] = dh[u] * t * (o[u] * (1.0 - o[u]));
                    (i[u], g[u]) = (di, dg);
                }
            }
            if step > 0 {
                let dgates = Matrix::strided(&gates[step * width..], n, width, steps * width);
                matmul(dh, hidden, dgates, hh, false);
            }
        }
    }

    /// Gradients of the weights and of either bias (both are equal), overwritten; sums over the n samples
    /// of `x`.
    pub fn backward_weights(
        &self,
        x: &[f32],
        trace: &Trace,
        dih: &mut [f32],
        dhh: &mut [f32],
        dbias: &mut [f32],
    ) {
        let Lstm { channels, hidden, .. } = *self;
        let (rows, width) = (x.len() / channels, 4 * hidden);
        let gates = &trace.gates[..rows * width];
        let dgates = Matrix::new(gates, rows, width).t();
        matmul(dih, channels, dgates, Matrix::new(x, rows, channels), false);
        // Row 0 of each sequence stays zero from the start: no hidden state lies before the first step.
        matmul(dhh, hidden, dgates, Matrix::new(&trace.before, rows, hidden), false);
        dbias.fill(0.0);
        reduce::add_columns(width, gates, dbias);
    }

    /// Gradient of the input, written to or added to `dx`.
    pub fn backward_input(&self, trace: &Trace, weights: &Weights, dx: &mut [f32], accumulate: bool) {
        let (rows, width) = (dx.len() / self.channels, 4 * self.hidden);
        let ih = Matrix::new(weights.ih, width, self.channels);
        matmul(dx, self.channels, Matrix::new(&trace.gates, rows, width), ih, accumulate);
    }
}

/// One step of one sample: gates get their functions, `c` becomes the new cell, `h` the new hidden state.
fn cell(i: &mut [f32], f: &mut [f32], g: &mut [f32], o: &mut [f32], c: &mut [f32], h: &mut [f32]) {
    for gate in [&mut *i, &mut *f, &mut *o] {
        for value in gate {
            *value = sigmoid_of(*value);
        }
    }
    for value in &mut *g {
        *value = tanh_of(*value);
    }
    let (states, gates) = (c.iter_mut().zip(h), i.iter().zip(f).zip(g.iter().zip(o)));
    for ((c, h), ((i, f), (g, o))) in states.zip(gates) {
        *c = *f * *c + i * g;
        *h = *o * tanh_of(*c);
    }
}

fn quarters(row: &mut [f32]) -> (&mut [f32], &mut [f32], &mut [f32], &mut [f32]) {
    let hidden = row.len() / 4;
    let (if_, go) = row.split_at_mut(2 * hidden);
    let (i, f) = if_.split_at_mut(hidden);
    let (g, o) = go.split_at_mut(hidden);
    (i, f, g, o)
}
