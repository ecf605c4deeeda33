//! A network whose first output is counted in another unit.

use crate::error::{Error, Result};
use crate::graph::{Graph, NodeId};
use crate::op::Op;
use crate::weights::{Tensor, Weights};

/// Tensors of a graph, by name, and what their rows are multiplied by and moved by.
type Row<'s> = (&'s [f64], &'s [f64]);

impl Graph {
    /// Returns weights under which every value `y[i]` of the first output becomes `scale[i] · y[i] + shift[i]`: the last
    /// layers are changed, nothing is added. A network that learns scaled targets so answers in their unit.
    ///
    /// # Errors
    /// A first output that does not end in layers which can be moved so (linear, convolution, batch norm, their sums and
    /// means), a layer without a bias, another number of values than the output has, or a tensor that is missing.
    pub fn rescaled(&self, weights: &Weights, scale: &[f64], shift: &[f64]) -> Result<Weights> {
        let (name, id) = self.first_output()?;
        let values: usize = self.nodes[id].shape.iter().product();
        if scale.len() != values || shift.len() != values {
            let given = format!("output `{name}` has {values} values; {} are to be scaled", scale.len());
            return Err(Error::node(&self.name, given));
        }
        let mut changed = weights.clone();
        self.rescale(id, &mut changed, (scale, shift))?;
        Ok(changed)
    }

    /// Checks that [`Graph::rescaled`] can be asked for.
    ///
    /// # Errors
    /// As there.
    pub fn check_rescalable(&self) -> Result<()> {
        let (_, id) = self.first_output()?;
        self.last_layers(id).map(|_| ())
    }

    /// Returns the share of the first output that answers: 1 / n where it is the sum of n other outputs that learn the
    /// targets each, and has no loss itself; 1 of all others.
    pub fn answering_share(&self) -> f64 {
        let learned = |id: &NodeId| {
            let outputs = self.outputs.iter().zip(&self.loss_weights);
            outputs.skip(1).any(|((_, output), weight)| output == id && *weight != 0.0)
        };
        match (self.outputs.first(), self.loss_weights.first()) {
            (Some((_, id)), Some(0.0)) if self.nodes[*id].op == Op::Add => {
                let summands = &self.nodes[*id].inputs;
                if summands.iter().all(learned) { 1.0 / summands.len() as f64 } else { 1.0 }
            }
            _ => 1.0,
        }
    }

    fn first_output(&self) -> Result<(&str, NodeId)> {
        let first = self.outputs.first().map(|(name, id)| (name.as_str(), *id));
        first.ok_or_else(|| Error::node(&self.name, "has no output"))
    }

    /// Returns the layers that the value of `id` is the sum of, each with a channel for each value.
    fn last_layers(&self, id: NodeId) -> Result<Vec<NodeId>> {
        let layers = self.ends(id)?;
        let values: usize = self.nodes[id].shape.iter().product();
        match layers.iter().find(|layer| self.nodes[**layer].shape.first() != Some(&values)) {
            None => Ok(layers),
            Some(layer) => {
                let reason = format!("has not one channel for each of the {values} values of the output");
                Err(Error::node(&self.nodes[*layer].name, reason))
            }
        }
    }

    /// Returns the layers that the value of `id` is the sum of.
    fn ends(&self, id: NodeId) -> Result<Vec<NodeId>> {
        let node = &self.nodes[id];
        match (&node.op, node.inputs.as_slice()) {
            (Op::Linear { bias: true, .. } | Op::Conv { bias: true, .. } | Op::BatchNorm { .. }, _) => {
                Ok(vec![id])
            }
            (Op::Linear { .. } | Op::Conv { .. }, _) => Err(Error::node(
                &node.name,
                "has no bias, so that its output cannot be counted in another unit",
            )),
            (Op::GlobalAveragePool | Op::Dropout { .. } | Op::Flatten, [input]) => self.ends(*input),
            (Op::Add, inputs) => {
                let each = inputs.iter().map(|input| self.ends(*input)).collect::<Result<Vec<_>>>()?;
                Ok(each.concat())
            }
            _ => {
                let reason =
                    "is the last operation; values need a linear layer, a convolution or a batch norm there";
                Err(Error::node(&node.name, reason))
            }
        }
    }

    fn rescale(&self, id: NodeId, weights: &mut Weights, (scale, shift): Row) -> Result<()> {
        let none = vec![0.0; shift.len()];
        for (at, layer) in self.last_layers(id)?.into_iter().enumerate() {
            // The shift is that of the sum: one of its summands takes it.
            let moved = if at == 0 { shift } else { &none };
            for param in &self.nodes[layer].params {
                let Some(tensor) = weights.get(&param.name) else {
                    return Err(Error::node(&param.name, "is missing"));
                };
                let by = match param.name.rsplit('.').next() {
                    Some("weight") => (scale, none.as_slice()),
                    Some("bias") => (scale, moved),
                    // Running statistics are those of the layer before.
                    _ => continue,
                };
                let tensor = rescaled(tensor, by);
                weights.insert(&param.name, tensor);
            }
        }
        Ok(())
    }
}

/// Returns a tensor whose rows are multiplied and moved.
fn rescaled(tensor: &Tensor, (scale, shift): Row) -> Tensor {
    let each = (tensor.data.len() / scale.len().max(1)).max(1);
    let row = |(at, values): (usize, &[f32])| {
        let change = move |value: &f32| (f64::from(*value) * scale[at] + shift[at]) as f32;
        values.iter().map(change).collect::<Vec<f32>>()
    };
    Tensor { shape: tensor.shape.clone(), data: tensor.data.chunks(each).enumerate().flat_map(row).collect() }
}
