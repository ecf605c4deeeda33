//! LSTM: the whole batch step by step, cut in fixed pieces of samples.

use taxel_kernels::lstm::{Lstm as LstmSizes, Trace, Weights};
use taxel_kernels::pointwise;

use super::batch_layer::{BatchBackward, BatchLayer};
use crate::threads::Threads;

/// Pieces that a batch is cut into, whatever the number of threads. Few, because the matrix products of
/// one step have as many rows as a piece has samples.
const PIECES: usize = 2;

pub(super) struct Lstm {
    sizes: LstmSizes,
    pieces: Vec<LstmChunk>,
}

/// Some samples of the batch with their own memory and gradients.
struct LstmChunk {
    trace: Trace,
    y: Vec<f32>,
    /// Gradients of the input; none where no backward pass follows.
    dx: Vec<f32>,
    /// The same of the four parameters, one after the other.
    dparams: Vec<f32>,
}

impl Lstm {
    /// Makes room for `batch` sequences, and for their gradients where it `trains`, with products of bf16
    /// where it is `half`.
    pub fn new(sizes: LstmSizes, batch: usize, trains: bool, half: bool) -> Self {
        let LstmSizes { channels, steps, hidden } = sizes;
        let most = batch.div_ceil(PIECES);
        let gradient = |len: usize| vec![0.0; if trains { len } else { 0 }];
        let piece = |_| LstmChunk {
            trace: if half { Trace::half(&sizes, most) } else { Trace::new(&sizes, most) },
            y: vec![0.0; most * hidden],
            dx: gradient(most * steps * channels),
            dparams: gradient(4 * hidden * (channels + hidden + 2)),
        };
        Lstm { sizes, pieces: (0..batch.div_ceil(most)).map(piece).collect() }
    }

    /// Returns the tensors in the order in which they lie in `params`.
    fn weights<'a>(&self, params: &'a [f32]) -> Weights<'a> {
        let LstmSizes { channels, hidden, .. } = self.sizes;
        let (ih, rest) = params.split_at(4 * hidden * channels);
        let (hh, rest) = rest.split_at(4 * hidden * hidden);
        let (bias_ih, bias_hh) = rest.split_at(4 * hidden);
        Weights { ih, hh, bias_ih, bias_hh }
    }
}

/// Returns row `piece` of rows of `len` values; shorter or empty at the end.
fn share(values: &[f32], piece: usize, len: usize) -> &[f32] {
    let start = (piece * len).min(values.len());
    &values[start..(start + len).min(values.len())]
}

impl BatchLayer for Lstm {
    fn forward(&mut self, threads: &Threads, n: usize, params: &[f32], x: &[f32], y: &mut [f32]) {
        let LstmSizes { channels, steps, hidden } = self.sizes;
        let (weights, sizes, rows) = (self.weights(params), self.sizes, n.div_ceil(PIECES));
        threads.each(&mut self.pieces, 1, |number, piece| {
            let piece = &mut piece[0];
            let x = share(x, number, rows * steps * channels);
            let count = x.len() / (steps * channels);
            if count > 0 {
                sizes.forward(x, &weights, &mut piece.trace, &mut piece.y[..count * hidden]);
            }
        });
        for (y, piece) in y.chunks_mut(rows * hidden).zip(&self.pieces) {
            y.copy_from_slice(&piece.y[..y.len()]);
        }
    }

    fn backward(&mut self, pass: BatchBackward, dparams: &mut [f32], dx: Option<&mut [f32]>) {
        let LstmSizes { channels, steps, hidden } = self.sizes;
        let BatchBackward { threads, n, params, x, dy } = pass;
        let (weights, sizes, rows) = (self.weights(params), self.sizes, n.div_ceil(PIECES));
        let (learns, wanted) = (!dparams.is_empty(), dx.is_some());
        threads.each(&mut self.pieces, 1, |number, piece| {
            let LstmChunk { trace, dx, dparams, .. } = &mut piece[0];
            let (x, dy) = (share(x, number, rows * steps * channels), share(dy, number, rows * hidden));
            if dy.is_empty() {
                return;
            }
            sizes.backward_gates(dy, &weights, trace);
            if learns {
                let (dih, rest) = dparams.split_at_mut(4 * hidden * channels);
                let (dhh, rest) = rest.split_at_mut(4 * hidden * hidden);
                let (dbias, again) = rest.split_at_mut(4 * hidden);
                sizes.backward_weights(dy.len() / hidden, trace, dih, dhh, dbias);
                again.copy_from_slice(dbias);
            }
            if wanted {
                sizes.backward_input(trace, &weights, &mut dx[..x.len()], false);
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
