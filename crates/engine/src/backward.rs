//! The backward pass over a batch.

use taxel_graph::{Loss, NodeId, Targets};
use taxel_kernels::pointwise;

use crate::compiled::Compiled;
use crate::gradients::{GradientRows, Gradients};
use crate::layers::BatchBackward;
use crate::lifetimes::GradientPlace;
use crate::part::BatchPart;
use crate::part_gradients::{PartGradients, SharedBackward};
use crate::plan::{BackwardStep, Phase};
use crate::state::EngineState;
use crate::workspace::Workspace;

/// Values of the parameters' gradients that one worker adds up at a time.
const PIECE: usize = 1 << 14;

/// Computes the loss between every output of the last training pass over `n` samples and the wanted targets, which fit
/// ([`crate::head::Head::check`]), with the weights of the samples, and the gradients of all parameters that learn.
pub(crate) fn backward(
    compiled: &Compiled,
    state: &EngineState,
    workspace: &mut Workspace,
    gradients: &mut Gradients,
    n: usize,
    wanted: (Loss, Targets, Option<&[f32]>),
) -> f32 {
    let loss = enter_loss(compiled, workspace, gradients, wanted);
    start(compiled, state, workspace, gradients);
    let mut pass = BackwardPass { compiled, state, workspace, gradients, n };
    compiled.plan.backward.iter().for_each(|phase| pass.run(phase));
    add_up(compiled, gradients);
    loss
}

/// Returns the loss, weighted as the graph says; its gradient goes to the outputs' slots.
fn enter_loss(
    compiled: &Compiled,
    workspace: &Workspace,
    gradients: &mut Gradients,
    (loss, targets, weights): (Loss, Targets, Option<&[f32]>),
) -> f32 {
    let Gradients { parts, outputs, .. } = gradients;
    let mut sum = 0.0;
    for (number, (head, gradient)) in compiled.heads.iter().zip(outputs).enumerate() {
        let (len, values) = (head.len(), workspace.output(number));
        sum += head.loss((loss, targets, weights), values, &mut gradient[..values.len()]);
        let buffer = compiled.places.places[head.slot].buffer;
        for (part, memory) in workspace.parts.iter().zip(&mut *parts) {
            let (from, len) = (part.first * len, part.count * len);
            head.seed(&gradient[from..from + len], &mut memory.slots[buffer][..len]);
        }
    }
    sum
}

/// Prepares the parts that are the same for all samples, before the first of them runs.
fn start(compiled: &Compiled, state: &EngineState, workspace: &Workspace, gradients: &mut Gradients) {
    gradients.parts.iter_mut().for_each(PartGradients::clear);
    compiled.threads.each(&mut gradients.prepared, 1, |id, prepared| {
        let node = &compiled.nodes[id];
        let wanted = compiled.plan.nodes[id].slots.iter().any(Option::is_some);
        if let Some(layer) = node.layer().filter(|_| wanted) {
            layer.prepare(&state.params[node.params.clone()], &mut prepared[0]);
        }
    });
    for (number, gradient) in gradients.norms.iter_mut().enumerate() {
        if compiled.norms[number].keeps {
            gradient.see_running(&workspace.norms[number]);
        }
    }
}

/// Adds up the parameters' gradients from what the parts have gathered, in the order of the parts.
fn add_up(compiled: &Compiled, gradients: &mut Gradients) {
    let Gradients { parts, totals, dparams, .. } = gradients;
    compiled.threads.each(totals, PIECE, |piece, totals| {
        let range = piece * PIECE..piece * PIECE + totals.len();
        totals.copy_from_slice(&parts[0].partials[range.clone()]);
        for part in &parts[1..] {
            pointwise::copy(&part.partials[range.clone()], totals, true);
        }
    });
    for node in compiled.nodes.iter().filter(|node| !node.partials.is_empty()) {
        if let Some(layer) = node.layer() {
            layer.finish(&totals[node.partials.clone()], &mut dparams[node.params.clone()]);
        }
    }
}

/// The values that a phase reads and writes.
struct BackwardPass<'a> {
    compiled: &'a Compiled,
    state: &'a EngineState,
    workspace: &'a mut Workspace,
    gradients: &'a mut Gradients,
    n: usize,
}

impl BackwardPass<'_> {
    fn run(&mut self, phase: &Phase<BackwardStep>) {
        match phase {
            Phase::Samples(steps) => self.run_samples(steps),
            Phase::Norms(numbers) => numbers.iter().for_each(|&number| self.run_norm(number)),
            &Phase::Batch(id) => self.run_batch(id),
        }
    }

    fn run_samples(&mut self, steps: &[BackwardStep]) {
        let Gradients { parts: memory, norms, prepared, .. } = &mut *self.gradients;
        let (parts, _, forward) = self.workspace.split(self.compiled, self.state, true);
        let shared = SharedBackward { forward, prepared, norms };
        let run = |part: &mut BatchPart, memory: &mut PartGradients| memory.backward(part, &shared, steps);
        self.compiled.threads.each_pair(parts, memory, run);
    }

    /// Computes the gradients of batch norm `number`, whose sums are complete.
    fn run_norm(&mut self, number: usize) {
        let Gradients { parts, norms, dparams, .. } = &mut *self.gradients;
        let gradient = &mut norms[number];
        gradient.sums.fill(0.0);
        for part in &*parts {
            gradient.sums.iter_mut().zip(&part.sums[number]).for_each(|(sum, value)| *sum += value);
        }
        let (layout, norm) = (&self.compiled.norms[number], &self.workspace.norms[number]);
        gradient.see_batch(layout, norm, self.n, &self.state.params, dparams);
    }

    /// Gathers the gradients of a node's rows, runs it, and gives its input's to the parts.
    #[expect(clippy::expect_used, reason = "the plan gives a phase to what takes the whole batch")]
    fn run_batch(&mut self, id: NodeId) {
        let Compiled { plan, nodes, places, threads, .. } = self.compiled;
        let Gradients { parts: memory, norms, prepared, rows, dparams, .. } = &mut *self.gradients;
        let (parts, batches, forward) = self.workspace.split(self.compiled, self.state, true);
        let shared = SharedBackward { forward, prepared, norms };
        let batch = batches[id].as_mut().expect("a phase of the whole batch has a layer for it");
        let (inputs, outputs) = (batch.inputs, batch.outputs);
        let GradientRows { dy, dx } = &mut rows[id];
        for (part, memory) in parts.iter().zip(&mut *memory) {
            for sample in 0..part.count {
                let to = (part.first + sample) * outputs;
                dy[to..to + outputs].copy_from_slice(memory.gradient(part, &shared, id, sample));
            }
        }
        let range = nodes[id].params.clone();
        let params = &self.state.params[range.clone()];
        // Frozen parameters have no gradients.
        let dparams = if self.compiled.learns(id) { &mut dparams[range] } else { &mut [] };
        let target = plan.nodes[id].slots[0];
        let (x, dy) = (&batch.x[..self.n * inputs], &dy[..self.n * outputs]);
        let wanted = target.is_some().then_some(&mut dx[..self.n * inputs]);
        batch.layer.backward(BatchBackward { threads, n: self.n, params, x, dy }, dparams, wanted);
        let Some((slot, add)) = target else { return };
        let GradientPlace { buffer, .. } = places.places[slot];
        for (part, memory) in parts.iter().zip(memory) {
            let (from, len) = (part.first * inputs, part.count * inputs);
            pointwise::copy(&dx[from..from + len], &mut memory.slots[buffer][..len], add);
        }
    }
}
