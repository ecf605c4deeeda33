//! A fixed share of the batch with its memory: what one worker runs forward on its own.

use taxel_graph::{DropoutMask, NodeId};
use taxel_kernels::{Buffer, layout, reduce};

use crate::compiled::{Compiled, NodeLayout, Runner};
use crate::layers::{Inputs, Scratch};
use crate::norm::{Moments, Norm};
use crate::plan::NodePlan;
use crate::state::EngineState;

/// The values that all parts read while they run.
#[derive(Clone, Copy)]
pub(crate) struct PartContext<'a> {
    pub compiled: &'a Compiled,
    pub state: &'a EngineState,
    pub norms: &'a [Norm],
    /// The dropout mask of every node in this pass.
    pub masks: &'a [Option<DropoutMask>],
    /// Whether batch statistics are measured.
    pub train: bool,
}

impl<'a> PartContext<'a> {
    /// Returns the inputs of the layer of node `id` for sample `sample` of a part, which is `number` in the batch;
    /// `values` are the part's.
    pub fn inputs(self, id: NodeId, values: &'a [Buffer], sample: usize, number: usize) -> Inputs<'a> {
        Inputs {
            plan: &self.compiled.plan.nodes[id],
            values,
            norms: self.norms,
            sample,
            number,
            mask: self.masks[id],
            lens: &self.compiled.lens,
            packed: &self.state.packed[id],
        }
    }
}

/// Samples `first..first + count` of the batch.
#[derive(Debug)]
pub(crate) struct BatchPart {
    pub first: usize,
    pub count: usize,
    /// Stored output of every node, sample after sample.
    pub values: Vec<Buffer>,
    /// The values that every node keeps for the backward pass: of all samples, or of one where none follows.
    pub saved: Vec<Buffer>,
    trains: bool,
    /// Statistics for every batch norm; none where no batch norm learns.
    pub moments: Vec<Moments>,
    pub scratch: Scratch,
    /// Two values per channel while they are added up.
    pub column: [Vec<f32>; 2],
}

impl BatchPart {
    /// Makes memory for the forward pass, with what the backward pass and batch statistics need where it `trains`.
    pub fn new(compiled: &Compiled, trains: bool) -> Self {
        let Compiled { plan, nodes, norms, lens, capacity, .. } = compiled;
        let samples = if trains { *capacity } else { 1 };
        let norms = if trains { norms.as_slice() } else { &[] };
        let layers = || nodes.iter().filter_map(|node| node.layer());
        let scratch = Scratch {
            x: Buffer::zeros(layers().map(|layer| layer.scratch_len()).max().unwrap_or(0)),
            work: Buffer::zeros(layers().map(|layer| layer.work_len(trains)).max().unwrap_or(0)),
        };
        let stored = |(node, len): (&NodePlan, &usize)| if node.stored { capacity * len } else { 0 };
        let saved = |node: &NodeLayout| node.layer().map_or(0, |layer| samples * layer.saved_len());
        let channels = norms.iter().map(|norm| norm.channels).max().unwrap_or(0);
        BatchPart {
            first: 0,
            count: 0,
            values: plan.nodes.iter().zip(lens).map(stored).map(Buffer::zeros).collect(),
            saved: nodes.iter().map(saved).map(Buffer::zeros).collect(),
            trains,
            moments: norms.iter().map(|norm| Moments::new(norm.channels)).collect(),
            scratch,
            column: [vec![0.0; channels], vec![0.0; channels]],
        }
    }
    /// Runs `nodes` sample by sample; `inputs` are the graph's, of the whole batch.
    pub fn forward(&mut self, shared: &PartContext, nodes: &[NodeId], inputs: &[&[f32]]) {
        for sample in 0..self.count {
            for &id in nodes {
                self.forward_node(shared, id, sample, inputs);
                if shared.train {
                    self.measure(shared, id, sample);
                }
            }
        }
    }

    fn forward_node(&mut self, shared: &PartContext, id: NodeId, sample: usize, inputs: &[&[f32]]) {
        let (node, len) = (&shared.compiled.nodes[id], shared.compiled.lens[id]);
        let number = self.first + sample;
        let (before, rest) = self.values.split_at_mut(id);
        let y = &mut rest[0][sample * len..][..len];
        match &node.job {
            Runner::Sample(layer) => {
                let kept = layer.saved_len();
                let at = if self.trains { sample * kept } else { 0 };
                layer.forward(
                    shared.inputs(id, before, sample, number),
                    &shared.state.params[node.params.clone()],
                    y,
                    &mut self.saved[id][at..][..kept],
                    &mut self.scratch,
                );
            }
            &Runner::Input(which) => {
                let x = &inputs[which][number * len..][..len];
                layout::transpose(node.channels, node.positions, x, y, false);
            }
            Runner::Batch => unreachable!("the plan gives it a phase of its own"),
        }
    }

    /// Adds a sample's moments for the batch norms of node `id`.
    pub fn measure(&mut self, shared: &PartContext, id: NodeId, sample: usize) {
        let Compiled { plan, norms, lens, .. } = shared.compiled;
        let [mean, deviations] = &mut self.column;
        for &number in &plan.nodes[id].norms {
            let channels = norms[number].channels;
            let x = &self.values[id][sample * lens[id]..][..lens[id]];
            let (mean, deviations) = (&mut mean[..channels], &mut deviations[..channels]);
            mean.fill(0.0);
            deviations.fill(0.0);
            reduce::add_columns(channels, x, mean);
            let count = norms[number].positions as f32;
            mean.iter_mut().for_each(|m| *m /= count);
            reduce::add_squared_deviations(channels, x, mean, deviations);
            let moments = &mut self.moments[number];
            moments.add(f64::from(count), |c| f64::from(mean[c]), |c| f64::from(deviations[c]));
        }
    }
}
