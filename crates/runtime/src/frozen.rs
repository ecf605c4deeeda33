//! A network for prediction only, and the memory of one thread that runs it.

use std::sync::Arc;

use taxel_graph::{Graph, Weights, describe};
use taxel_kernels::frozen::ImagePlace;
use taxel_kernels::{Buffer, half};

use crate::error::{Error, Result};
use crate::lower::{Purpose, lower};
use crate::memory::ProgramBuffer;
use crate::pair::pair;
use crate::places::{Room, ValuePlaces};
use crate::program::{Call, CallInputs, Scratch, ScratchLens, program};
use crate::quantize::quantize;
use crate::ranges::Ranges;
use crate::step::{FrozenStep, StepId};

/// Bytes of weights and values up to which a prediction stays in the cache that a core has to itself.
const CACHE: usize = 512 << 10;
/// Samples that share what is read of larger weights.
const TOGETHER: usize = 8;

/// A network frozen for prediction; see the crate's page.
pub struct Frozen {
    shared: Arc<FrozenNetwork>,
}

/// The parts that all workspaces read.
struct FrozenNetwork {
    name: String,
    /// Shapes of the inputs, without the batch axis.
    inputs: Vec<(String, Vec<usize>)>,
    calls: Vec<Call>,
    outputs: Vec<OutputPlace>,
    buffers: Vec<Room>,
    scratch: ScratchLens,
    /// Samples that are best predicted together.
    together: usize,
}

/// Where an output's features are found.
struct OutputPlace {
    name: String,
    buffer: usize,
    place: ImagePlace,
}

/// Memory of one thread that predicts with a [`Frozen`] network, which makes it: all values, allocated once.
pub struct Workspace {
    shared: Arc<FrozenNetwork>,
    /// Of every sample that is predicted at a time.
    samples: Vec<Vec<ProgramBuffer>>,
    scratch: Scratch,
}

impl Frozen {
    /// Freezes `graph` with `weights`.
    ///
    /// # Errors
    /// Weights that do not fit the graph.
    pub fn new(graph: &Graph, weights: &Weights) -> Result<Self> {
        Self::paired(graph, weights, Purpose::Floats)
    }

    /// Freezes `graph` with products of bf16: convolutions and linear layers round both factors to it and sum in floats.
    /// Depthwise convolutions, groups of an odd number of channels, recurrent layers and all other operations stay in floats.
    ///
    /// # Errors
    /// Weights that do not fit the graph, and a processor without such products.
    pub fn half(graph: &Graph, weights: &Weights) -> Result<Self> {
        let refuse = |reason| Error::Half { model: graph.name().into(), reason };
        half::supported().map_err(refuse)?;
        Self::paired(graph, weights, Purpose::Half)
    }

    fn paired(graph: &Graph, weights: &Weights, purpose: Purpose) -> Result<Self> {
        weights.check(graph)?;
        let (steps, outputs) = lower(graph, weights, purpose);
        let (steps, now) = pair(steps, &outputs);
        let outputs: Vec<StepId> = outputs.into_iter().map(|output| now[output]).collect();
        Ok(Self::of(graph, steps, &outputs, purpose))
    }

    /// Freezes `graph` in eight bits: convolutions and linear layers multiply bytes with signed bytes, and values
    /// between them are bytes of the `ranges` that an [`Observer`](crate::Observer) has seen. What has no range stays
    /// in floats.
    ///
    /// # Errors
    /// Weights that do not fit the graph.
    pub fn quantized(graph: &Graph, weights: &Weights, ranges: &Ranges) -> Result<Self> {
        weights.check(graph)?;
        let (steps, outputs) = lower(graph, weights, Purpose::Bytes);
        let (steps, outputs) = quantize(steps, &outputs, ranges);
        Ok(Self::of(graph, steps, &outputs, Purpose::Bytes))
    }

    /// Freezes `graph` in floats, by the steps that [`Frozen::quantized`] takes.
    pub(crate) fn observed(graph: &Graph, weights: &Weights) -> Result<Self> {
        weights.check(graph)?;
        let (steps, outputs) = lower(graph, weights, Purpose::Bytes);
        Ok(Self::of(graph, steps, &outputs, Purpose::Floats))
    }

    fn of(graph: &Graph, steps: Vec<FrozenStep>, outputs: &[StepId], purpose: Purpose) -> Self {
        let places = ValuePlaces::new(&steps, outputs);
        let names = graph.outputs().iter().map(|(name, _)| name.clone());
        let outputs = outputs.iter().zip(names).map(|(&step, name)| {
            let (place, buffer) = places.values[step];
            OutputPlace { name, buffer, place }
        });
        let outputs = outputs.collect();
        let (calls, scratch) = program(steps, &places, purpose);
        let inputs = graph.inputs().map(|node| (node.name.clone(), node.shape.clone())).collect();
        let name = graph.name().to_string();
        let buffers = places.buffers;
        let values: usize = buffers.iter().map(|room| room.len).sum();
        let bytes = size_of::<f32>() * (graph.parameter_count() + values);
        let together = if bytes > CACHE { TOGETHER } else { 1 };
        Frozen {
            shared: Arc::new(FrozenNetwork { name, inputs, calls, outputs, buffers, scratch, together }),
        }
    }

    /// Makes the memory for one thread that predicts one sample at a time.
    pub fn workspace(&self) -> Workspace {
        self.workspace_for(1)
    }

