//! One file per operation: its forward and backward pass on one sample, or on the whole batch.
//!
//! A sample's values lie as positions × channels. A layer sees its inputs through their views; a layer
//! itself holds no state that changes, so samples run in parallel.

mod conv;
mod linear;
mod pool;
mod simple;

use taxel_graph::{Graph, Node, Op, Window};
use taxel_kernels::{Buffer, View, Window3};

pub(crate) use conv::{read_tensor, write_tensor};
pub(crate) use linear::{BatchState, Linear};

use crate::norm::Norm;
use crate::plan::{NodePlan, Seen};

/// The inputs of one node for one sample.
#[derive(Clone, Copy)]
pub(crate) struct Inputs<'a> {
    pub plan: &'a NodePlan,
    /// Stored values of all nodes before it.
    pub values: &'a [Buffer],
    pub norms: &'a [Norm],
    /// Number of the sample in its part.
    pub sample: usize,
    /// Values per sample of every node.
    pub lens: &'a [usize],
    /// What [`Layer::pack`] made of the parameters.
    pub packed: &'a [f32],
}

impl<'a> Inputs<'a> {
    /// Stored values of input `which`, and how this node sees them.
    pub fn get(&self, which: usize) -> (&'a [f32], View<'a>) {
        let seen = &self.plan.inputs[which];
        let len = self.lens[seen.stored];
        (&self.values[seen.stored][self.sample * len..][..len], view(seen, self.norms))
    }

    pub fn count(&self) -> usize {
        self.plan.inputs.len()
    }
}

/// The view that `seen` stands for.
pub(crate) fn view<'a>(seen: &Seen, norms: &'a [Norm]) -> View<'a> {
    let affine = seen.norm.map(|n| (norms[n].scale.as_slice(), norms[n].shift.as_slice()));
    View { affine, relu: seen.relu }
}

/// Where the gradients of one node's inputs go, for one sample.
pub(crate) struct Outputs<'a> {
    pub plan: &'a NodePlan,
    pub slots: &'a mut [Buffer],
    pub sample: usize,
    pub lens: &'a [usize],
}

impl Outputs<'_> {
    /// The gradient of input `which`, and whether to add to it; `None` where nobody needs it.
    pub fn get(&mut self, which: usize) -> Option<(&mut [f32], bool)> {
        let (slot, add) = self.plan.slots[which]?;
        let len = self.lens[self.plan.inputs[which].stored];
        Some((&mut self.slots[slot][self.sample * len..][..len], add))
    }
}

/// Memory of one worker that no sample keeps.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// An input with its halo, or seen through its view.
    pub x: Buffer,
    /// A gradient with its halo.
    pub halo: Buffer,
}

/// Forward and backward pass of a node on one sample.
pub(crate) trait Layer: Send + Sync {
    /// `y` from the inputs; `saved` is kept for the backward pass.
    fn forward(
        &self,
        inputs: Inputs,
        params: &[f32],
        y: &mut [f32],
        saved: &mut [f32],
        scratch: &mut Scratch,
    );

    /// From the gradient `dy` of the output: adds to `sums`, writes or adds to the inputs' gradients.
    fn backward(&self, pass: Backward, dy: &[f32], sums: &mut [f32], outputs: Outputs, scratch: &mut Scratch);

    /// Values that a sample keeps between the passes.
    fn saved_len(&self) -> usize {
        0
    }

    /// Values of [`Scratch::x`] and [`Scratch::halo`] that it needs.
    fn scratch_len(&self) -> [usize; 2];

    /// What all samples' forward passes share, from the parameters.
    fn pack(&self, _params: &[f32], _packed: &mut Vec<f32>) {}

    /// What all samples' backward passes share, from the parameters.
    fn prepare(&self, _params: &[f32], _prepared: &mut Vec<f32>) {}

    /// Values that a layer with `params` parameters adds up over samples.
    fn sums_len(&self, params: usize) -> usize {
        params
    }

    /// The parameters' gradient from those sums.
    fn finish(&self, sums: &[f32], dparams: &mut [f32]) {
        dparams.copy_from_slice(sums);
    }
}

/// What a backward pass reads.
#[derive(Clone, Copy)]
pub(crate) struct Backward<'a> {
    pub inputs: Inputs<'a>,
    pub params: &'a [f32],
    pub prepared: &'a [f32],
    pub saved: &'a [f32],
}

/// The layer of `node`; `None` for inputs, for what takes the whole batch, and for what the engine lacks.
pub(crate) fn build(graph: &Graph, node: &Node) -> Option<Box<dyn Layer>> {
    let input = |which: usize| &graph.nodes()[node.inputs[which]];
    Some(match &node.op {
        Op::Input | Op::Linear { .. } => return None,
        Op::Conv { window, groups, bias } => {
            let window = window3(window, &input(0).shape);
            Box::new(conv::Conv::new(window, input(0).shape[0], node.shape[0], *groups, *bias))
        }
        // Stored only where the engine cannot leave them to their readers.
        Op::BatchNorm { .. } | Op::Relu => Box::new(simple::Copy { channels: node.shape[0] }),
        Op::MaxPool(window) => {
            let window = window3(window, &input(0).shape);
            Box::new(pool::MaxPool(taxel_kernels::pool::MaxPool::new(&window, node.shape[0])))
        }
        Op::AveragePool { window, counted } => {
            let mut all = [(0, 0); 3];
            all[3 - counted.len()..].copy_from_slice(counted);
            let window = window3(window, &input(0).shape);
            Box::new(pool::AveragePool { window, counted: all, channels: node.shape[0] })
        }
        Op::GlobalAveragePool => {
            let len = input(0).shape.iter().product();
            Box::new(pool::GlobalAveragePool { channels: node.shape[0], len })
        }
        Op::Flatten => {
            let shape = &input(0).shape;
            Box::new(simple::Flatten { channels: shape[0], positions: shape[1..].iter().product() })
        }
        Op::Add => Box::new(simple::Add { channels: node.shape[0], len: node.shape.iter().product() }),
        Op::Concat => {
            let widths = node.inputs.iter().map(|&i| graph.nodes()[i].shape[0]).collect();
            Box::new(simple::Concat::new(widths, node.shape[1..].iter().product()))
        }
        _ => return None,
    })
}

/// A window over (depth, rows, columns), from a shape with channels first and 1 to 3 spatial axes.
fn window3(window: &Window, input: &[usize]) -> Window3 {
    let spatial = &input[1..];
    let skip = 3 - spatial.len();
    let fill = |values: &[usize], rest: usize| {
        let mut all = [rest; 3];
        all[skip..].copy_from_slice(values);
        all
    };
    let before: Vec<usize> = window.padding.iter().map(|p| p.0).collect();
    Window3 {
        input: fill(spatial, 1),
        output: fill(&window.positions(spatial), 1),
        kernel: fill(&window.kernel, 1),
        stride: fill(&window.stride, 1),
        before: fill(&before, 0),
    }
}
