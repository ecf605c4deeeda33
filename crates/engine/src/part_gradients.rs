//! The gradients of a fixed share of the batch: what one worker runs backward on its own.

use taxel_graph::NodeId;
use taxel_kernels::{Buffer, Rectifier, batch_norm, reduce};

use crate::compiled::Compiled;
use crate::layers::{Backward, Outputs, view};
use crate::lifetimes::GradientPlace;
use crate::norm::NormGradient;
use crate::part::{BatchPart, PartContext};
use crate::plan::BackwardStep;

/// The values that all parts read while they run backward.
#[derive(Clone, Copy)]
pub(crate) struct SharedBackward<'a> {
    pub forward: PartContext<'a>,
    /// The forms of the parameters that layers prepare for their backward pass, by node.
    pub prepared: &'a [Vec<f32>],
    pub norms: &'a [NormGradient],
}

/// Gradients that belong to a [`BatchPart`].
#[derive(Debug)]
pub(crate) struct PartGradients {
    /// Memory of the slots, which `GradientPlaces` share out.
    pub slots: Vec<Buffer>,
    /// The sums that the gradients of the sample-wise nodes' parameters are made of.
    pub partials: Buffer,
    /// Σ dy and Σ dy · (x − mean) of every batch norm.
    pub sums: Vec<Vec<f64>>,
    collected: Buffer,
}

impl PartGradients {
    pub fn new(compiled: &Compiled) -> Self {
        PartGradients {
            slots: compiled.places.buffers.iter().map(|&len| Buffer::zeros(len)).collect(),
            partials: Buffer::zeros(compiled.sizes.partials),
            sums: compiled.norms.iter().map(|norm| vec![0.0; 2 * norm.channels]).collect(),
            collected: Buffer::zeros(compiled.lens.iter().copied().max().unwrap_or(0)),
        }
    }

    /// Forgets what an earlier pass added up.
    pub fn clear(&mut self) {
        self.partials.fill(0.0);
        self.sums.iter_mut().for_each(|sums| sums.fill(0.0));
    }

    /// Runs `steps` sample by sample.
    pub fn backward(&mut self, part: &mut BatchPart, shared: &SharedBackward, steps: &[BackwardStep]) {
        for sample in 0..part.count {
            for step in steps {
                match *step {
                    BackwardStep::Node(id) => self.backward_node(part, shared, id, sample),
                    BackwardStep::Sums(slot) => self.add_sums(part, shared, slot, sample),
                }
            }
        }
    }

    #[expect(clippy::expect_used, reason = "the plan's steps are of nodes that samples run on their own")]
    fn backward_node(&mut self, part: &mut BatchPart, shared: &SharedBackward, id: NodeId, sample: usize) {
        let SharedBackward { forward, prepared, .. } = *shared;
        let Compiled { plan, nodes, places, lens, .. } = forward.compiled;
        let (node, len) = (&nodes[id], lens[id]);
        let layer = node.layer().expect("inputs and what takes the whole batch are no steps");
        // A slot's own gradient is lent out while the inputs' slots are written.
        let direct = self.collect(part, shared, id, sample);
        let lent = direct.map(|place| (place, std::mem::take(&mut self.slots[place.buffer])));
        let dy = match &lent {
            Some((place, gradient)) => &gradient[sample * place.stride..][..len],
            None => &self.collected[..len],
        };
        let kept = layer.saved_len();
        let pass = Backward {
            inputs: forward.inputs(id, &part.values, sample, part.first + sample),
            y: &part.values[id][sample * len..][..len],
            params: &forward.state.params[node.params.clone()],
            prepared: &prepared[id],
            saved: &part.saved[id][sample * kept..][..kept],
        };
        let outputs =
            Outputs { plan: &plan.nodes[id], slots: &mut self.slots, places: &places.places, sample, lens };
        // Empty where nothing is learned.
        let partials = &mut self.partials[node.partials.clone()];
        layer.backward(pass, dy, partials, outputs, &mut part.scratch);
        if let Some((place, gradient)) = lent {
            self.slots[place.buffer] = gradient;
        }
    }

    /// Returns the gradient of a sample's stored value.
    pub fn gradient(
        &mut self,
        part: &BatchPart,
        shared: &SharedBackward,
        id: NodeId,
        sample: usize,
    ) -> &[f32] {
        let len = shared.forward.compiled.lens[id];
        match self.collect(part, shared, id, sample) {
            Some(place) => &self.slots[place.buffer][sample * place.stride..][..len],
            None => &self.collected[..len],
        }
    }

    /// Returns where that gradient lies: at its one slot if that is the value as it is. If not, adds it up in
    /// `collected` from all its slots, through their views, and returns `None`.
    fn collect(
        &mut self,
        part: &BatchPart,
        shared: &SharedBackward,
        id: NodeId,
        sample: usize,
    ) -> Option<GradientPlace> {
        let Compiled { plan, nodes, places, lens, .. } = shared.forward.compiled;
        let gradients = &plan.nodes[id].gradients;
        if let [slot] = gradients[..] {
            let seen = &plan.slots[slot].seen;
            if seen.norm.is_none() && seen.rectifier == Rectifier::None {
                return Some(places.places[slot]);
            }
        }
        let x = &part.values[id][sample * lens[id]..][..lens[id]];
        for (i, &slot) in gradients.iter().enumerate() {
            let seen = &plan.slots[slot].seen;
            // What a batch norm takes from the whole batch counts once, however many views it has.
            let first = !gradients[..i].iter().any(|&s| plan.slots[s].seen.norm == seen.norm);
            let gradient = seen.norm.map(|n| shared.norms[n].input(first));
            let place = places.places[slot];
            let dy = &self.slots[place.buffer][sample * place.stride..][..lens[id]];
            let dx = &mut self.collected[..lens[id]];
            let view = view(seen, shared.forward.norms);
            batch_norm::backward(nodes[id].channels, x, &view, gradient, dy, dx, i > 0);
        }
        None
    }

    #[expect(clippy::expect_used, reason = "the plan adds up sums for batch norms only")]
    fn add_sums(&mut self, part: &mut BatchPart, shared: &SharedBackward, slot: usize, sample: usize) {
        let PartContext { compiled, norms, .. } = shared.forward;
        let seen = &compiled.plan.slots[slot].seen;
        let number = seen.norm.expect("sums are those of a batch norm");
        let (channels, len) = (compiled.norms[number].channels, compiled.lens[seen.stored]);
        let x = &part.values[seen.stored][sample * len..][..len];
        let place = compiled.places.places[slot];
        let dy = &self.slots[place.buffer][sample * place.stride..][..len];
        let [plain, weighted] = &mut part.column;
        let (plain, weighted) = (&mut plain[..channels], &mut weighted[..channels]);
        plain.fill(0.0);
        weighted.fill(0.0);
        let (view, mean) = (view(seen, norms), &norms[number].mean);
        reduce::add_gradient_sums(channels, x, &view, dy, mean, plain, weighted);
        for (sum, value) in self.sums[number].iter_mut().zip(plain.iter().chain(weighted.iter())) {
            *sum += f64::from(*value);
        }
    }
}
