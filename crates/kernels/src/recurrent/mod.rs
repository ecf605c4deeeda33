//! Recurrent layers over a batch of sequences.

pub mod gru;
pub mod lstm;

/// Rows of gates and factors whose products are added up at a time, few enough to stay in the cache.
const TOGETHER: usize = 64;

/// The tensors of a recurrent layer; an LSTM has four gates, a GRU three.
#[derive(Debug, Clone, Copy)]
pub struct Weights<'a> {
    /// Input weights, gates·hidden × channels.
    pub ih: &'a [f32],
    /// Recurrent weights, gates·hidden × hidden.
    pub hh: &'a [f32],
    /// First bias, gates·hidden.
    pub bias_ih: &'a [f32],
    /// Second bias, gates·hidden.
    pub bias_hh: &'a [f32],
}
