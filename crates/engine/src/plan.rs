//! The order of the phases: which values are stored, how each is read, and where the whole batch is needed at once.
//!
//! Batch norm, ReLU and ReLU6 store nothing. A stored value is read through a [`StoredView`]: the batch norm and
//! rectifier between it and its reader. Steps run sample by sample, several in a row while the sample is in cache;
//! only where a batch norm needs the statistics of the whole batch, or a matrix product the whole batch,
//! do all samples wait for each other.

use std::collections::HashMap;

use taxel_graph::{Activation, Graph, NodeId, Op, TensorKind};
use taxel_kernels::Rectifier;

use crate::options::FrozenStatistics;

/// How a reader sees a stored value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct StoredView {
    /// The node whose output is stored.
    pub stored: NodeId,
    /// Number of the batch norm in between.
    pub norm: Option<usize>,
    pub rectifier: Rectifier,
}

impl StoredView {
    fn plain(stored: NodeId) -> Self {
        StoredView { stored, norm: None, rectifier: Rectifier::None }
    }
}

/// A value that gradients are gathered for.
#[derive(Debug)]
pub(crate) struct Slot {
    pub seen: StoredView,
    pub len: usize,
}

/// A batch norm: its node and the stored value it normalises.
#[derive(Debug)]
pub(crate) struct NormPlan {
    pub node: NodeId,
    pub stored: NodeId,
    /// Running statistics in training too, which keeps them.
    pub keeps: bool,
    pub eps: f32,
    pub momentum: f32,
}

/// A node as the engine runs it.
#[derive(Debug, Default)]
pub(crate) struct NodePlan {
    /// Whether its output is stored (inputs and everything that is not [`lazy`]).
    pub stored: bool,
    /// Its inputs as it sees them.
    pub inputs: Vec<StoredView>,
    /// Where their gradients go, and whether they are added to earlier ones.
    pub slots: Vec<Option<(usize, bool)>>,
    /// Slots of its own output, from which its gradient is collected.
    pub gradients: Vec<usize>,
    /// Batch norms that need statistics of its output: those that do not keep theirs.
    pub norms: Vec<usize>,
}

/// A step of the backward pass that samples run on their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BackwardStep {
    Node(NodeId),
    /// Sums for a batch norm's gradient over a slot that is complete.
    Sums(usize),
}

/// The order of a pass; a step of a forward pass is a node.
#[derive(Debug)]
pub(crate) enum Phase<S> {
    Samples(Vec<S>),
    /// Batch norms whose statistics (forward) or sums (backward) are complete.
    Norms(Vec<usize>),
    /// A node that takes the whole batch at once.
    Batch(NodeId),
}

#[derive(Debug)]
pub(crate) struct ExecutionPlan {
    pub nodes: Vec<NodePlan>,
    pub slots: Vec<Slot>,
    pub norms: Vec<NormPlan>,
    /// The outputs as the loss sees them, and their slots, which are the first ones.
    pub outputs: Vec<(StoredView, usize)>,
    pub train: Vec<Phase<NodeId>>,
    /// Without a phase of batch norms.
    pub eval: Vec<Phase<NodeId>>,
    pub backward: Vec<Phase<BackwardStep>>,
}

impl ExecutionPlan {
    /// Plans the passes over `graph`. `frozen` says of every node whether its parameters stay as they are, and
    /// `statistics` whether those of frozen batch norms do.
    pub fn new(graph: &Graph, frozen: &[bool], statistics: FrozenStatistics) -> Self {
        let stored = stored(graph);
        let mut norms = vec![];
        let mut seen: Vec<StoredView> = vec![];
        let mut nodes: Vec<NodePlan> = vec![];
        for (id, node) in graph.nodes().iter().enumerate() {
            let inputs: Vec<StoredView> = node.inputs.iter().map(|&i| seen[i]).collect();
            let lazy = match node.op {
                Op::BatchNorm { eps, momentum } => {
                    let stored = inputs[0].stored;
                    let keeps = frozen[id] && statistics == FrozenStatistics::Kept;
                    norms.push(NormPlan { node: id, stored, keeps, eps, momentum });
                    Some(StoredView { norm: Some(norms.len() - 1), ..inputs[0] })
                }
                _ => rectifier(&node.op).map(|rectifier| StoredView { rectifier, ..inputs[0] }),
            };
            seen.push(lazy.filter(|_| !stored[id]).unwrap_or(StoredView::plain(id)));
            // A stored batch norm or rectifier copies what it makes others see.
            let inputs = if stored[id] { lazy.map_or(inputs, |seen| vec![seen]) } else { vec![] };
            nodes.push(NodePlan { stored: stored[id], inputs, ..NodePlan::default() });
        }
        for (number, norm) in norms.iter().enumerate().filter(|(_, norm)| !norm.keeps) {
            nodes[norm.stored].norms.push(number);
        }
        let mut slots: Vec<Slot> = vec![];
        let mut outputs = vec![];
        for &(_, id) in graph.outputs() {
            // Two outputs may be the same value.
            let slot = slots.iter().position(|slot| slot.seen == seen[id]).unwrap_or(slots.len());
            if slot == slots.len() {
                slots.push(Slot { seen: seen[id], len: len(graph, id) });
            }
            outputs.push((seen[id], slot));
        }
        let mut plan =
            ExecutionPlan { outputs, slots, nodes, norms, train: vec![], eval: vec![], backward: vec![] };
        plan.train = plan.forward(graph, true);
        plan.eval = plan.forward(graph, false);
        plan.backward = plan.backward(graph, frozen);
        plan
    }

