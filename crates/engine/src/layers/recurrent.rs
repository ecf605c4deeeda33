//! LSTM and GRU: the whole batch step by step, cut in fixed pieces of samples.

use taxel_kernels::gru::{self, Gru};
use taxel_kernels::lstm::{self, Lstm, Weights};
use taxel_kernels::pointwise;

use super::batch_layer::{BatchBackward, BatchLayer};
use crate::threads::Threads;

/// Pieces that a batch is cut into, whatever the number of threads. Few, because the matrix products of
/// one step have as many rows as a piece has samples.
const PIECES: usize = 2;

/// A kind of recurrent layer, with its sizes.
pub(super) trait Cell: Copy + Send + Sync {
    /// Gates of one hidden unit.
    const GATES: usize;
    /// The values of the forward pass that the backward pass needs.
    type Trace: Send + Sync;

    /// Returns channels, steps and hidden units.
    fn sizes(&self) -> [usize; 3];

    /// Makes room for `batch` sequences, with products of bf16 where it is `half`.
    fn trace(&self, batch: usize, half: bool) -> Self::Trace;

    /// Computes the hidden states after the last step.
    fn forward(&self, x: &[f32], weights: &Weights, trace: &mut Self::Trace, y: &mut [f32]);

    /// Computes the gradients of the gates; before the two methods below.
    fn backward_gates(&self, dy: &[f32], weights: &Weights, trace: &mut Self::Trace);

    /// Overwrites the gradients of the four tensors with sums over the sequences `x`.
    fn backward_weights(&self, x: &[f32], trace: &mut Self::Trace, gradients: [&mut [f32]; 4]);

    /// Overwrites the gradient of the input.
    fn backward_input(&self, trace: &Self::Trace, weights: &Weights, dx: &mut [f32]);
}

impl Cell for Lstm {
    const GATES: usize = 4;
    type Trace = lstm::Trace;

    fn sizes(&self) -> [usize; 3] {
        [self.channels, self.steps, self.hidden]
    }

    fn trace(&self, batch: usize, half: bool) -> Self::Trace {
        if half { lstm::Trace::half(self, batch) } else { lstm::Trace::new(self, batch) }
    }

    fn forward(&self, x: &[f32], weights: &Weights, trace: &mut Self::Trace, y: &mut [f32]) {
        Lstm::forward(self, x, weights, trace, y);
    }

    fn backward_gates(&self, dy: &[f32], weights: &Weights, trace: &mut Self::Trace) {
        Lstm::backward_gates(self, dy, weights, trace);
    }

    fn backward_weights(&self, x: &[f32], trace: &mut Self::Trace, gradients: [&mut [f32]; 4]) {
        let [dih, dhh, dbias, again] = gradients;
        Lstm::backward_weights(self, x.len() / (self.steps * self.channels), trace, dih, dhh, dbias);
        again.copy_from_slice(dbias);
    }

    fn backward_input(&self, trace: &Self::Trace, weights: &Weights, dx: &mut [f32]) {
        Lstm::backward_input(self, trace, weights, dx, false);
    }
}

impl Cell for Gru {
    const GATES: usize = 3;
    type Trace = gru::Trace;

    fn sizes(&self) -> [usize; 3] {
        [self.channels, self.steps, self.hidden]
    }

    fn trace(&self, batch: usize, half: bool) -> Self::Trace {
        if half { gru::Trace::half(self, batch) } else { gru::Trace::new(self, batch) }
    }

    fn forward(&self, x: &[f32], weights: &Weights, trace: &mut Self::Trace, y: &mut [f32]) {
        Gru::forward(self, x, weights, trace, y);
    }

    fn backward_gates(&self, dy: &[f32], weights: &Weights, trace: &mut Self::Trace) {
        Gru::backward_gates(self, dy, weights, trace);
    }

    fn backward_weights(&self, x: &[f32], trace: &mut Self::Trace, gradients: [&mut [f32]; 4]) {
        let [dih, dhh, dbias_ih, dbias_hh] = gradients;
        Gru::backward_weights(self, x, trace, dih, dhh);
        self.backward_biases(x.len() / (self.steps * self.channels), trace, dbias_ih, dbias_hh);
    }

    fn backward_input(&self, trace: &Self::Trace, weights: &Weights, dx: &mut [f32]) {
        Gru::backward_input(self, trace, weights, dx, false);
    }
}

pub(super) struct Recurrent<C: Cell> {
    cell: C,
    pieces: Vec<BatchPiece<C::Trace>>,
}

