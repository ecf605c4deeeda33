//! Optimisers and what they remember from step to step.

use taxel_graph::Weights;
use taxel_kernels::Buffer;
use taxel_kernels::optim::{self, Adam};

/// Stochastic gradient descent with momentum, as `torch.optim.SGD` defines it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sgdm {
    /// Learning rate.
    pub lr: f32,
    /// Share of the last step that is kept.
    pub momentum: f32,
    /// Coupled L2 penalty, added to the gradient of every parameter.
    pub weight_decay: f32,
}

/// What the optimisers remember, by parameter name: with it, another engine goes on bit for bit.
///
/// Frozen parameters are in none of the groups; a group that no optimiser has used yet is empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OptimizerState {
    /// Steps of Adam or AdamW so far.
    pub step: u64,
    /// Velocity of SGDM.
    pub momentum_buffer: Weights,
    /// First moments of Adam and AdamW.
    pub exp_avg: Weights,
    /// Second moments of Adam and AdamW.
    pub exp_avg_sq: Weights,
}

/// The same in the engine's order; memory comes with the first step that needs it.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    pub step: u64,
    pub velocity: Buffer,
    pub first: Buffer,
    pub second: Buffer,
}

/// Makes room for `len` values if there is none.
fn fill_up(buffer: &mut Buffer, len: usize) {
    if buffer.len() != len {
        *buffer = Buffer::zeros(len);
    }
}

impl Memory {
    pub fn sgdm(&mut self, params: &mut [f32], gradients: &[f32], step: &Sgdm) {
        fill_up(&mut self.velocity, params.len());
        optim::sgdm(params, gradients, &mut self.velocity, step.lr, step.momentum, step.weight_decay);
    }

    pub fn adam(&mut self, params: &mut [f32], gradients: &[f32], settings: &Adam, decoupled: bool) {
        fill_up(&mut self.first, params.len());
        fill_up(&mut self.second, params.len());
        self.step += 1;
        let move_by = if decoupled { optim::adamw } else { optim::adam };
        move_by(params, gradients, &mut self.first, &mut self.second, settings, self.step);
    }
}