    fn forward(&self, graph: &Graph, train: bool) -> Vec<Phase<NodeId>> {
        let mut phases = vec![];
        let mut steps = vec![];
        let mut ready: Vec<bool> = self.norms.iter().map(|norm| !train || norm.keeps).collect();
        for (id, node) in self.nodes.iter().enumerate().filter(|(_, n)| n.stored) {
            if node.inputs.iter().any(|seen| seen.norm.is_some_and(|n| !ready[n])) {
                // All that can be known by now: every later wait is one less.
                let known: Vec<usize> =
                    (0..self.norms.len()).filter(|&n| !ready[n] && self.norms[n].stored < id).collect();
                known.iter().for_each(|&n| ready[n] = true);
                flush(&mut phases, &mut steps);
                phases.push(Phase::Norms(known));
            }
            if is_batch(&graph.nodes()[id].op) {
                flush(&mut phases, &mut steps);
                phases.push(Phase::Batch(id));
            } else {
                steps.push(id);
            }
        }
        flush(&mut phases, &mut steps);
        // An output may itself be seen through a batch norm.
        let rest: Vec<usize> = (0..self.norms.len()).filter(|&n| !ready[n]).collect();
        if !rest.is_empty() {
            phases.push(Phase::Norms(rest));
        }
        phases
    }

    /// Gives the gradients their slots; the order of the pass.
    fn backward(&mut self, graph: &Graph, frozen: &[bool]) -> Vec<Phase<BackwardStep>> {
        let trains = self.trains(graph, frozen);
        let outputs = self.slots.len();
        let (reached, readers) = self.give_slots(graph, &trains);
        for (number, slot) in self.slots.iter().enumerate() {
            self.nodes[slot.seen.stored].gradients.push(number);
        }
        self.backward_phases(graph, &trains, &reached, readers, outputs)
    }

    /// Marks the nodes at or before which parameters that learn lie; a batch norm's count for its readers.
    fn trains(&self, graph: &Graph, frozen: &[bool]) -> Vec<bool> {
        let mut trains = vec![false; self.nodes.len()];
        for (id, node) in graph.nodes().iter().enumerate() {
            let learns = node.params.iter().any(|p| p.kind == TensorKind::Parameter);
            trains[id] = learns && !frozen[id] || node.inputs.iter().any(|&i| trains[i]);
        }
        trains
    }

    /// Gives a slot to every view that needs a gradient. Returns which nodes the pass reaches, and of every slot how
    /// many nodes write to it.
    fn give_slots(&mut self, graph: &Graph, trains: &[bool]) -> (Vec<bool>, Vec<usize>) {
        let needs = |seen: &StoredView, norms: &[NormPlan]| {
            trains[seen.stored] || seen.norm.is_some_and(|n| trains[norms[n].node])
        };
        // The loss writes the outputs' slots, and readers of an output add to them.
        let mut by_view: HashMap<StoredView, usize> =
            self.slots.iter().map(|slot| slot.seen).zip(0..).collect();
        let mut written = vec![true; self.slots.len()];
        let mut readers = vec![0usize; self.slots.len()];
        let mut reached = vec![false; self.nodes.len()];
        for (seen, _) in &self.outputs {
            reached[seen.stored] |= needs(seen, &self.norms);
        }
        for id in (0..self.nodes.len()).rev() {
            if !self.nodes[id].stored || !reached[id] {
                continue;
            }
            for which in 0..self.nodes[id].inputs.len() {
                let seen = self.nodes[id].inputs[which];
                let target = needs(&seen, &self.norms).then(|| {
                    let slot = *by_view.entry(seen).or_insert_with(|| {
                        self.slots.push(Slot { seen, len: len(graph, seen.stored) });
                        written.push(false);
                        readers.push(0);
                        self.slots.len() - 1
                    });
                    reached[seen.stored] = true;
                    readers[slot] += 1;
                    (slot, std::mem::replace(&mut written[slot], true))
                });
                self.nodes[id].slots.push(target);
            }
        }
        (reached, readers)
    }

