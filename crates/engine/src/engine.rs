//! The compiled graph: layers, buffers and the order of both passes.

use std::ops::Range;

use taxel_graph::{Graph, Kind, NodeId, Op, Tensor, Weights};
use taxel_kernels::{layout, loss, optim};

use crate::error::{Error, Result};
use crate::layers::{self, Layer, Pass};
use crate::threads::Threads;

/// How a graph is compiled.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Largest number of samples of one batch.
    pub batch: usize,
    /// Worker threads; 1 runs in the calling thread. Results do not depend on it.
    pub threads: usize,
}

/// Which statistics batch norm uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Running statistics; nothing is changed.
    Eval,
    /// Batch statistics; running ones are moved, and what the backward pass needs is kept.
    Train,
}

/// Stochastic gradient descent with momentum, as `torch.optim.SGD` defines it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sgdm {
    /// Learning rate.
    pub lr: f32,
    /// Share of the last step that is kept.
    pub momentum: f32,
    /// Coupled L2 penalty, added to the gradient of every parameter.
    pub weight_decay: f32,
}

/// A graph ready to train and to answer.
pub struct Engine {
    graph: Graph,
    batch: usize,
    threads: Threads,
    steps: Vec<Step>,
    /// Outputs of all nodes, channels last.
    values: Vec<Vec<f32>>,
    /// Their gradients; empty where no parameter needs them.
    gradients: Vec<Vec<f32>>,
    params: Vec<f32>,
    dparams: Vec<f32>,
    velocity: Vec<f32>,
    buffers: Vec<f32>,
    /// Size of the last batch if it ran in training mode.
    trained: Option<usize>,
}

struct Step {
    layer: Option<Box<dyn Layer>>,
    params: Range<usize>,
    buffers: Range<usize>,
    /// Values of one sample.
    len: usize,
    /// Per input: whether its gradient is wanted, and whether it is added to one already there.
    backward: Vec<Option<bool>>,
}

impl Engine {
    /// Compiles `graph` with `weights`.
    ///
    /// # Errors
    /// Weights that do not fit the graph, an empty batch, or threads that cannot be started.
    pub fn new(graph: &Graph, weights: &Weights, options: Options) -> Result<Self> {
        let refuse = |reason: &str| Error::Batch { model: graph.name().into(), reason: reason.into() };
        if options.batch == 0 {
            return Err(refuse("a batch must hold at least one sample"));
        }
        let [(_, output)] = graph.outputs() else {
            return Err(refuse("training needs exactly one output"));
        };
        if graph.nodes()[*output].shape.len() != 1 {
            return Err(refuse("the output must be features (logits)"));
        }
        let backward = plan_backward(graph, *output);
        let mut steps = Vec::with_capacity(graph.nodes().len());
        let (mut params, mut buffers) = (0, 0);
        for (node, backward) in graph.nodes().iter().zip(backward) {
            let count = |kind| node.params.iter().filter(|p| p.kind == kind).map(|p| p.len()).sum::<usize>();
            let (first_param, first_buffer) = (params, buffers);
            params += count(Kind::Parameter);
            buffers += count(Kind::Buffer);
            steps.push(Step {
                layer: layers::build(graph, node, options.batch),
                params: first_param..params,
                buffers: first_buffer..buffers,
                len: node.shape.iter().product(),
                backward,
            });
        }
        let values = steps.iter().map(|s| vec![0.0; s.len * options.batch]).collect();
        let mut wanted: Vec<bool> = vec![false; steps.len()];
        for (node, step) in graph.nodes().iter().zip(&steps) {
            for (&input, gradient) in node.inputs.iter().zip(&step.backward) {
                wanted[input] |= gradient.is_some();
            }
        }
        wanted[*output] = true;
        let gradients = steps
            .iter()
            .zip(wanted)
            .map(|(s, w)| vec![0.0; if w { s.len * options.batch } else { 0 }])
            .collect();
        let mut engine = Engine {
            graph: graph.clone(),
            batch: options.batch,
            threads: Threads::new(options.threads)?,
            steps,
            values,
            gradients,
            params: vec![0.0; params],
            dparams: vec![0.0; params],
            velocity: vec![0.0; params],
            buffers: vec![0.0; buffers],
            trained: None,
        };
        engine.set_weights(weights)?;
        Ok(engine)
    }

