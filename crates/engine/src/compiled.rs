//! The compiled graph: what runs when and what lies where. It never changes, so all who run it share it.

use std::ops::Range;

use taxel_graph::{Graph, Node, Op, Param, TensorKind};

use crate::error::{Error, Result};
use crate::head::Head;
use crate::layers::{self, Layer};
use crate::lifetimes::GradientPlaces;
use crate::norm::NormLayout;
use crate::options::{Decay, EngineOptions, Precision};
use crate::plan::{ExecutionPlan, NormPlan};
use crate::threads::Threads;

/// The most parts that a batch is cut into.
const PARTS: usize = 8;
/// The most values that the parts' own parameter gradients take together, once there are two parts.
const PARTIALS: usize = 1 << 24;

/// Multiply-accumulates of a batch up to which other threads cost more than they bring.
const SMALL: u64 = 1 << 24;

/// Who runs a node.
pub(crate) enum Runner {
    /// Nobody: the input of this number is given.
    Input(usize),
    /// Samples on their own.
    Sample(Box<dyn Layer>),
    /// The whole batch; its layer has memory and lies in the workspace.
    Batch,
}

/// Where a node finds what it needs.
pub(crate) struct NodeLayout {
    pub job: Runner,
    /// Channels and positions of the output.
    pub channels: usize,
    pub positions: usize,
    /// Where its parameters are; frozen ones lie last.
    pub params: Range<usize>,
    /// Where its running statistics, or other values that are not learned, are.
    pub buffers: Range<usize>,
    /// Where the parts add up what its parameters' gradients are made of; empty where there is no such thing.
    pub partials: Range<usize>,
}

impl NodeLayout {
    /// Returns the layer of a node that samples run on their own.
    pub fn layer(&self) -> Option<&dyn Layer> {
        match &self.job {
            Runner::Sample(layer) => Some(layer.as_ref()),
            Runner::Input(_) | Runner::Batch => None,
        }
    }
}

/// Numbers of values.
#[derive(Debug, Default)]
pub(crate) struct ValueCounts {
    /// Parameters that are not frozen; they come first.
    pub learned: usize,
    /// All parameters.
    pub params: usize,
    /// Running statistics and other values that are not learned.
    pub buffers: usize,
    /// Length of the sums that the gradients of the parameters are made of, for one part.
    pub partials: usize,
}

/// A graph laid out for a largest batch.
pub(crate) struct Compiled {
    pub graph: Graph,
    /// Largest number of samples.
    pub batch: usize,
    /// Whether products are of bf16.
    pub half: bool,
    pub threads: Threads,
    pub plan: ExecutionPlan,
    pub nodes: Vec<NodeLayout>,
    pub norms: Vec<NormLayout>,
    /// Where the gradient of every slot lies in a part's memory.
    pub places: GradientPlaces,
    /// Values per sample of every node.
    pub lens: Vec<usize>,
    pub heads: Vec<Head>,
    /// Samples of one part at most.
    pub capacity: usize,
    pub sizes: ValueCounts,
    /// Learned parameters that do not decay, ascending.
    pub spared: Vec<Range<usize>>,
}

impl Compiled {
    /// Lays `graph` out.
    ///
    /// # Errors
    /// An empty batch, frozen names that no node with tensors has, a precision that the processor does not have, or
    /// threads that cannot be started.
    pub fn new(graph: &Graph, options: &EngineOptions) -> Result<Self> {
        let batch = options.batch;
        if batch == 0 {
            let reason = "a batch must hold at least one sample".into();
            return Err(Error::Batch { model: graph.name().into(), reason });
        }
        let frozen = graph.covered(&options.frozen)?;
        let plan = ExecutionPlan::new(graph, &frozen, options.frozen_statistics);
        let is_small = graph.cost().macs * batch as u64 <= SMALL;
        let threads = Threads::new(options.threads, is_small)?;
        crate::supports(options.precision)?;
        let half = options.precision == Precision::Bf16;
        let (nodes, sizes) = lay_out(graph, &frozen, half);
        let most_parts = (PARTIALS / usize::max(sizes.partials, 1)).clamp(2, PARTS).min(batch);
        let capacity = batch.div_ceil(most_parts);
        let mut compiled = Compiled {
            graph: graph.clone(),
            batch,
            half,
            threads,
            norms: plan.norms.iter().map(|norm| norm_layout(norm, &nodes[norm.node])).collect(),
            places: GradientPlaces::new(&plan, capacity),
            lens: graph.nodes().iter().map(|node| node.shape.iter().product()).collect(),
            heads: Head::all(graph, &plan),
            plan,
            nodes,
            capacity,
            sizes,
            spared: vec![],
        };
        if options.decay == Decay::Matrices {
            let vectors = compiled.learned_tensors().filter(|(_, param, _)| param.shape.len() < 2);
            compiled.spared = vectors.map(|(_, _, range)| range).collect();
            compiled.spared.sort_by_key(|range| range.start);
        }
        Ok(compiled)
    }

