//! The graph's outputs: how they are read after a forward pass, and their loss.

use taxel_graph::{Graph, Loss, Targets};
use taxel_kernels::{AffineView, layout, loss, pointwise};

use crate::error::{Error, Result};
use crate::plan::{ExecutionPlan, StoredView};

/// One output.
pub(crate) struct Head {
    pub name: String,
    pub seen: StoredView,
    /// Where its gradient goes.
    pub slot: usize,
    /// Whether an earlier output has the same slot.
    again: bool,
    channels: usize,
    positions: usize,
    /// Its weight in the loss.
    weight: f32,
}

impl Head {
    /// Returns the outputs of `graph`.
    pub fn all(graph: &Graph, plan: &ExecutionPlan) -> Vec<Head> {
        let head = |number: usize| {
            let (name, id) = graph.outputs()[number].clone();
            let (seen, slot) = plan.outputs[number];
            let again = plan.outputs[..number].iter().any(|&(_, earlier)| earlier == slot);
            let shape = &graph.nodes()[id].shape;
            let (channels, positions) = (shape[0], shape[1..].iter().product());
            Head { name, seen, slot, again, channels, positions, weight: graph.loss_weights()[number] }
        };
        (0..graph.outputs().len()).map(head).collect()
    }

    /// Returns the number of values of one sample.
    pub fn len(&self) -> usize {
        self.channels * self.positions
    }

    /// Returns the number of values that [`Head::read`] needs besides for `samples` samples.
    pub fn inner_len(&self, samples: usize) -> usize {
        if self.positions == 1 { 0 } else { samples * self.len() }
    }

    /// Reads values `y` of some samples, PyTorch's axis order, from the stored ones.
    pub fn read(&self, view: &AffineView, x: &[f32], inner: &mut [f32], y: &mut [f32]) {
        if self.positions == 1 {
            return view.apply(self.channels, x, y);
        }
        let inner = &mut inner[..x.len()];
        view.apply(self.channels, x, inner);
        let samples = inner.chunks_exact(self.len()).zip(y.chunks_exact_mut(self.len()));
        samples.for_each(|(x, y)| layout::transpose(self.positions, self.channels, x, y, false));
    }

    /// Checks whether `targets` fit a batch of `n`.
    pub fn check(&self, model: &str, loss: Loss, n: usize, targets: Targets) -> Result<()> {
        if self.positions > 1 {
            let reason = format!("output `{}` has spatial axes; a loss takes features", self.name);
            return Err(Error::Batch { model: model.into(), reason });
        }
        Ok(targets.check(model, loss, n, self.len())?)
    }

    /// Returns the loss of `values`, weighted as the graph says, and writes its gradient. Samples may have weights too.
    pub fn loss(
        &self,
        (loss, targets, weights): (Loss, Targets, Option<&[f32]>),
        values: &[f32],
        gradient: &mut [f32],
    ) -> f32 {
        let loss = match weights {
            None => self.mean(loss, values, targets, gradient),
            Some(weights) => self.weighted(loss, values, targets, weights, gradient),
        };
        gradient.iter_mut().for_each(|g| *g *= self.weight);
        self.weight * loss
    }

    /// Returns the mean over samples of weight times loss, and writes its gradient.
    fn weighted(
        &self,
        loss: Loss,
        values: &[f32],
        targets: Targets,
        weights: &[f32],
        gradient: &mut [f32],
    ) -> f32 {
        let (each, mut sum) = (self.len(), 0.0);
        let rows = values.chunks_exact(each).zip(gradient.chunks_exact_mut(each));
        for (row, ((values, gradient), weight)) in rows.zip(weights).enumerate() {
            let share = weight / weights.len() as f32;
            sum += share * self.mean(loss, values, targets.row(row, weights.len()), gradient);
            gradient.iter_mut().for_each(|g| *g *= share);
        }
        sum
    }

    /// Returns the mean loss of `values`, and writes its gradient.
    fn mean(&self, loss: Loss, values: &[f32], targets: Targets, gradient: &mut [f32]) -> f32 {
        let width = self.len() / loss.outputs_per_target();
        match targets {
            Targets::Labels(labels) => loss::softmax_cross_entropy(values, self.len(), labels, gradient),
            Targets::Values(targets) => match loss {
                Loss::SoftmaxCrossEntropy => {
                    loss::softmax_cross_entropy_soft(values, self.len(), targets, gradient)
                }
                Loss::MultiLabelSoftMargin | Loss::CumulativeLogits => {
                    loss::multi_label_soft_margin(values, targets, gradient)
                }
                Loss::Hinge => loss::hinge(values, targets, gradient),
                Loss::MeanSquaredError => loss::mean_squared_error(values, targets, gradient),
                Loss::Huber => loss::huber(values, targets, gradient),
                Loss::GaussianLikelihood => {
                    loss::gaussian_likelihood(values, targets, width, Loss::LEAST_VARIANCE, gradient)
                }
                Loss::Quantiles => loss::pinball(values, targets, width, &Loss::QUANTILES, gradient),
            },
        }
    }

    /// Gives some samples' gradient to their slot.
    pub fn seed(&self, gradient: &[f32], slot: &mut [f32]) {
        pointwise::copy(gradient, slot, self.again);
    }
}
