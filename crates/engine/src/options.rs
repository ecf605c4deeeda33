//! How a graph is compiled, as the caller says it.

use serde::{Deserialize, Serialize};

/// How a graph is compiled.
#[derive(Debug, Clone)]
pub struct EngineOptions {
    /// Largest number of samples of one batch.
    pub batch: usize,
    /// Worker threads at most, of which more than 64 and more than there are cores are refused; 1 runs in the calling
    /// thread, and so do batches too small to share. Results do not depend on it.
    pub threads: usize,
    /// Nodes that training leaves as they are, by name or by a name's first parts (`stem` is every node
    /// `stem.…`). Their parameters get no gradient and no step.
    pub frozen: Vec<String>,
    /// The treatment of the statistics of frozen batch norms.
    pub frozen_statistics: FrozenStatistics,
    /// Which parameters the weight decay of optimisers touches.
    pub decay: Decay,
    /// Numbers that products are made of.
    pub precision: Precision,
}

/// Numbers that products of convolutions, linear and recurrent layers are made of. All else is f32: weights, their steps,
/// sums, statistics.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// Floats.
    #[default]
    F32,
    /// Factors rounded to bf16, summed in f32, by the processor's own instruction; an error where it has none.
    /// Depthwise convolutions and groups of an odd number of channels stay in f32.
    Bf16,
}

/// Which parameters the weight decay of optimisers touches.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Decay {
    /// All of them, as PyTorch's optimisers do.
    #[default]
    All,
    /// Those with at least two axes: weights of convolutions, linear and recurrent layers, not biases and batch
    /// norms.
    Matrices,
}

/// The treatment of the running statistics of frozen batch norms; their weight and bias stay.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FrozenStatistics {
    /// They are used in training and kept (PyTorch: `requires_grad_(False)` and `eval()`).
    #[default]
    Kept,
    /// As of all other batch norms: training uses a batch's, and moves them (PyTorch: `requires_grad_(False)` only). So
    /// does a learning rate of zero in MATLAB R2019a, with which Rouhafzay et al. 2021 freeze (sections 1 and 4).
    Renewed,
}

impl Default for EngineOptions {
    /// Makes options for one sample, one thread, nothing frozen, decay of everything, f32.
    fn default() -> Self {
        EngineOptions {
            batch: 1,
            threads: 1,
            frozen: vec![],
            frozen_statistics: FrozenStatistics::Kept,
            decay: Decay::All,
            precision: Precision::F32,
        }
    }
}
