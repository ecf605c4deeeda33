//! The forward pass over a batch.

use taxel_graph::{DropoutMask, NodeId, Op};

use crate::compiled::Compiled;
use crate::layers::view;
use crate::norm::Moments;
use crate::part::BatchPart;
use crate::plan::Phase;
use crate::state::EngineState;
use crate::workspace::Workspace;

/// Runs an evaluation: running statistics, nothing dropped; `state` is packed, and only read.
///
/// `inputs` are those of `n` samples ([`Compiled::check_inputs`]).
pub(crate) fn predict(
    compiled: &Compiled,
    state: &EngineState,
    workspace: &mut Workspace,
    inputs: &[&[f32]],
    n: usize,
) {
    assert!(state.is_packed(), "a state is packed before it predicts");
    workspace.share(n);
    workspace.masks.fill(None);
    for (norm, layout) in workspace.norms.iter_mut().zip(&compiled.norms) {
        norm.see_running(layout, &state.params, &state.buffers);
    }
    let pass = ForwardPass { compiled, inputs, n, train: false };
    for phase in &compiled.plan.eval {
        pass.run(state, workspace, phase);
    }
    workspace.read_outputs(n);
}

/// Runs a training pass: batch statistics, which move the running ones, and this step's dropout masks; the `workspace`
/// keeps what the backward pass needs.
pub(crate) fn train(
    compiled: &Compiled,
    state: &mut EngineState,
    workspace: &mut Workspace,
    inputs: &[&[f32]],
    n: usize,
) {
    state.pack(compiled);
    workspace.share(n);
    draw_masks(compiled, state, workspace);
    workspace.parts.iter_mut().flat_map(|part| &mut part.moments).for_each(Moments::clear);
    for (norm, layout) in workspace.norms.iter_mut().zip(&compiled.norms) {
        if layout.keeps {
            norm.see_running(layout, &state.params, &state.buffers);
        }
    }
    let pass = ForwardPass { compiled, inputs, n, train: true };
    for phase in &compiled.plan.train {
        match phase {
            Phase::Norms(numbers) => {
                numbers.iter().for_each(|&number| see_batch(compiled, state, workspace, number));
            }
            phase => pass.run(state, workspace, phase),
        }
    }
    workspace.read_outputs(n);
}

/// Draws the dropout masks, anew in every training pass.
fn draw_masks(compiled: &Compiled, state: &mut EngineState, workspace: &mut Workspace) {
    let (seed, step) = state.dropout;
    for (mask, node) in workspace.masks.iter_mut().zip(compiled.graph.nodes()) {
        if let Op::Dropout { probability } = node.op {
            *mask = Some(DropoutMask::new(seed, &node.name, step, probability));
        }
    }
    state.dropout.1 += 1;
}

/// Gives batch norm `number` the batch's statistics.
fn see_batch(compiled: &Compiled, state: &mut EngineState, workspace: &mut Workspace, number: usize) {
    let layout = &compiled.norms[number];
    let mut batch = Moments::new(layout.channels);
    workspace.parts.iter().for_each(|part| batch.add_all(&part.moments[number]));
    workspace.norms[number].see_batch(layout, &state.params, &batch);
    state.see_batch(compiled, number, &batch);
}

/// The values that every phase of a pass reads.
struct ForwardPass<'a> {
    compiled: &'a Compiled,
    inputs: &'a [&'a [f32]],
    n: usize,
    train: bool,
}

impl ForwardPass<'_> {
    fn run(&self, state: &EngineState, workspace: &mut Workspace, phase: &Phase<NodeId>) {
        match phase {
            Phase::Samples(nodes) => {
                let (parts, _, shared) = workspace.split(self.compiled, state, self.train);
                let run = |_, part: &mut [BatchPart]| part[0].forward(&shared, nodes, self.inputs);
                self.compiled.threads.each(parts, 1, run);
            }
            &Phase::Batch(id) => self.run_batch(state, workspace, id),
            Phase::Norms(_) => unreachable!("only training passes take statistics, and do so themselves"),
        }
    }

    /// Gathers a node's input rows, runs it, and gives the rows back to the parts.
    #[expect(clippy::expect_used, reason = "the plan gives a phase to what takes the whole batch")]
    fn run_batch(&self, state: &EngineState, workspace: &mut Workspace, id: NodeId) {
        let Compiled { plan, nodes, threads, .. } = self.compiled;
        let (parts, batches, shared) = workspace.split(self.compiled, state, self.train);
        let batch = batches[id].as_mut().expect("a phase of the whole batch has a layer for it");
        let (inputs, outputs) = (batch.inputs, batch.outputs);
        let seen = plan.nodes[id].inputs[0];
        let (view, channels) = (view(&seen, shared.norms), nodes[seen.stored].channels);
        for part in parts.iter().filter(|part| part.count > 0) {
            let (from, len) = (part.first * inputs, part.count * inputs);
            view.apply(channels, &part.values[seen.stored][..len], &mut batch.x[from..from + len]);
        }
        let params = &state.params[nodes[id].params.clone()];
        let (x, y) = (&batch.x[..self.n * inputs], &mut batch.y[..self.n * outputs]);
        batch.layer.forward(threads, self.n, params, x, y);
        for part in parts {
            let (from, len) = (part.first * outputs, part.count * outputs);
            part.values[id][..len].copy_from_slice(&y[from..from + len]);
            for sample in 0..if self.train { part.count } else { 0 } {
                part.measure(&shared, id, sample);
            }
        }
    }
}
