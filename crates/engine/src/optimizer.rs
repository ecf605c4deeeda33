//! Optimisers and what they remember from step to step.

use std::ops::Range;

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

/// The state of the optimisers, by parameter name: with it, another engine goes on bit for bit.
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
pub(crate) struct OptimizerMemory {
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

impl OptimizerMemory {
    /// Takes a step of SGDM with `params`, of which the ranges in `spared` do not decay.
    pub fn sgdm(&mut self, params: &mut [f32], gradients: &[f32], step: &Sgdm, spared: &[Range<usize>]) {
        fill_up(&mut self.velocity, params.len());
        for (range, decays) in stretches(params.len(), spared) {
            let decay = if decays { step.weight_decay } else { 0.0 };
            let (params, velocity) = (&mut params[range.clone()], &mut self.velocity[range.clone()]);
            optim::sgdm(params, &gradients[range], velocity, step.lr, step.momentum, decay);
        }
    }

    /// Takes the same step of Adam, or with `decoupled` weight decay of AdamW.
    pub fn adam(
        &mut self,
        params: &mut [f32],
        gradients: &[f32],
        settings: &Adam,
        decoupled: bool,
        spared: &[Range<usize>],
    ) {
        fill_up(&mut self.first, params.len());
        fill_up(&mut self.second, params.len());
        self.step += 1;
        let move_by = if decoupled { optim::adamw } else { optim::adam };
        for (range, decays) in stretches(params.len(), spared) {
            let weight_decay = if decays { settings.weight_decay } else { 0.0 };
            let (params, gradients) = (&mut params[range.clone()], &gradients[range.clone()]);
            let (first, second) = (&mut self.first[range.clone()], &mut self.second[range]);
            move_by(params, gradients, first, second, &Adam { weight_decay, ..*settings }, self.step);
        }
    }
}

/// Cuts all `len` parameters into stretches, and says whether they decay; `spared` ascend.
fn stretches(len: usize, spared: &[Range<usize>]) -> impl Iterator<Item = (Range<usize>, bool)> {
    let before = std::iter::once(0).chain(spared.iter().map(|range| range.end));
    let after = spared.iter().map(|range| range.start).chain([len]);
    let decaying = before.zip(after).map(|(start, end)| (start..end, true));
    let spared = spared.iter().map(|range| (range.clone(), false));
    decaying.chain(spared).filter(|(range, _)| !range.is_empty())
}
