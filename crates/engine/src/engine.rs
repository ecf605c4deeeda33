//! A network in training: the compiled graph, what it has learned, and memory for both passes.

use std::sync::Arc;

use taxel_graph::{Graph, Loss, Targets, Weights};
use taxel_kernels::optim::{Adam, clip_by_global_norm};

use crate::backward::backward;
use crate::compiled::Compiled;
use crate::error::{Error, Result};
use crate::forward;
use crate::gradients::Gradients;
use crate::optimizer::{OptimizerState, Sgdm};
use crate::options::EngineOptions;
use crate::state::{EngineState, export_learned};
use crate::workspace::Workspace;

/// Which statistics batch norm uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Running statistics; nothing is changed.
    Eval,
    /// Batch statistics; running ones are moved, and what the backward pass needs is kept.
    Train,
}

/// A graph ready to train and to predict. For prediction only, take an [`Evaluator`](crate::Evaluator).
pub struct Engine {
    compiled: Arc<Compiled>,
    state: EngineState,
    workspace: Workspace,
    gradients: Gradients,
    /// Size of the last batch if it ran in training mode.
    trained: Option<usize>,
}

impl Engine {
    /// Compiles `graph` with `weights`.
    ///
    /// # Errors
    /// Weights that do not fit the graph, an empty batch, frozen names that no node with tensors has, a precision that
    /// the processor does not have, or threads that cannot be started.
    pub fn new(graph: &Graph, weights: &Weights, options: EngineOptions) -> Result<Self> {
        let compiled = Arc::new(Compiled::new(graph, &options)?);
        let state = EngineState::new(&compiled, weights)?;
        let workspace = Workspace::new(&compiled, true);
        let gradients = Gradients::new(&compiled, &workspace);
        Ok(Engine { compiled, state, workspace, gradients, trained: None })
    }

    /// Returns the network that was compiled.
    pub fn graph(&self) -> &Graph {
        &self.compiled.graph
    }

    /// Replaces all parameters and running statistics; optimisers start anew.
    ///
    /// # Errors
    /// Missing, extra or misshaped tensors, by name; nothing is replaced then.
    pub fn set_weights(&mut self, weights: &Weights) -> Result<()> {
        self.state.set_weights(&self.compiled, weights)?;
        self.trained = None;
        Ok(())
    }

    /// Returns all parameters and running statistics, PyTorch's names and axis order.
    pub fn weights(&self) -> Weights {
        self.state.weights(&self.compiled)
    }

    /// Returns the gradients of the last [`Engine::backward`], by parameter name; frozen parameters have none.
    pub fn gradients(&self) -> Weights {
        export_learned(&self.compiled, &self.gradients.dparams)
    }

    /// Returns the state of the optimisers.
    pub fn optimizer_state(&self) -> OptimizerState {
        self.state.optimizer_state(&self.compiled)
    }

    /// Goes on where [`Engine::optimizer_state`] was taken.
    ///
    /// # Errors
    /// A group that is neither empty nor holds exactly the parameters that learn, by name; nothing is
    /// replaced then.
    pub fn set_optimizer_state(&mut self, state: &OptimizerState) -> Result<()> {
        self.state.set_optimizer_state(&self.compiled, state)
    }

    /// Runs a batch, and returns the logits [n, classes]: the first output; [`Engine::outputs`] gives all.
    ///
    /// `inputs` are the graph's inputs in order, each [n, …] in PyTorch's axis order, row-major.
    ///
    /// # Errors
    /// An empty or too large batch, or inputs of another length than `n` samples have.
    pub fn forward(&mut self, inputs: &[&[f32]], n: usize, mode: Mode) -> Result<&[f32]> {
        self.trained = None;
        self.compiled.check_inputs(inputs, n)?;
        match mode {
            Mode::Eval => {
                self.state.pack(&self.compiled);
                forward::predict(&self.compiled, &self.state, &mut self.workspace, inputs, n);
            }
            Mode::Train => {
                forward::train(&self.compiled, &mut self.state, &mut self.workspace, inputs, n);
                self.trained = Some(n);
            }
        }
        Ok(self.workspace.output(0))
    }

    /// Returns names and values [n, …] of all outputs of the last forward pass, in the graph's order.
    pub fn outputs(&self) -> impl Iterator<Item = (&str, &[f32])> {
        self.workspace.outputs()
    }

