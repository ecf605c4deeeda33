//! One file per operation: its forward and backward pass on one sample, or on the whole batch.
//!
//! A sample's values lie as positions × channels. A layer sees its inputs through their views; a layer
//! itself holds no state that changes, so samples run in parallel.

mod activation;
mod adaptive_pool;
mod channels;
mod conv;
mod dropout;
mod linear;
mod lstm;
mod pool;
mod scale;
mod simple;
mod streams;

use taxel_graph::{Activation, DropoutMask, Graph, Node, Op, Window};
use taxel_kernels::{Buffer, View, Window3, adaptive_pool::AdaptivePool};

pub(crate) use conv::{read_tensor, write_tensor};

use crate::lifetimes::Place;
use crate::norm::Norm;
use crate::plan::{NodePlan, Seen};
use crate::threads::Threads;

/// The inputs of one node for one sample.
#[derive(Clone, Copy)]
pub(crate) struct Inputs<'a> {
    pub plan: &'a NodePlan,
    /// Stored values of all nodes before it.
    pub values: &'a [Buffer],
    pub norms: &'a [Norm],
    /// Number of the sample in its part.
    pub sample: usize,
    /// Number of the sample in the batch.
    pub number: usize,
    /// What this node drops; nothing in evaluation.
    pub mask: Option<DropoutMask>,
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
    View { affine, rectifier: seen.rectifier }
}

/// Where the gradients of one node's inputs go, for one sample.
pub(crate) struct Outputs<'a> {
    pub plan: &'a NodePlan,
    /// Memory of the slots, and where each lies.
    pub slots: &'a mut [Buffer],
    pub places: &'a [Place],
    pub sample: usize,
    pub lens: &'a [usize],
}

impl Outputs<'_> {
    /// The gradient of input `which`, and whether to add to it; `None` where nobody needs it.
    pub fn get(&mut self, which: usize) -> Option<(&mut [f32], bool)> {
        let (slot, add) = self.plan.slots[which]?;
        let len = self.lens[self.plan.inputs[which].stored];
        let Place { buffer, stride } = self.places[slot];
        Some((&mut self.slots[buffer][self.sample * stride..][..len], add))
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

    /// From the gradient `dy` of the output: adds to `sums`, which are empty where nothing is learned,
    /// and writes or adds to the inputs' gradients.
    fn backward(&self, pass: Backward, dy: &[f32], sums: &mut [f32], outputs: Outputs, scratch: &mut Scratch);

    /// Values that a sample keeps between the passes.
    fn saved_len(&self) -> usize {
        0
    }

    /// Values of [`Scratch::x`] and [`Scratch::halo`] that it needs.
    fn scratch_len(&self) -> [usize; 2];

    /// What all samples' forward passes share, from the parameters.
    fn pack(&self, _params: &[f32], _packed: &mut Vec<f32>) {}

    /// What both passes need of the values that are not learned, kept with what is packed.
    fn keep(&self, _buffers: &[f32], _packed: &mut Vec<f32>) {}

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
    /// The output.
    pub y: &'a [f32],
    pub saved: &'a [f32],
}

/// Forward and backward pass of a node on the whole batch, cut into pieces by its size alone.
pub(crate) trait BatchLayer: Send + Sync {
    /// `y` from `x`, `n` rows each; what the backward pass needs is kept.
    fn forward(&mut self, threads: &Threads, n: usize, params: &[f32], x: &[f32], y: &mut [f32]);

    /// Overwrites `dparams`, which are empty where nothing is learned, and `dx` where it is wanted.
    fn backward(&mut self, pass: BatchBackward, dparams: &mut [f32], dx: Option<&mut [f32]>);
}

/// What a backward pass over `n` rows reads.
#[derive(Clone, Copy)]
pub(crate) struct BatchBackward<'a> {
    pub threads: &'a Threads,
    pub n: usize,
    pub params: &'a [f32],
    pub x: &'a [f32],
    pub dy: &'a [f32],
}

