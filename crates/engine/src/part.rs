//! A fixed share of the batch with all its memory: what one worker runs on its own.

use taxel_graph::DropoutMask;
use taxel_kernels::{Buffer, Rectifier, batch_norm, layout, reduce};

use crate::layers::{Backward, Inputs, Layer, Outputs, Scratch, view};
use crate::lifetimes::{Place, Places};
use crate::norm::{Moments, Norm};
use crate::plan::{Plan, Step};

/// What all parts share while they run.
pub(crate) struct Shared<'a> {
    pub plan: &'a Plan,
    pub nodes: &'a [NodeState],
    pub norms: &'a [Norm],
    pub places: &'a [Place],
    pub lens: &'a [usize],
    pub params: &'a [f32],
    /// Whether batch statistics are measured and saved values kept.
    pub train: bool,
}

/// What belongs to a node and does not change while samples run.
#[derive(Default)]
pub(crate) struct NodeState {
    pub layer: Option<Box<dyn Layer>>,
    /// Channels and positions of the output.
    pub channels: usize,
    pub positions: usize,
    pub params: std::ops::Range<usize>,
    /// Where its running statistics, or other values that are not learned, are.
    pub buffers: std::ops::Range<usize>,
    /// Where the parts add up what its gradients are made of.
    pub sums: std::ops::Range<usize>,
    /// Number among the inputs of the graph.
    pub input: Option<usize>,
    pub packed: Vec<f32>,
    pub prepared: Vec<f32>,
    /// What a dropout drops in this training pass.
    pub mask: Option<DropoutMask>,
}

/// Samples `first..first + count` of the batch.
#[derive(Debug)]
pub(crate) struct Part {
    pub first: usize,
    pub count: usize,
    /// Stored output of every node, sample after sample.
    pub values: Vec<Buffer>,
    /// Memory of the slots, which [`Places`] share out.
    pub slots: Vec<Buffer>,
    saved: Vec<Buffer>,
    /// What the gradients of the sample-wise nodes' parameters are made of.
    pub gradient_sums: Buffer,
    pub moments: Vec<Moments>,
    /// Σ dy and Σ dy · (x − mean) of every batch norm.
    pub sums: Vec<Vec<f64>>,
    scratch: Scratch,
    collected: Buffer,
    column: [Vec<f32>; 2],
}

impl Part {
    /// Memory for up to `capacity` samples.
    pub fn new(
        capacity: usize,
        plan: &Plan,
        nodes: &[NodeState],
        norms: &[Norm],
        places: &Places,
        lens: &[usize],
        gradient_sums: usize,
    ) -> Self {
        let stored = |id: usize| if plan.nodes[id].stored { capacity * lens[id] } else { 0 };
        let layers = || nodes.iter().filter_map(|n| n.layer.as_ref());
        let most = |which: usize| layers().map(|l| l.scratch_len()[which]).max().unwrap_or(0);
        let channels = norms.iter().map(|n| n.channels).max().unwrap_or(0);
        Part {
            first: 0,
            count: 0,
            values: (0..lens.len()).map(|id| Buffer::zeros(stored(id))).collect(),
            slots: places.buffers.iter().map(|&len| Buffer::zeros(len)).collect(),
            saved: nodes
                .iter()
                .map(|n| Buffer::zeros(n.layer.as_ref().map_or(0, |l| capacity * l.saved_len())))
                .collect(),
            gradient_sums: Buffer::zeros(gradient_sums),
            moments: norms.iter().map(|n| Moments::new(n.channels)).collect(),
            sums: norms.iter().map(|n| vec![0.0; 2 * n.channels]).collect(),
            scratch: Scratch { x: Buffer::zeros(most(0)), halo: Buffer::zeros(most(1)) },
            collected: Buffer::zeros(lens.iter().copied().max().unwrap_or(0)),
            column: [vec![0.0; channels], vec![0.0; channels]],
        }
    }

    pub fn forward(&mut self, shared: &Shared, steps: &[Step], inputs: &[&[f32]]) {
        for sample in 0..self.count {
            for step in steps {
                let Step::Node(id) = *step else { continue };
                let (node, len) = (&shared.nodes[id], shared.lens[id]);
                let (before, rest) = self.values.split_at_mut(id);
                let y = &mut rest[0][sample * len..][..len];
                match (&node.layer, node.input) {
                    (Some(layer), _) => {
                        let plan = &shared.plan.nodes[id];
                        let inputs = Inputs {
                            plan,
                            values: before,
                            norms: shared.norms,
                            sample,
                            number: self.first + sample,
                            mask: node.mask,
                            lens: shared.lens,
                            packed: &node.packed,
                        };
                        let kept = layer.saved_len();
                        let saved = &mut self.saved[id][sample * kept..][..kept];
                        layer.forward(
                            inputs,
                            &shared.params[node.params.clone()],
                            y,
                            saved,
                            &mut self.scratch,
                        );
                    }
                    (None, Some(which)) => {
                        let x = &inputs[which][(self.first + sample) * len..][..len];
                        layout::transpose(node.channels, node.positions, x, y, false);
                    }
                    (None, None) => {}
                }
                if shared.train {
                    self.measure(shared, id, sample);
                }
            }
        }
    }