    /// Returns the order of the pass; `readers` of every slot are yet to run, and the first `outputs` slots are the
    /// outputs'.
    fn backward_phases(
        &self,
        graph: &Graph,
        trains: &[bool],
        reached: &[bool],
        mut readers: Vec<usize>,
        outputs: usize,
    ) -> Vec<Phase<BackwardStep>> {
        let mut phases = vec![];
        let mut steps = vec![];
        let mut summed: Vec<bool> = self.norms.iter().map(|norm| norm.keeps).collect();
        let sums = |seen: &StoredView| seen.norm.is_some_and(|n| !self.norms[n].keeps);
        for slot in (0..outputs).filter(|&slot| readers[slot] == 0 && sums(&self.slots[slot].seen)) {
            steps.push(BackwardStep::Sums(slot));
        }
        for id in (0..self.nodes.len()).rev() {
            let node = &self.nodes[id];
            if !node.stored || !reached[id] {
                continue;
            }
            let norms = node.gradients.iter().filter_map(|&s| self.slots[s].seen.norm);
            let waits: Vec<usize> = norms.filter(|&n| !std::mem::replace(&mut summed[n], true)).collect();
            if !waits.is_empty() {
                flush(&mut phases, &mut steps);
                phases.push(Phase::Norms(waits));
            }
            // Visited for its batch norms alone: an input, or what is frozen with all before it.
            if !trains[id] {
                continue;
            }
            if is_batch(&graph.nodes()[id].op) {
                flush(&mut phases, &mut steps);
                phases.push(Phase::Batch(id));
            } else {
                steps.push(BackwardStep::Node(id));
            }
            for &(slot, _) in node.slots.iter().flatten() {
                readers[slot] -= 1;
                if readers[slot] == 0 && sums(&self.slots[slot].seen) {
                    steps.push(BackwardStep::Sums(slot));
                }
            }
        }
        flush(&mut phases, &mut steps);
        phases
    }
}

/// Returns the number of values of one sample of a node's output.
fn len(graph: &Graph, id: NodeId) -> usize {
    graph.nodes()[id].shape.iter().product()
}

fn flush<S>(phases: &mut Vec<Phase<S>>, steps: &mut Vec<S>) {
    if !steps.is_empty() {
        phases.push(Phase::Samples(std::mem::take(steps)));
    }
}

/// Checks whether a node wants all samples at once.
fn is_batch(op: &Op) -> bool {
    matches!(op, Op::Linear { .. } | Op::Lstm { .. } | Op::Gru { .. })
}

/// Returns the rectifier that a node is, if it is one.
fn rectifier(op: &Op) -> Option<Rectifier> {
    match op {
        Op::Relu => Some(Rectifier::Relu),
        Op::Activation(Activation::Relu6) => Some(Rectifier::Relu6),
        _ => None,
    }
}

/// Checks whether readers can apply an operation themselves.
fn lazy(op: &Op) -> bool {
    matches!(op, Op::BatchNorm { .. }) || rectifier(op).is_some()
}

/// Marks the outputs that are stored: all that are not lazy, and lazy ones too where a lazy one that is not the next in
/// the chain "batch norm, rectifier" reads them.
fn stored(graph: &Graph) -> Vec<bool> {
    let ops = |id: NodeId| &graph.nodes()[id].op;
    let mut stored: Vec<bool> = (0..graph.nodes().len()).map(|id| !lazy(ops(id))).collect();
    for node in graph.nodes().iter().filter(|node| lazy(&node.op)) {
        for &input in &node.inputs {
            let chained = matches!(ops(input), Op::BatchNorm { .. }) && rectifier(&node.op).is_some();
            if lazy(ops(input)) && !chained {
                stored[input] = true;
            }
        }
    }
    stored
}
