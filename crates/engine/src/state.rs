//! The state of a network: parameters, running statistics and the optimisers' memory.

use taxel_graph::{Tensor, TensorKind, Weights};
use taxel_kernels::Buffer;
use taxel_kernels::optim::Adam;

use crate::compiled::Compiled;
use crate::error::Result;
use crate::layers::{read_tensor, write_tensor};
use crate::norm::Moments;
use crate::optimizer::{OptimizerMemory, OptimizerState, Sgdm};

/// All that a training run changes and goes on from; predictions only read it.
pub(crate) struct EngineState {
    /// Frozen ones last.
    pub params: Buffer,
    /// Running statistics and other values that are not learned.
    pub buffers: Vec<f32>,
    /// The forms of both that layers arranged for their forward pass, by node.
    pub packed: Vec<Vec<f32>>,
    /// Whether that is still so.
    is_packed: bool,
    /// Of every batch norm what training passes have gathered since [`EngineState::begin_recomputing`].
    gathered: Vec<Option<Moments>>,
    optimizer: OptimizerMemory,
    /// Seed of the dropout masks, and training passes so far.
    pub dropout: (u64, u64),
}

impl EngineState {
    /// Makes a state with these weights; dropout starts from seed 0 and step 0.
    ///
    /// # Errors
    /// As [`EngineState::set_weights`].
    pub fn new(compiled: &Compiled, weights: &Weights) -> Result<Self> {
        let mut state = EngineState {
            params: Buffer::zeros(compiled.sizes.params),
            buffers: vec![0.0; compiled.sizes.buffers],
            packed: vec![vec![]; compiled.nodes.len()],
            is_packed: false,
            gathered: vec![None; compiled.norms.len()],
            optimizer: OptimizerMemory::default(),
            dropout: (0, 0),
        };
        state.set_weights(compiled, weights)?;
        Ok(state)
    }

    /// Replaces all parameters and running statistics; optimisers start anew.
    ///
    /// # Errors
    /// Missing, extra or misshaped tensors, by name; nothing is replaced then.
    #[expect(clippy::expect_used, reason = "the weights are checked first")]
    pub fn set_weights(&mut self, compiled: &Compiled, weights: &Weights) -> Result<()> {
        weights.check(&compiled.graph)?;
        for (node, param, range) in compiled.tensors() {
            let tensor = weights.get(&param.name).expect("checked weights have every tensor");
            let inner = match param.kind {
                TensorKind::Parameter => &mut self.params[range],
                TensorKind::Buffer => &mut self.buffers[range],
            };
            read_tensor(node, param, &tensor.data, inner);
        }
        self.optimizer = OptimizerMemory::default();
        self.is_packed = false;
        Ok(())
    }

    /// Returns all parameters and running statistics, PyTorch's names and axis order.
    pub fn weights(&self, compiled: &Compiled) -> Weights {
        let mut weights = Weights::new();
        for (node, param, range) in compiled.tensors() {
            let inner = match param.kind {
                TensorKind::Parameter => &self.params[range],
                TensorKind::Buffer => &self.buffers[range],
            };
            let tensor = Tensor { shape: param.shape.clone(), data: write_tensor(node, param, inner) };
            weights.insert(&param.name, tensor);
        }
        weights
    }

    /// Returns the state of the optimisers.
    pub fn optimizer_state(&self, compiled: &Compiled) -> OptimizerState {
        let export = |group: &Buffer| {
            if group.is_empty() { Weights::new() } else { export_learned(compiled, group) }
        };
        OptimizerState {
            step: self.optimizer.step,
            momentum_buffer: export(&self.optimizer.velocity),
            exp_avg: export(&self.optimizer.first),
            exp_avg_sq: export(&self.optimizer.second),
        }
    }