    /// Adds a sample's moments for the batch norms of node `id`.
    pub fn measure(&mut self, shared: &Shared, id: usize, sample: usize) {
        let [mean, deviations] = &mut self.column;
        for &number in &shared.plan.nodes[id].norms {
            let channels = shared.norms[number].channels;
            let x = &self.values[id][sample * shared.lens[id]..][..shared.lens[id]];
            let (mean, deviations) = (&mut mean[..channels], &mut deviations[..channels]);
            mean.fill(0.0);
            deviations.fill(0.0);
            reduce::add_columns(channels, x, mean);
            let count = shared.norms[number].positions as f32;
            mean.iter_mut().for_each(|m| *m /= count);
            reduce::add_squared_deviations(channels, x, mean, deviations);
            let moments = &mut self.moments[number];
            moments.add(f64::from(count), |c| f64::from(mean[c]), |c| f64::from(deviations[c]));
        }
    }

    pub fn backward(&mut self, shared: &Shared, steps: &[Step]) {
        for sample in 0..self.count {
            for step in steps {
                match *step {
                    Step::Node(id) => self.backward_node(shared, id, sample),
                    Step::Sums(slot) => self.add_sums(shared, slot, sample),
                }
            }
        }
    }

    fn backward_node(&mut self, shared: &Shared, id: usize, sample: usize) {
        let (node, plan) = (&shared.nodes[id], &shared.plan.nodes[id]);
        let Some(layer) = &node.layer else { return };
        let direct = self.collect(shared, id, sample);
        let len = shared.lens[id];
        // A slot's own gradient is lent out while the inputs' slots are written.
        let lent = direct.map(|slot| {
            let place = shared.places[slot];
            (place, std::mem::take(&mut self.slots[place.buffer]))
        });
        let dy = match &lent {
            Some((place, gradient)) => &gradient[sample * place.stride..][..len],
            None => &self.collected[..len],
        };
        let kept = layer.saved_len();
        let pass = Backward {
            inputs: Inputs {
                plan,
                values: &self.values,
                norms: shared.norms,
                sample,
                number: self.first + sample,
                mask: node.mask,
                lens: shared.lens,
                packed: &node.packed,
            },
            y: &self.values[id][sample * len..][..len],
            params: &shared.params[node.params.clone()],
            prepared: &node.prepared,
            saved: &self.saved[id][sample * kept..][..kept],
        };
        // Empty where nothing is learned.
        let sums = &mut self.gradient_sums[node.sums.clone()];
        let outputs =
            Outputs { plan, slots: &mut self.slots, places: shared.places, sample, lens: shared.lens };
        layer.backward(pass, dy, sums, outputs, &mut self.scratch);
        if let Some((place, gradient)) = lent {
            self.slots[place.buffer] = gradient;
        }
    }

    /// The gradient of a stored value: that of its one slot as it is, or all of them through their views
    /// into `collected`.
    pub fn collect(&mut self, shared: &Shared, id: usize, sample: usize) -> Option<usize> {
        let own = &shared.plan.nodes[id].own;
        if let [slot] = own[..] {
            let seen = &shared.plan.slots[slot].seen;
            if seen.norm.is_none() && seen.rectifier == Rectifier::None {
                return Some(slot);
            }
        }
        let len = shared.lens[id];
        let x = &self.values[id][sample * len..][..len];
        for (i, &slot) in own.iter().enumerate() {
            let seen = &shared.plan.slots[slot].seen;
            // What a batch norm takes from the whole batch counts once, however many views it has.
            let first = !own[..i].iter().any(|&s| shared.plan.slots[s].seen.norm == seen.norm);
            let gradient = seen.norm.map(|n| shared.norms[n].gradient(first));
            let place = shared.places[slot];
            let dy = &self.slots[place.buffer][sample * place.stride..][..len];
            let dx = &mut self.collected[..len];
            let channels = shared.nodes[id].channels;
            batch_norm::backward(channels, x, &view(seen, shared.norms), gradient, dy, dx, i > 0);
        }
        None
    }

    /// The last collected gradient.
    pub fn collected(&self, len: usize) -> &[f32] {
        &self.collected[..len]
    }

    fn add_sums(&mut self, shared: &Shared, slot: usize, sample: usize) {
        let seen = &shared.plan.slots[slot].seen;
        let Some(number) = seen.norm else { return };
        let (norm, len) = (&shared.norms[number], shared.lens[seen.stored]);
        let channels = norm.channels;
        let x = &self.values[seen.stored][sample * len..][..len];
        let place = shared.places[slot];
        let dy = &self.slots[place.buffer][sample * place.stride..][..len];
        let [plain, weighted] = &mut self.column;
        let (plain, weighted) = (&mut plain[..channels], &mut weighted[..channels]);
        plain.fill(0.0);
        weighted.fill(0.0);
        reduce::add_gradient_sums(channels, x, &view(seen, shared.norms), dy, &norm.mean, plain, weighted);
        for (sum, value) in self.sums[number].iter_mut().zip(plain.iter().chain(weighted.iter())) {
            *sum += f64::from(*value);
        }
    }
}