    /// The network that was compiled.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Replaces all parameters and running statistics; momentum starts anew.
    ///
    /// # Errors
    /// Missing, extra or misshaped tensors, by name; nothing is replaced then.
    pub fn set_weights(&mut self, weights: &Weights) -> Result<()> {
        weights.check(&self.graph)?;
        for (node, step) in self.graph.nodes().iter().zip(&self.steps) {
            let (mut param_at, mut buffer_at) = (step.params.start, step.buffers.start);
            for param in &node.params {
                let Some(tensor) = weights.get(&param.name) else { continue };
                let (arena, at) = match param.kind {
                    Kind::Parameter => (&mut self.params, &mut param_at),
                    Kind::Buffer => (&mut self.buffers, &mut buffer_at),
                };
                layers::read_tensor(node, param, &tensor.data, &mut arena[*at..*at + param.len()]);
                *at += param.len();
            }
        }
        self.velocity.fill(0.0);
        self.trained = None;
        Ok(())
    }

    /// All parameters and running statistics, PyTorch's names and axis order.
    pub fn weights(&self) -> Weights {
        self.export(&self.params, true)
    }

    /// Gradients of the last [`Engine::backward`], by parameter name.
    pub fn gradients(&self) -> Weights {
        self.export(&self.dparams, false)
    }

    /// The optimiser's momentum, by parameter name.
    pub fn velocity(&self) -> Weights {
        self.export(&self.velocity, false)
    }

    fn export(&self, arena: &[f32], with_buffers: bool) -> Weights {
        let mut weights = Weights::new();
        for (node, step) in self.graph.nodes().iter().zip(&self.steps) {
            let (mut param_at, mut buffer_at) = (step.params.start, step.buffers.start);
            for param in &node.params {
                let (arena, at) = match param.kind {
                    Kind::Parameter => (arena, &mut param_at),
                    Kind::Buffer if with_buffers => (self.buffers.as_slice(), &mut buffer_at),
                    Kind::Buffer => continue,
                };
                let data = layers::write_tensor(node, param, &arena[*at..*at + param.len()]);
                *at += param.len();
                weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
            }
        }
        weights
    }

    /// Logits [n, classes] of a batch.
    ///
    /// `inputs` are the graph's inputs in order, each [n, …] in PyTorch's axis order, row-major.
    ///
    /// # Errors
    /// An empty or too large batch, or inputs of another length than `n` samples have.
    pub fn forward(&mut self, inputs: &[&[f32]], n: usize, mode: Mode) -> Result<&[f32]> {
        self.trained = None;
        self.fill_inputs(inputs, n)?;
        let pass = Pass { n, mode, threads: &self.threads };
        for (id, step) in self.steps.iter_mut().enumerate() {
            let Some(layer) = &mut step.layer else { continue };
            let (before, rest) = self.values.split_at_mut(id);
            let node = &self.graph.nodes()[id];
            let xs = inputs_of(node.inputs.as_slice(), before, n, &self.graph);
            let y = &mut rest[0][..n * step.len];
            layer.forward(
                &pass,
                &xs,
                &self.params[step.params.clone()],
                &mut self.buffers[step.buffers.clone()],
                y,
            );
        }
        if mode == Mode::Train {
            self.trained = Some(n);
        }
        let output = self.output();
        Ok(&self.values[output][..n * self.steps[output].len])
    }

    /// Mean softmax cross-entropy of the last training pass, and the gradients of all parameters.
    ///
    /// # Errors
    /// No training pass before it, or labels that are not one class number per sample.
    pub fn backward(&mut self, labels: &[u32]) -> Result<f32> {
        let output = self.output();
        let classes = self.steps[output].len;
        let model = self.graph.name().to_string();
        let refuse = |reason: String| Error::Batch { model: model.clone(), reason };
        let n =
            self.trained.take().ok_or_else(|| refuse("backward needs a forward pass in training".into()))?;
        if labels.len() != n {
            return Err(refuse(format!("{} labels for a batch of {n} samples", labels.len())));
        }
        if let Some(i) = labels.iter().position(|&l| l as usize >= classes) {
            return Err(refuse(format!("label {} of sample {i} is not one of {classes} classes", labels[i])));
        }
        let logits = &self.values[output][..n * classes];
        let gradient = &mut self.gradients[output][..n * classes];
        let loss = loss::softmax_cross_entropy(logits, classes, labels, gradient);
        let pass = Pass { n, mode: Mode::Train, threads: &self.threads };
        for (id, step) in self.steps.iter_mut().enumerate().rev() {
            let Some(layer) = &mut step.layer else { continue };
            let node = &self.graph.nodes()[id];
            let (before, rest) = self.gradients.split_at_mut(id);
            if rest[0].is_empty() {
                continue;
            }
            let dy = &rest[0][..n * step.len];
            let y = &self.values[id][..n * step.len];
            let xs = inputs_of(&node.inputs, &self.values, n, &self.graph);
            let params = &self.params[step.params.clone()];
            layer.backward_params(&pass, &xs, dy, params, &mut self.dparams[step.params.clone()]);
            for (which, (&input, wanted)) in node.inputs.iter().zip(&step.backward).enumerate() {
                let Some(accumulate) = *wanted else { continue };
                let dx = &mut before[input][..xs[which].len()];
                layer.backward_input(&pass, which, &xs, y, dy, params, dx, accumulate);
            }
        }
        Ok(loss)
    }

