//! A network for prediction only, shared by threads.

use std::sync::Arc;

use taxel_graph::{Graph, Weights};

use crate::compiled::Compiled;
use crate::error::{Error, Result};
use crate::forward;
use crate::options::EngineOptions;
use crate::state::EngineState;
use crate::workspace::Workspace;

/// A graph with its weights, ready to predict in evaluation mode, bit for bit as
/// [`Engine::forward`](crate::Engine::forward) in [`Mode::Eval`](crate::Mode::Eval) does.
///
/// It never changes: threads share one by reference, each with a [`Workspace`] of its own. Where there are
/// several callers, [`EngineOptions::threads`] of 1 lets each run in its own thread; more are a pool that all callers
/// share.
pub struct Evaluator {
    compiled: Arc<Compiled>,
    state: EngineState,
}

impl Evaluator {
    /// Compiles `graph` with `weights`; [`EngineOptions::frozen`] does not matter to predictions.
    ///
    /// # Errors
    /// Weights that do not fit the graph, an empty batch, frozen names that no node with tensors has, a precision that
    /// the processor does not have, or threads that cannot be started.
    pub fn new(graph: &Graph, weights: &Weights, options: EngineOptions) -> Result<Self> {
        let compiled = Compiled::new(graph, &options)?;
        let mut state = EngineState::new(&compiled, weights)?;
        state.pack(&compiled);
        Ok(Evaluator { compiled: Arc::new(compiled), state })
    }

    /// Returns the network that was compiled.
    pub fn graph(&self) -> &Graph {
        &self.compiled.graph
    }

    /// Makes memory for the predictions of one caller, for batches of up to [`EngineOptions::batch`] samples.
    pub fn workspace(&self) -> Workspace {
        Workspace::new(&self.compiled, false)
    }

    /// Runs a batch, and returns the logits [n, classes]: the first output; [`Workspace::outputs`] gives all.
    ///
    /// `inputs` are the graph's inputs in order, each [n, …] in PyTorch's axis order, row-major.
    ///
    /// # Errors
    /// A workspace of another evaluator, an empty or too large batch, or inputs of another length than `n`
    /// samples have.
    pub fn predict<'w>(
        &self,
        workspace: &'w mut Workspace,
        inputs: &[&[f32]],
        n: usize,
    ) -> Result<&'w [f32]> {
        if !workspace.fits(&self.compiled) {
            return Err(Error::Workspace { model: self.compiled.graph.name().into() });
        }
        self.compiled.check_inputs(inputs, n)?;
        forward::predict(&self.compiled, &self.state, workspace, inputs, n);
        Ok(workspace.output(0))
    }
}