    /// Computes the mean softmax cross-entropy of the last training pass, and the gradients of all parameters that
    /// learn; of several outputs the sum, weighted as the graph says.
    ///
    /// # Errors
    /// No training pass before it, or labels that are not one class number per sample.
    pub fn backward(&mut self, labels: &[u32]) -> Result<f32> {
        self.backward_with(Loss::SoftmaxCrossEntropy, Targets::Labels(labels))
    }

    /// Computes `loss` of the last training pass between every output and `targets`, weighted as the graph says, and
    /// the gradients of all parameters that learn.
    ///
    /// # Errors
    /// No training pass before it, or targets that do not fit the batch or the loss; the pass stays usable.
    pub fn backward_with(&mut self, loss: Loss, targets: Targets) -> Result<f32> {
        self.backward_of(loss, targets, None)
    }

    /// Computes the same with a weight for each sample: the loss is the mean of weight times loss, in PyTorch
    /// `(weights * loss).mean()` with `reduction="none"`.
    ///
    /// # Errors
    /// As [`Engine::backward_with`], and another number of weights than samples.
    pub fn backward_weighted(&mut self, loss: Loss, targets: Targets, weights: &[f32]) -> Result<f32> {
        self.backward_of(loss, targets, Some(weights))
    }

    fn backward_of(&mut self, loss: Loss, targets: Targets, weights: Option<&[f32]>) -> Result<f32> {
        let (compiled, model) = (&self.compiled, self.compiled.graph.name());
        let Some(n) = self.trained else {
            let reason = "backward needs a forward pass in training".into();
            return Err(Error::Batch { model: model.into(), reason });
        };
        compiled.heads.iter().try_for_each(|head| head.check(model, loss, n, targets))?;
        if let Some(weights) = weights.filter(|weights| weights.len() != n) {
            let reason = format!("{} weights for {n} samples", weights.len());
            return Err(Error::Batch { model: model.into(), reason });
        }
        self.trained = None;
        let (state, workspace, gradients) = (&self.state, &mut self.workspace, &mut self.gradients);
        Ok(backward(compiled, state, workspace, gradients, n, (loss, targets, weights)))
    }

    /// Scales the gradients of the last [`Engine::backward`] so that the norm of all together is at most
    /// `largest`; returns the norm before (`torch.nn.utils.clip_grad_norm_`).
    pub fn clip_gradients(&mut self, largest: f32) -> f32 {
        clip_by_global_norm(&mut self.gradients.dparams, largest)
    }

    /// Takes one step of SGDM with the gradients of the last [`Engine::backward`].
    pub fn sgdm(&mut self, step: &Sgdm) {
        self.state.sgdm(&self.compiled, &self.gradients.dparams, step);
    }

    /// Takes one step of Adam (`torch.optim.Adam`: coupled weight decay) with those gradients.
    pub fn adam(&mut self, settings: &Adam) {
        self.state.adam(&self.compiled, &self.gradients.dparams, settings, false);
    }

    /// Takes one step of AdamW (`torch.optim.AdamW`: decoupled weight decay) with those gradients.
    pub fn adamw(&mut self, settings: &Adam) {
        self.state.adam(&self.compiled, &self.gradients.dparams, settings, true);
    }

    /// Returns the seed of the dropout masks, and the step of the next training pass; 0 and 0 at first.
    pub fn dropout(&self) -> (u64, u64) {
        self.state.dropout
    }

    /// Sets which masks dropout draws from now on (see [`taxel_graph::DropoutMask`]): the next training pass those of
    /// `step` in a run with `seed`, the one after it those of `step + 1`.
    pub fn set_dropout(&mut self, seed: u64, step: u64) {
        self.state.dropout = (seed, step);
    }

    /// Lets training passes gather, from now on, batch-norm statistics over everything they see.
    pub fn begin_recomputing(&mut self) {
        self.state.begin_recomputing(&self.compiled);
    }

    /// Sets the running statistics to mean and variance over all training passes since [`Engine::begin_recomputing`];
    /// without such a pass they stay.
    pub fn end_recomputing(&mut self) {
        self.state.end_recomputing(&self.compiled);
    }
}