    /// One optimiser step with the gradients of the last [`Engine::backward`].
    pub fn sgdm(&mut self, step: &Sgdm) {
        let Sgdm { lr, momentum, weight_decay } = *step;
        optim::sgdm(&mut self.params, &self.dparams, &mut self.velocity, lr, momentum, weight_decay);
    }

    /// From now on, training passes gather batch-norm statistics over everything they see.
    pub fn begin_population(&mut self) {
        for step in &mut self.steps {
            if let Some(norm) = step.layer.as_mut().and_then(|l| l.batch_norm()) {
                norm.begin_population();
            }
        }
    }

    /// Running statistics become mean and variance over all training passes since
    /// [`Engine::begin_population`]; without such a pass they stay.
    pub fn end_population(&mut self) {
        for step in &mut self.steps {
            if let Some(norm) = step.layer.as_mut().and_then(|l| l.batch_norm()) {
                norm.end_population(&mut self.buffers[step.buffers.clone()]);
            }
        }
    }

    fn output(&self) -> NodeId {
        self.graph.outputs()[0].1
    }

    fn fill_inputs(&mut self, inputs: &[&[f32]], n: usize) -> Result<()> {
        let model = self.graph.name().to_string();
        let refuse = |reason: String| Error::Batch { model: model.clone(), reason };
        if n == 0 || n > self.batch {
            return Err(refuse(format!("a batch of {n} samples; compiled for 1 to {}", self.batch)));
        }
        let expected = self.graph.inputs().len();
        if inputs.len() != expected {
            return Err(refuse(format!("{} inputs given, {expected} expected", inputs.len())));
        }
        let ids = (0..self.graph.nodes().len()).filter(|&id| self.graph.nodes()[id].op == Op::Input);
        for (id, x) in ids.zip(inputs) {
            let node = &self.graph.nodes()[id];
            let len = self.steps[id].len;
            if x.len() != n * len {
                return Err(refuse(format!(
                    "input `{}` holds {} values; {n} samples of {} have {}",
                    node.name,
                    x.len(),
                    taxel_graph::describe(&node.shape),
                    n * len
                )));
            }
            let (channels, positions) = (node.shape[0], node.shape[1..].iter().product());
            self.threads.each(&mut self.values[id][..n * len], len, |i, y| {
                layout::transpose(channels, positions, &x[i * len..][..len], y, false);
            });
        }
        Ok(())
    }
}

fn inputs_of<'a>(inputs: &[NodeId], values: &'a [Vec<f32>], n: usize, graph: &Graph) -> Vec<&'a [f32]> {
    inputs.iter().map(|&i| &values[i][..n * graph.nodes()[i].shape.iter().product::<usize>()]).collect()
}

/// Per node and input: `None` where no gradient is needed, else whether it adds to an earlier one.
///
/// A gradient is needed where parameters lie before it, on the way to the output.
fn plan_backward(graph: &Graph, output: NodeId) -> Vec<Vec<Option<bool>>> {
    let nodes = graph.nodes();
    let mut trains = vec![false; nodes.len()];
    for (id, node) in nodes.iter().enumerate() {
        let own = node.params.iter().any(|p| p.kind == Kind::Parameter);
        trains[id] = own || node.inputs.iter().any(|&i| trains[i]);
    }
    let mut written = vec![false; nodes.len()];
    written[output] = true;
    let mut plan = vec![vec![]; nodes.len()];
    for (id, node) in nodes.iter().enumerate().rev() {
        plan[id] = node
            .inputs
            .iter()
            .map(|&input| {
                let wanted = written[id] && trains[input];
                wanted.then(|| std::mem::replace(&mut written[input], true))
            })
            .collect();
    }
    plan
}
