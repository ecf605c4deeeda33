//! The trait of opened models.

use super::workspace::ModelMemory;
use crate::error::Result;

/// A frozen network, a fitted baseline or an average of some.
pub(crate) trait Ready: Send + Sync {
    /// Makes memory for one thread that predicts sample by sample.
    fn memory(&self) -> ModelMemory;

    /// Computes the logits of one encoded sample; false for the memory of another model. Nothing is allocated after the
    /// first.
    ///
    /// # Errors
    /// Inputs of another length, or that are not finite.
    fn decide_one(&self, inputs: &[Vec<f32>], memory: &mut ModelMemory, logits: &mut [f32]) -> Result<bool>;

    /// Computes the logits `[n, outputs]` of `n` encoded samples, row-major.
    ///
    /// # Errors
    /// Inputs of another number or length.
    fn decide(&self, inputs: &[&[f32]], n: usize) -> Result<Vec<f32>>;

    /// Turns rows of logits into probabilities or values, in place.
    fn finish(&self, logits: &mut [f32]);

    /// Checks whether they are logits, and not what `finish` gives.
    fn has_logits(&self) -> bool;
}
