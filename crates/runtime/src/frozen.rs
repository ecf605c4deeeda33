//! A network that only answers, and the memory of one who asks it.

use std::mem;
use std::sync::Arc;

use taxel_graph::{Graph, Weights, describe};
use taxel_kernels::Buffer;
use taxel_kernels::frozen::Place;

use crate::error::{Error, Result};
use crate::lower::lower;
use crate::places::Places;
use crate::program::{Call, Scratch, ScratchLens, program};

/// A network frozen for answering; see the crate's page.
pub struct Frozen {
    shared: Arc<Shared>,
}

/// What all workspaces read.
struct Shared {
    name: String,
    /// Shapes of the inputs, without the batch axis.
    inputs: Vec<(String, Vec<usize>)>,
    calls: Vec<Call>,
    outputs: Vec<Output>,
    buffers: Vec<usize>,
    scratch: ScratchLens,
}

/// Where an output's features are found.
struct Output {
    name: String,
    buffer: usize,
    place: Place,
}

/// What one thread needs to ask a [`Frozen`] network, which makes it: memory for all values, allocated once.
pub struct Workspace {
    shared: Arc<Shared>,
    buffers: Vec<Buffer>,
    scratch: Scratch,
}

impl Frozen {
    /// Freezes `graph` with `weights`.
    ///
    /// # Errors
    /// Weights that do not fit the graph.
    pub fn new(graph: &Graph, weights: &Weights) -> Result<Self> {
        weights.check(graph)?;
        let (steps, outputs) = lower(graph, weights);
        let places = Places::new(&steps, &outputs);
        let names = graph.outputs().iter().map(|(name, _)| name.clone());
        let outputs = outputs.iter().zip(names).map(|(&step, name)| {
            let (place, buffer) = places.values[step];
            Output { name, buffer, place }
        });
        let outputs = outputs.collect();
        let (calls, scratch) = program(steps, &places);
        let inputs = graph.inputs().map(|node| (node.name.clone(), node.shape.clone())).collect();
        let name = graph.name().to_string();
        Ok(Frozen {
            shared: Arc::new(Shared { name, inputs, calls, outputs, buffers: places.buffers, scratch }),
        })
    }

    /// Memory for one thread.
    pub fn workspace(&self) -> Workspace {
        let ScratchLens { input, output, work } = self.shared.scratch;
        let zeros = Buffer::zeros;
        Workspace {
            buffers: self.shared.buffers.iter().map(|&len| zeros(len)).collect(),
            scratch: Scratch { input: zeros(input), output: zeros(output), work: zeros(work) },
            shared: Arc::clone(&self.shared),
        }
    }

    /// Logits (one per class) of one sample: the first output; [`Workspace::outputs`] gives all.
    ///
    /// `inputs` are the graph's inputs in order, each in PyTorch's axis order, row-major.
    ///
    /// # Errors
    /// A workspace of another network, or inputs of another number or length.
    pub fn answer<'w>(&self, workspace: &'w mut Workspace, inputs: &[&[f32]]) -> Result<&'w [f32]> {
        if !Arc::ptr_eq(&self.shared, &workspace.shared) {
            return Err(Error::Workspace { model: self.shared.name.clone() });
        }
        self.shared.check(inputs)?;
        workspace.run(inputs);
        Ok(workspace.output(&self.shared.outputs[0]))
    }
}

impl Shared {
    fn check(&self, inputs: &[&[f32]]) -> Result<()> {
        let refuse = |reason| Err(Error::Input { model: self.name.clone(), reason });
        if inputs.len() != self.inputs.len() {
            return refuse(format!("{} inputs given, {} expected", inputs.len(), self.inputs.len()));
        }
        for ((name, shape), x) in self.inputs.iter().zip(inputs) {
            if x.len() != shape.iter().product::<usize>() {
                return refuse(format!(
                    "input `{name}` holds {} values; {} are needed",
                    x.len(),
                    describe(shape)
                ));
            }
        }
        Ok(())
    }
}

impl Workspace {
    fn run(&mut self, inputs: &[&[f32]]) {
        let Workspace { shared, buffers, scratch } = self;
        for call in &shared.calls {
            let (to, _) = call.to;
            // Nothing is written where it is read, so the output's buffer can be taken out.
            let mut y = mem::take(&mut buffers[to]);
            match call.from.as_slice() {
                [] => call.run(inputs, &[], &mut y, scratch),
                [(a, _)] => call.run(inputs, &[&buffers[*a]], &mut y, scratch),
                [(a, _), (b, _), ..] => call.run(inputs, &[&buffers[*a], &buffers[*b]], &mut y, scratch),
            }
            buffers[to] = y;
        }
    }

    fn output(&self, output: &Output) -> &[f32] {
        &self.buffers[output.buffer][output.place.start..][..output.place.channels]
    }

    /// Names and values of all outputs of the last answer, in the graph's order, PyTorch's axis order.
    pub fn outputs(&self) -> impl Iterator<Item = (&str, &[f32])> {
        self.shared.outputs.iter().map(|output| (output.name.as_str(), self.output(output)))
    }
}