/// A node that takes the whole batch: its rows, gathered from the parts, and their gradients.
pub(crate) struct Batch {
    pub layer: Box<dyn BatchLayer>,
    /// Values of one row.
    pub inputs: usize,
    pub outputs: usize,
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub dy: Vec<f32>,
    pub dx: Vec<f32>,
}

/// The layer of `node` over the whole of a batch of at most `batch`; `None` for what runs sample by sample.
pub(crate) fn build_batch(graph: &Graph, node: &Node, batch: usize) -> Option<Batch> {
    let input = &graph.nodes()[*node.inputs.first()?].shape;
    let (inputs, outputs) = (input.iter().product(), node.shape[0]);
    let layer: Box<dyn BatchLayer> = match node.op {
        Op::Linear { bias, .. } => Box::new(linear::Linear::new(inputs, outputs, bias, batch)),
        Op::Lstm { hidden, steps } => {
            let sizes = taxel_kernels::lstm::Lstm { channels: input[0], steps, hidden };
            Box::new(lstm::Lstm::new(sizes, batch))
        }
        _ => return None,
    };
    let rows = |len: usize| vec![0.0; batch * len];
    Some(Batch {
        layer,
        inputs,
        outputs,
        x: rows(inputs),
        y: rows(outputs),
        dy: rows(outputs),
        dx: rows(inputs),
    })
}

/// The layer of `node`; `None` for inputs and for what takes the whole batch.
pub(crate) fn build(graph: &Graph, node: &Node) -> Option<Box<dyn Layer>> {
    let input = |which: usize| &graph.nodes()[node.inputs[which]];
    let (channels, len) = (node.shape[0], node.shape.iter().product());
    Some(match &node.op {
        Op::Input | Op::Linear { .. } | Op::Lstm { .. } => return None,
        Op::Conv { window, groups, bias, .. } => {
            let window = window3(window, &input(0).shape);
            Box::new(conv::Conv::new(window, input(0).shape[0], node.shape[0], *groups, *bias))
        }
        // Stored only where the engine cannot leave them to their readers.
        Op::BatchNorm { .. } | Op::Relu | Op::Activation(Activation::Relu6) => {
            Box::new(simple::Copy { channels })
        }
        &Op::Activation(function) => Box::new(activation::Activation { function, channels, len }),
        &Op::Dropout { probability } => {
            Box::new(dropout::Dropout { probability, channels, positions: len / channels })
        }
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
        Op::AdaptiveAveragePool { output } => {
            let (input, output) = (axes3(&input(0).shape[1..], 1), axes3(output, 1));
            let pool = AdaptivePool { input, output, channels };
            Box::new(adaptive_pool::AdaptiveAveragePool { pool })
        }
        Op::Scale => Box::new(scale::Scale { channels, len }),
        Op::Standardize { .. } => Box::new(streams::Standardize { channels, len }),
        Op::SwitchScale => {
            let stream = &input(1).shape;
            Box::new(streams::SwitchScale { channels, len, stream: [stream[0], stream.iter().product()] })
        }
        &Op::ChannelShuffle { groups } => Box::new(channels::ChannelShuffle { channels, groups, len }),
        &Op::Slice { start, len: width } => {
            let channels = input(0).shape[0];
            Box::new(channels::Slice { channels, start, width, positions: len / width })
        }
    })
}

/// A window over (depth, rows, columns), from a shape with channels first and 1 to 3 spatial axes.
fn window3(window: &Window, input: &[usize]) -> Window3 {
    let spatial = &input[1..];
    let before: Vec<usize> = window.padding.iter().map(|p| p.0).collect();
    Window3 {
        input: axes3(spatial, 1),
        output: axes3(&window.positions(spatial), 1),
        kernel: axes3(&window.kernel, 1),
        stride: axes3(&window.stride, 1),
        before: axes3(&before, 0),
    }
}

/// Values of 1 to 3 spatial axes as those of three; the missing first ones are `rest`.
fn axes3(values: &[usize], rest: usize) -> [usize; 3] {
    let mut all = [rest; 3];
    all[3 - values.len()..].copy_from_slice(values);
    all
}
