//! Memory of a forward pass.

use std::sync::Arc;

use taxel_graph::DropoutMask;

use crate::compiled::Compiled;
use crate::layers::{Batch, build_batch, view};
use crate::norm::Norm;
use crate::part::{BatchPart, PartContext};
use crate::state::EngineState;

/// Memory of one thread that predicts with an [`Evaluator`](crate::Evaluator), which makes it: the values of a batch,
/// allocated once.
pub struct Workspace {
    compiled: Arc<Compiled>,
    pub(crate) parts: Vec<BatchPart>,
    pub(crate) norms: Vec<Norm>,
    /// The dropout mask of every node in this pass.
    pub(crate) masks: Vec<Option<DropoutMask>>,
    /// Nodes that take the whole batch.
    pub(crate) batches: Vec<Option<Batch>>,
    outputs: Vec<OutputValues>,
    /// Size of the last batch.
    last: usize,
}

/// Values of one output.
struct OutputValues {
    /// [batch, output], PyTorch's axis order.
    values: Vec<f32>,
    /// Some of them in the engine's order, where that is another.
    inner: Vec<f32>,
}

impl Workspace {
    /// Makes memory for predictions, or with all that the backward pass and batch statistics need for passes that are
    /// trained on.
    pub(crate) fn new(compiled: &Arc<Compiled>, trains: bool) -> Self {
        let Compiled { graph, batch, capacity, half, .. } = compiled.as_ref();
        Workspace {
            compiled: Arc::clone(compiled),
            parts: (0..compiled.parts()).map(|_| BatchPart::new(compiled, trains)).collect(),
            norms: compiled.norms.iter().map(|norm| Norm::new(norm.channels)).collect(),
            masks: vec![None; graph.nodes().len()],
            batches: graph
                .nodes()
                .iter()
                .map(|node| build_batch(graph, node, *batch, trains, *half))
                .collect(),
            outputs: (compiled.heads.iter())
                .map(|head| OutputValues {
                    values: vec![0.0; batch * head.len()],
                    inner: vec![0.0; head.inner_len(*capacity)],
                })
                .collect(),
            last: 0,
        }
    }

    /// Checks whether it was made for `compiled`.
    pub(crate) fn fits(&self, compiled: &Arc<Compiled>) -> bool {
        Arc::ptr_eq(&self.compiled, compiled)
    }

    /// Returns the parts, what takes the whole batch, and what the parts read while they run.
    pub(crate) fn split<'a>(
        &'a mut self,
        compiled: &'a Compiled,
        state: &'a EngineState,
        train: bool,
    ) -> (&'a mut [BatchPart], &'a mut [Option<Batch>], PartContext<'a>) {
        let shared = PartContext { compiled, state, norms: &self.norms, masks: &self.masks, train };
        (&mut self.parts, &mut self.batches, shared)
    }

    /// Gives the parts equal shares of a batch of `n`, whatever its size.
    pub(crate) fn share(&mut self, n: usize) {
        let each = n.div_ceil(self.parts.len());
        for (number, part) in self.parts.iter_mut().enumerate() {
            part.first = (number * each).min(n);
            part.count = ((number + 1) * each).min(n) - part.first;
        }
    }

    /// Takes the outputs of a batch of `n` from the parts.
    pub(crate) fn read_outputs(&mut self, n: usize) {
        for (head, OutputValues { values, inner }) in self.compiled.heads.iter().zip(&mut self.outputs) {
            let (len, view) = (head.len(), view(&head.seen, &self.norms));
            for part in self.parts.iter().filter(|part| part.count > 0) {
                let x = &part.values[head.seen.stored][..part.count * len];
                head.read(&view, x, inner, &mut values[part.first * len..][..part.count * len]);
            }
        }
        self.last = n;
    }

    /// Returns the values of output `number` of the last batch, [n, …].
    pub(crate) fn output(&self, number: usize) -> &[f32] {
        &self.outputs[number].values[..self.last * self.compiled.heads[number].len()]
    }

    /// Returns names and values [n, …] of all outputs of the last batch, in the graph's order, PyTorch's axis order.
    pub fn outputs(&self) -> impl Iterator<Item = (&str, &[f32])> {
        (0..).zip(&self.compiled.heads).map(|(number, head)| (head.name.as_str(), self.output(number)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::options::EngineOptions;

    #[test]
    fn memory_for_answers_keeps_nothing_for_a_backward_pass() {
        for name in ["hybrid-resvgg", "densenet6-lite-2d", "mobilenet-v2"] {
            let graph = taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap();
            let options = EngineOptions { batch: 16, ..EngineOptions::default() };
            let compiled = Arc::new(Compiled::new(&graph, &options).unwrap());
            let saved = |part: &BatchPart| part.saved.iter().map(|values| values.len()).sum::<usize>();
            let (predicts, trains) = (Workspace::new(&compiled, false), Workspace::new(&compiled, true));
            for (predicts, trains) in predicts.parts.iter().zip(&trains.parts) {
                assert_eq!(saved(trains), compiled.capacity * saved(predicts), "{name}: one sample's");
                assert!(predicts.moments.is_empty() && !trains.moments.is_empty(), "{name}");
                assert!(predicts.scratch.work.len() <= trains.scratch.work.len(), "{name}");
            }
        }
    }
}
