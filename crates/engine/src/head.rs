//! The graph's outputs: read after a forward pass, where the loss enters before a backward pass.

use taxel_graph::{Graph, Loss, Targets};
use taxel_kernels::{layout, loss, pointwise};

use crate::error::Result;
use crate::layers::view;
use crate::lifetimes::Place;
use crate::norm::Norm;
use crate::part::{NodeState, Part};
use crate::plan::{Plan, Seen};

/// One output.
pub(crate) struct Head {
    pub name: String,
    seen: Seen,
    slot: usize,
    /// Whether an earlier output has the same slot.
    again: bool,
    channels: usize,
    positions: usize,
    /// What it counts in the loss.
    weight: f32,
    /// [batch, output], PyTorch's axis order.
    pub values: Vec<f32>,
    gradient: Vec<f32>,
}

impl Head {
    /// The outputs of `graph`, for up to `batch` samples.
    pub fn all(graph: &Graph, plan: &Plan, nodes: &[NodeState], batch: usize) -> Vec<Head> {
        let head = |number: usize| {
            let (name, id) = graph.outputs()[number].clone();
            let (seen, slot) = plan.outputs[number];
            let again = plan.outputs[..number].iter().any(|&(_, earlier)| earlier == slot);
            let NodeState { channels, positions, .. } = nodes[id];
            let (values, weight) = (vec![0.0; batch * channels * positions], graph.loss_weights()[number]);
            Head { name, seen, slot, again, channels, positions, weight, gradient: values.clone(), values }
        };
        (0..graph.outputs().len()).map(head).collect()
    }

    /// Values of one sample.
    pub fn len(&self) -> usize {
        self.channels * self.positions
    }

    /// Takes the values from the parts.
    pub fn read(&mut self, parts: &[Part], norms: &[Norm]) {
        let (len, view) = (self.len(), view(&self.seen, norms));
        for part in parts.iter().filter(|part| part.count > 0) {
            let x = &part.values[self.seen.stored][..part.count * len];
            let range = part.first * len..(part.first + part.count) * len;
            if self.positions == 1 {
                view.apply(self.channels, x, &mut self.values[range]);
                continue;
            }
            let inner = &mut self.gradient[range.clone()];
            view.apply(self.channels, x, inner);
            let samples = inner.chunks_exact(len).zip(self.values[range].chunks_exact_mut(len));
            samples.for_each(|(x, y)| layout::transpose(self.positions, self.channels, x, y, false));
        }
    }

    /// Whether `targets` fit a batch of `n`.
    pub fn check(&self, model: &str, loss: Loss, n: usize, targets: Targets) -> Result<()> {
        if self.positions > 1 {
            let reason = format!("output `{}` has spatial axes; a loss takes features", self.name);
            return Err(crate::Error::Batch { model: model.into(), reason });
        }
        Ok(targets.check(model, loss, n, self.len())?)
    }

    /// The weighted loss over `n` samples, whose gradient is kept.
    pub fn loss(&mut self, loss: Loss, n: usize, targets: Targets) -> f32 {
        let len = self.len();
        let (values, gradient) = (&self.values[..n * len], &mut self.gradient[..n * len]);
        let loss = match targets {
            Targets::Labels(labels) => loss::softmax_cross_entropy(values, len, labels, gradient),
            Targets::Values(targets) if loss == Loss::MeanSquaredError => {
                loss::mean_squared_error(values, targets, gradient)
            }
            Targets::Values(targets) => loss::multi_label_soft_margin(values, targets, gradient),
        };
        gradient.iter_mut().for_each(|g| *g *= self.weight);
        self.weight * loss
    }

    /// Gives the parts the gradient.
    pub fn seed(&self, parts: &mut [Part], places: &[Place]) {
        let len = self.len();
        for part in parts {
            let (from, len) = (part.first * len, part.count * len);
            let slot = &mut part.slots[places[self.slot].buffer][..len];
            pointwise::copy(&self.gradient[from..from + len], slot, self.again);
        }
    }
}