/// Some samples of the batch with their own memory and gradients.
struct BatchPiece<T> {
    trace: T,
    y: Vec<f32>,
    /// Gradients of the input; none where no backward pass follows.
    dx: Vec<f32>,
    /// The same of the four parameters, one after the other.
    dparams: Vec<f32>,
}

impl<C: Cell> Recurrent<C> {
    /// Makes room for `batch` sequences, and for their gradients where it `trains`, with products of bf16
    /// where it is `half`.
    pub fn new(cell: C, batch: usize, trains: bool, half: bool) -> Self {
        let [channels, steps, hidden] = cell.sizes();
        let most = batch.div_ceil(PIECES);
        let gradient = |len: usize| vec![0.0; if trains { len } else { 0 }];
        let piece = |_| BatchPiece {
            trace: cell.trace(most, half),
            y: vec![0.0; most * hidden],
            dx: gradient(most * steps * channels),
            dparams: gradient(C::GATES * hidden * (channels + hidden + 2)),
        };
        Recurrent { cell, pieces: (0..batch.div_ceil(most)).map(piece).collect() }
    }

    /// Returns the lengths of the first three tensors in the order in which they lie in memory.
    fn lens(cell: C) -> [usize; 3] {
        let [channels, _, hidden] = cell.sizes();
        [channels, hidden, 1].map(|columns| C::GATES * hidden * columns)
    }

    fn weights(cell: C, params: &[f32]) -> Weights<'_> {
        let lens = Self::lens(cell);
        let (ih, rest) = params.split_at(lens[0]);
        let (hh, rest) = rest.split_at(lens[1]);
        let (bias_ih, bias_hh) = rest.split_at(lens[2]);
        Weights { ih, hh, bias_ih, bias_hh }
    }
}

/// Returns row `piece` of rows of `len` values; shorter or empty at the end.
fn share(values: &[f32], piece: usize, len: usize) -> &[f32] {
    let start = (piece * len).min(values.len());
    &values[start..(start + len).min(values.len())]
}

impl<C: Cell> BatchLayer for Recurrent<C> {
    fn forward(&mut self, threads: &Threads, n: usize, params: &[f32], x: &[f32], y: &mut [f32]) {
        let (cell, rows) = (self.cell, n.div_ceil(PIECES));
        let [channels, steps, hidden] = cell.sizes();
        let weights = Self::weights(cell, params);
        threads.each(&mut self.pieces, 1, |number, piece| {
            let piece = &mut piece[0];
            let x = share(x, number, rows * steps * channels);
            let count = x.len() / (steps * channels);
            if count > 0 {
                cell.forward(x, &weights, &mut piece.trace, &mut piece.y[..count * hidden]);
            }
        });
        for (y, piece) in y.chunks_mut(rows * hidden).zip(&self.pieces) {
            y.copy_from_slice(&piece.y[..y.len()]);
        }
    }

    fn backward(&mut self, pass: BatchBackward, dparams: &mut [f32], dx: Option<&mut [f32]>) {
        let BatchBackward { threads, n, params, x, dy } = pass;
        let (cell, rows) = (self.cell, n.div_ceil(PIECES));
        let [channels, steps, hidden] = cell.sizes();
        let (weights, lens) = (Self::weights(cell, params), Self::lens(cell));
        let (learns, wanted) = (!dparams.is_empty(), dx.is_some());
        threads.each(&mut self.pieces, 1, |number, piece| {
            let BatchPiece { trace, dx, dparams, .. } = &mut piece[0];
            let (x, dy) = (share(x, number, rows * steps * channels), share(dy, number, rows * hidden));
            if dy.is_empty() {
                return;
            }
            cell.backward_gates(dy, &weights, trace);
            if learns {
                let (dih, rest) = dparams.split_at_mut(lens[0]);
                let (dhh, rest) = rest.split_at_mut(lens[1]);
                let (dbias_ih, dbias_hh) = rest.split_at_mut(lens[2]);
                cell.backward_weights(x, trace, [dih, dhh, dbias_ih, dbias_hh]);
            }
            if wanted {
                cell.backward_input(trace, &weights, &mut dx[..x.len()]);
            }
        });
        for (number, piece) in self.pieces.iter().enumerate().take(n.div_ceil(rows)) {
            if learns {
                pointwise::copy(&piece.dparams, dparams, number > 0);
            }
        }
        if let Some(dx) = dx {
            for (dx, piece) in dx.chunks_mut(rows * steps * channels).zip(&self.pieces) {
                dx.copy_from_slice(&piece.dx[..dx.len()]);
            }
        }
    }
}
