//! What one thread needs to ask a model reading by reading.

use taxel_runtime as runtime;

use crate::encoding::Compiled;

/// What one thread needs to ask a [`Predictor`](super::Predictor), which makes it: memory for all inputs and values,
/// allocated once.
pub struct Workspace {
    pub(super) encoders: Vec<Compiled>,
    /// Of the last reading.
    pub(super) inputs: Vec<Vec<f32>>,
    pub(super) memory: Memory,
    /// Of the last answer.
    pub(super) probabilities: Vec<f32>,
}

/// Memory of a kind of model.
pub(super) enum Memory {
    Network(Box<runtime::Workspace>),
    /// One of each attribute.
    Baseline(Vec<taxel_baselines::Workspace>),
}

impl Workspace {
    pub(super) fn new(encoders: Vec<Compiled>, memory: Memory, outputs: usize) -> Self {
        let input = |encoder: &Compiled| vec![0.0; encoder.shape().iter().product()];
        let inputs = encoders.iter().map(input).collect();
        Workspace { encoders, inputs, memory, probabilities: vec![0.0; outputs] }
    }
}