    /// Makes the memory for one thread that predicts up to `batch` samples at a time: of large weights several
    /// samples share what is read.
    pub fn workspace_for(&self, batch: usize) -> Workspace {
        let ScratchLens { input, output, work } = self.shared.scratch;
        let zeros = Buffer::zeros;
        let one = |_| self.shared.buffers.iter().map(ProgramBuffer::new).collect();
        Workspace {
            samples: (0..self.shared.together.min(batch).max(1)).map(one).collect(),
            scratch: Scratch { input: zeros(input), output: zeros(output), work: zeros(work) },
            shared: Arc::clone(&self.shared),
        }
    }

    /// Predicts as [`Frozen::predict`] and tells `see` of every node whose value is computed: its name, place and
    /// memory.
    pub(crate) fn show(
        &self,
        workspace: &mut Workspace,
        inputs: &[&[f32]],
        mut see: impl FnMut(&str, &ImagePlace, &ProgramBuffer),
    ) -> Result<()> {
        self.check(workspace, inputs, 1)?;
        let Workspace { shared, samples, scratch } = workspace;
        for call in &shared.calls {
            call.run(CallInputs { inputs, sample: 0, part: None }, &mut samples[0], scratch);
            let (buffer, place) = &call.to;
            see(&call.name, place, &samples[0][*buffer]);
        }
        Ok(())
    }

    /// Returns the number of values of the first output.
    pub fn logits(&self) -> usize {
        self.shared.outputs[0].place.channels
    }

    /// Returns the logits (one per class) of one sample: the first output; [`Workspace::outputs`] gives all.
    ///
    /// `inputs` are the graph's inputs in order, each in PyTorch's axis order, row-major.
    ///
    /// # Errors
    /// A workspace of another network, or inputs of another number or length.
    pub fn predict<'w>(&self, workspace: &'w mut Workspace, inputs: &[&[f32]]) -> Result<&'w [f32]> {
        self.check(workspace, inputs, 1)?;
        workspace.run(inputs, 0, 1);
        Ok(workspace.output(0, &self.shared.outputs[0]))
    }

    /// Applies [`Frozen::predict`] to samples one after the other: `inputs` are [n, …], `logits` [n,
    /// [`Frozen::logits`]]. A prediction does not depend on its neighbours.
    ///
    /// # Errors
    /// As [`Frozen::predict`], or logits that are no whole samples.
    pub fn predict_many(
        &self,
        workspace: &mut Workspace,
        inputs: &[&[f32]],
        logits: &mut [f32],
    ) -> Result<()> {
        let width = self.logits();
        let n = logits.len() / width;
        if n * width != logits.len() {
            let reason = format!("room for {} logits is no multiple of {width}", logits.len());
            return Err(Error::Input { model: self.shared.name.clone(), reason });
        }
        self.check(workspace, inputs, n)?;
        let most = workspace.samples.len();
        for (group, logits) in logits.chunks_mut(most * width).enumerate() {
            workspace.run(inputs, group * most, logits.len() / width);
            for (sample, logits) in logits.chunks_exact_mut(width).enumerate() {
                logits.copy_from_slice(workspace.output(sample, &self.shared.outputs[0]));
            }
        }
        Ok(())
    }

    /// Refuses a workspace of another network, and inputs that are not those of `n` samples.
    fn check(&self, workspace: &Workspace, inputs: &[&[f32]], n: usize) -> Result<()> {
        let FrozenNetwork { name: model, inputs: expected, .. } = &*self.shared;
        if !Arc::ptr_eq(&self.shared, &workspace.shared) {
            return Err(Error::Workspace { model: model.clone() });
        }
        let refuse = |reason| Err(Error::Input { model: model.clone(), reason });
        if inputs.len() != expected.len() {
            return refuse(format!("{} inputs given, {} expected", inputs.len(), expected.len()));
        }
        for ((name, shape), x) in expected.iter().zip(inputs) {
            if x.len() != n * shape.iter().product::<usize>() {
                let (given, shape) = (x.len(), describe(shape));
                let each = if n == 1 { String::new() } else { format!(" for each of {n} samples") };
                return refuse(format!("input `{name}` holds {given} values; {shape} are needed{each}"));
            }
        }
        Ok(())
    }
}

impl Workspace {
    /// Predicts `count` samples from number `first` on: all go through one call, then through the next.
    fn run(&mut self, inputs: &[&[f32]], first: usize, count: usize) {
        let Workspace { shared, samples, scratch } = self;
        for call in &shared.calls {
            for part in 0..call.parts(count) {
                for (sample, buffers) in samples[..count].iter_mut().enumerate() {
                    let given =
                        CallInputs { inputs, sample: first + sample, part: (count > 1).then_some(part) };
                    call.run(given, buffers, scratch);
                }
            }
        }
    }

    fn output(&self, sample: usize, output: &OutputPlace) -> &[f32] {
        &self.samples[sample][output.buffer].floats()[output.place.start..][..output.place.channels]
    }

    /// Returns names and values of all outputs of the last prediction, in the graph's order, PyTorch's axis order.
    pub fn outputs(&self) -> impl Iterator<Item = (&str, &[f32])> {
        self.shared.outputs.iter().map(|output| (output.name.as_str(), self.output(0, output)))
    }
}