    /// Replaces the state of the optimisers.
    ///
    /// # Errors
    /// A group that is neither empty nor holds exactly the parameters that learn, by name; nothing is
    /// replaced then.
    pub fn set_optimizer_state(&mut self, compiled: &Compiled, state: &OptimizerState) -> Result<()> {
        let groups = [&state.momentum_buffer, &state.exp_avg, &state.exp_avg_sq];
        for group in groups.iter().filter(|group| !group.is_empty()) {
            let learned = compiled.learned_tensors().map(|(_, param, _)| param);
            group.check_params(compiled.graph.name(), learned)?;
        }
        let [velocity, first, second] = groups.map(|group| import_learned(compiled, group));
        self.optimizer = OptimizerMemory { step: state.step, velocity, first, second };
        Ok(())
    }

    /// Packs what has changed since the last time; [`EngineState::is_packed`] from now on.
    pub fn pack(&mut self, compiled: &Compiled) {
        if std::mem::replace(&mut self.is_packed, true) {
            return;
        }
        let (params, buffers) = (&self.params, &self.buffers);
        compiled.threads.each(&mut self.packed, 1, |id, packed| {
            let (node, packed) = (&compiled.nodes[id], &mut packed[0]);
            if let Some(layer) = node.layer() {
                layer.pack(&params[node.params.clone()], packed);
                layer.keep(&buffers[node.buffers.clone()], packed);
            }
        });
    }

    /// Checks whether what is packed is of the parameters as they are.
    pub fn is_packed(&self) -> bool {
        self.is_packed
    }

    /// Takes one step of SGDM; `gradients` are those of the parameters that learn.
    pub fn sgdm(&mut self, compiled: &Compiled, gradients: &[f32], step: &Sgdm) {
        self.is_packed = false;
        self.optimizer.sgdm(&mut self.params[..gradients.len()], gradients, step, &compiled.spared);
    }

    /// Takes one step of Adam, or with `decoupled` weight decay of AdamW.
    pub fn adam(&mut self, compiled: &Compiled, gradients: &[f32], settings: &Adam, decoupled: bool) {
        self.is_packed = false;
        let params = &mut self.params[..gradients.len()];
        self.optimizer.adam(params, gradients, settings, decoupled, &compiled.spared);
    }

    /// Moves the running statistics of batch norm `number` towards a batch's, or gathers the batch.
    pub fn see_batch(&mut self, compiled: &Compiled, number: usize, batch: &Moments) {
        match &mut self.gathered[number] {
            Some(moments) => moments.add_all(batch),
            None => compiled.norms[number].move_running(batch, &mut self.buffers),
        }
    }

    /// Lets training passes gather, from now on, statistics over everything they see. Batch norms that keep theirs see
    /// nothing.
    pub fn begin_recomputing(&mut self, compiled: &Compiled) {
        for (moments, norm) in self.gathered.iter_mut().zip(&compiled.norms) {
            *moments = Some(Moments::new(norm.channels));
        }
    }

    /// Sets the running statistics to those gathered; without any they stay.
    pub fn end_recomputing(&mut self, compiled: &Compiled) {
        for (moments, norm) in self.gathered.iter_mut().zip(&compiled.norms) {
            if let Some(moments) = moments.take() {
                norm.set_running(&moments, &mut self.buffers);
            }
        }
    }
}

/// Returns the values of all parameters that learn, by name, PyTorch's axis order.
pub(crate) fn export_learned(compiled: &Compiled, values: &[f32]) -> Weights {
    let mut weights = Weights::new();
    for (node, param, range) in compiled.learned_tensors() {
        let data = write_tensor(node, param, &values[range]);
        weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
    }
    weights
}

/// Reads such values back; nothing of an empty `group`.
#[expect(clippy::expect_used, reason = "the group is checked first")]
fn import_learned(compiled: &Compiled, group: &Weights) -> Buffer {
    if group.is_empty() {
        return Buffer::default();
    }
    let mut values = Buffer::zeros(compiled.sizes.learned);
    for (node, param, range) in compiled.learned_tensors() {
        let tensor = group.get(&param.name).expect("a checked group has every parameter that learns");
        read_tensor(node, param, &tensor.data, &mut values[range]);
    }
    values
}
