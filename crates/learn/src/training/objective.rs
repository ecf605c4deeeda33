//! The objective of a training: a loss with its targets, and how outputs are read.

use taxel_graph::{Graph, Loss, Targets, Weights};

use crate::error::Result;
use crate::training::teacher::Teacher;

/// How far above the loss of a network that knows nothing a training has diverged. A network that learns nothing stays near 1,
/// one that guesses too boldly below 3.
const DIVERGED: f64 = 10.0;

/// Runs the backward pass for a loss with its targets, and returns the loss.
pub(crate) type Backward<'b> = &'b mut dyn FnMut(Loss, Targets) -> taxel_engine::Result<f32>;

/// Predictions of a teacher for the rows of a batch.
pub(crate) type Taught<'t> = Option<&'t Teacher>;

/// A loss with its targets, and how outputs are read.
pub(crate) trait Objective {
    /// Runs `backward` for the targets of a batch, of which a teacher's predictions are part, and returns the loss.
    ///
    /// # Errors
    /// An error of the engine.
    fn backward(&self, rows: &[usize], taught: Taught, backward: Backward) -> taxel_engine::Result<f32>;

    /// Computes the mean loss of the outputs of the engine in evaluation: without smoothing and weights, so that different
    /// trainings compare.
    fn loss(&self, outputs: &[f32], rows: &[usize]) -> f64;

    /// Computes the loss of knowing nothing.
    fn idle(&self) -> f64;

    /// Returns the sum over samples of what the primary metric counts, in its unit, and the number of terms.
    fn score(&self, outputs: &[f32], rows: &[usize]) -> (f64, usize);

    /// Turns the outputs of the engine into answers: probabilities, or values in their unit.
    fn answers(&self, outputs: Vec<f32>) -> Vec<f32>;

    /// Turns trained weights into those of the model, whose outputs are in the unit of the targets.
    ///
    /// # Errors
    /// A network that ends in no layer that can be moved so.
    fn finished(&self, graph: &Graph, weights: Weights) -> Result<Weights>;

    /// Turns weights of a model into those that training goes on from.
    ///
    /// # Errors
    /// As [`Objective::finished`].
    fn begun(&self, graph: &Graph, weights: Weights) -> Result<Weights>;

    /// Turns the outputs of a finished model into answers.
    fn answers_of_model(&self, outputs: Vec<f32>) -> Vec<f32>;

    /// Returns how far below and above its answers a finished model expects the true values; empty where it says nothing of it.
    fn spread_of_model(&self, _outputs: &[f32]) -> Vec<f32> {
        vec![]
    }

    /// Computes the mean loss over test samples of the outputs of a finished model.
    ///
    /// # Errors
    /// Outputs that do not fit.
    fn test_loss(&self, outputs: &[f32], rows: &[usize]) -> Result<f64>;

    /// Checks whether a mean training loss is far above what knowing nothing costs: [`DIVERGED`] times that, or not finite.
    fn is_diverged(&self, loss: f64) -> bool {
        !loss.is_finite() || loss > DIVERGED * self.idle()
    }
}