    /// Counts the parts that a batch is cut into.
    pub fn parts(&self) -> usize {
        self.batch.div_ceil(self.capacity)
    }

    /// Checks whether a node's parameters get gradients.
    pub fn learns(&self, id: usize) -> bool {
        self.nodes[id].params.end <= self.sizes.learned
    }

    /// Returns every tensor of the graph, and where it lies among the parameters or, as its kind says, the buffers.
    pub fn tensors(&self) -> impl Iterator<Item = (&Node, &Param, Range<usize>)> {
        self.graph.nodes().iter().zip(&self.nodes).flat_map(|(node, layout)| {
            let (mut params, mut buffers) = (layout.params.start, layout.buffers.start);
            node.params.iter().map(move |param| match param.kind {
                TensorKind::Parameter => (node, param, take(&mut params, param.len())),
                TensorKind::Buffer => (node, param, take(&mut buffers, param.len())),
            })
        })
    }

    /// Returns the tensors that have gradients.
    pub fn learned_tensors(&self) -> impl Iterator<Item = (&Node, &Param, Range<usize>)> {
        self.tensors().filter(|(_, param, range)| {
            param.kind == TensorKind::Parameter && range.end <= self.sizes.learned
        })
    }

    /// Checks whether `inputs` are those of `n` samples.
    pub fn check_inputs(&self, inputs: &[&[f32]], n: usize) -> Result<()> {
        let refuse = |reason: String| Err(Error::Batch { model: self.graph.name().into(), reason });
        if n == 0 || n > self.batch {
            return refuse(format!("a batch of {n} samples; compiled for 1 to {}", self.batch));
        }
        let expected = self.graph.inputs().len();
        if inputs.len() != expected {
            return refuse(format!("{} inputs given, {expected} expected", inputs.len()));
        }
        for (node, x) in self.graph.inputs().zip(inputs) {
            let len = node.shape.iter().product::<usize>();
            if x.len() != n * len {
                return refuse(format!(
                    "input `{}` holds {} values; {n} samples of {} have {}",
                    node.name,
                    x.len(),
                    taxel_graph::describe(&node.shape),
                    n * len
                ));
            }
        }
        Ok(())
    }
}

/// Takes the next `len` places after `end`.
fn take(end: &mut usize, len: usize) -> Range<usize> {
    let start = *end;
    *end += len;
    start..*end
}

/// Builds the layers of all nodes, and lays out places for what they need.
fn lay_out(graph: &Graph, frozen: &[bool], half: bool) -> (Vec<NodeLayout>, ValueCounts) {
    let count = |node: &Node, kind| node.params.iter().filter(|p| p.kind == kind).map(|p| p.len()).sum();
    let (mut sizes, mut inputs) = (ValueCounts::default(), 0);
    let mut nodes: Vec<NodeLayout> = vec![];
    for node in graph.nodes() {
        let job = match (&node.op, layers::build(graph, node, half)) {
            (Op::Input, _) => Runner::Input(take(&mut inputs, 1).start),
            (_, Some(layer)) => Runner::Sample(layer),
            (_, None) => Runner::Batch,
        };
        nodes.push(NodeLayout {
            job,
            channels: node.shape[0],
            positions: node.shape[1..].iter().product(),
            params: 0..0,
            buffers: take(&mut sizes.buffers, count(node, TensorKind::Buffer)),
            partials: 0..0,
        });
    }
    // Frozen parameters last: they have no gradient, and no optimiser meets them.
    for (id, node) in graph.nodes().iter().enumerate().filter(|(id, _)| !frozen[*id]) {
        let len = count(node, TensorKind::Parameter);
        nodes[id].params = take(&mut sizes.params, len);
        // Batch norms have sums of their own, and what takes the whole batch needs none.
        if let Some(layer) = nodes[id].layer().filter(|_| !matches!(node.op, Op::BatchNorm { .. })) {
            let len = layer.partials_len(len);
            nodes[id].partials = take(&mut sizes.partials, len);
        }
    }
    sizes.learned = sizes.params;
    for (id, node) in graph.nodes().iter().enumerate().filter(|(id, _)| frozen[*id]) {
        nodes[id].params = take(&mut sizes.params, count(node, TensorKind::Parameter));
    }
    (nodes, sizes)
}

fn norm_layout(norm: &NormPlan, node: &NodeLayout) -> NormLayout {
    NormLayout {
        channels: node.channels,
        positions: node.positions,
        eps: f64::from(norm.eps),
        momentum: f64::from(norm.momentum),
        keeps: norm.keeps,
        params: node.params.clone(),
        buffers: node.buffers.clone(),
    }
}
