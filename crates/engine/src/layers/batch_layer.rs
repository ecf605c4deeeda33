//! The inputs and the duties of an operation on the whole batch.

use crate::threads::Threads;

/// Forward and backward pass of a node on the whole batch, cut into pieces by its size alone, with the memory
/// that they need.
pub(crate) trait BatchLayer: Send + Sync {
    /// Computes `y` from `x`, `n` rows each, and keeps what the backward pass needs.
    fn forward(&mut self, threads: &Threads, n: usize, params: &[f32], x: &[f32], y: &mut [f32]);

    /// Overwrites `dparams`, which are empty where nothing is learned, and `dx` where it is wanted.
    fn backward(&mut self, pass: BatchBackward, dparams: &mut [f32], dx: Option<&mut [f32]>);
}

/// The values that a backward pass over `n` rows reads.
#[derive(Clone, Copy)]
pub(crate) struct BatchBackward<'a> {
    pub threads: &'a Threads,
    pub n: usize,
    pub params: &'a [f32],
    pub x: &'a [f32],
    pub dy: &'a [f32],
}

/// A node that takes the whole batch, and its rows, gathered from the parts.
pub(crate) struct Batch {
    pub layer: Box<dyn BatchLayer>,
    /// Values of one row.
    pub inputs: usize,
    pub outputs: usize,
    pub x: Vec<f32>,
    pub y: Vec<f32>,
}
