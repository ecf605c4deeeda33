//! The compiled graph: parts of the batch, batch norms, parameters and both passes.

use taxel_graph::{DropoutMask, Graph, Kind, Loss, Op, Targets, Tensor, Weights};
use taxel_kernels::Buffer;
use taxel_kernels::optim::{Adam, clip_by_global_norm};

use crate::error::{Error, Result};
use crate::head::Head;
use crate::layers::{self, Batch, BatchBackward, view};
use crate::lifetimes::{Place, Places};
use crate::norm::Norm;
use crate::optimizer::{Memory, OptimizerState, Sgdm, fill_up};
use crate::part::{NodeState, Part, Shared};
use crate::plan::{Phase, Plan};
use crate::threads::Threads;

/// How a graph is compiled.
#[derive(Debug, Clone)]
pub struct Options {
    /// Largest number of samples of one batch.
    pub batch: usize,
    /// Worker threads at most; 1 runs in the calling thread, and so do batches too small to share. Results do
    /// not depend on it.
    pub threads: usize,
    /// Nodes that training leaves as they are, by name or a name's first parts (`stem` is every node `stem.…`,
    /// see [`Graph::covered`]). Their parameters get no gradient and no step, their batch norms use the running
    /// statistics and keep them (PyTorch: `requires_grad_(False)` and `eval()`).
    pub frozen: Vec<String>,
}

impl Default for Options {
    /// One sample, one thread, nothing frozen.
    fn default() -> Self {
        Options { batch: 1, threads: 1, frozen: vec![] }
    }
}

/// Which statistics batch norm uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Running statistics; nothing is changed.
    Eval,
    /// Batch statistics; running ones are moved, and what the backward pass needs is kept.
    Train,
}

/// The most parts that a batch is cut into.
const PARTS: usize = 8;
/// The most values that the parts' own parameter gradients take together, once there are two parts.
const PARTIALS: usize = 1 << 24;

/// Multiply-accumulates of a batch up to which other threads cost more than they bring.
const SMALL: u64 = 1 << 24;

/// A graph ready to train and to answer.
pub struct Engine {
    graph: Graph,
    batch: usize,
    threads: Threads,
    plan: Plan,
    nodes: Vec<NodeState>,
    /// Nodes that take the whole batch.
    batches: Vec<Option<Batch>>,
    norms: Vec<Norm>,
    /// Where the gradient of every slot lies in a part's memory.
    places: Vec<Place>,
    /// Values per sample of every node.
    lens: Vec<usize>,
    parts: Vec<Part>,
    /// Parameters, frozen ones last.
    params: Buffer,
    /// Whether the layers have packed the parameters as they are.
    packed: bool,
    /// What the parts' gradients are made of, all parts together.
    gradient_sums: Buffer,
    /// Gradients of all that are not frozen.
    dparams: Buffer,
    optimizer: Memory,
    buffers: Vec<f32>,
    heads: Vec<Head>,
    /// Size of the last batch.
    last: usize,
    /// Size of the last batch if it ran in training mode.
    trained: Option<usize>,
    /// Seed of the dropout masks, and training passes so far.
    dropout: (u64, u64),
}

/// What parts read while they run: borrows of single fields, so that the parts themselves stay free.
macro_rules! shared {
    ($engine:ident, $train:expr) => {
        Shared {
            plan: &$engine.plan,
            nodes: &$engine.nodes,
            norms: &$engine.norms,
            places: &$engine.places,
            lens: &$engine.lens,
            params: &$engine.params,
            train: $train,
        }
    };
}

impl Engine {
    /// Compiles `graph` with `weights`.
    ///
    /// # Errors
    /// Weights that do not fit the graph, an empty batch, frozen names that no node with tensors has, or
    /// threads that cannot be started.
    pub fn new(graph: &Graph, weights: &Weights, options: Options) -> Result<Self> {
        let refuse = |reason: &str| Error::Batch { model: graph.name().into(), reason: reason.into() };
        if options.batch == 0 {
            return Err(refuse("a batch must hold at least one sample"));
        }
        let frozen = graph.covered(&options.frozen)?;
        let plan = Plan::new(graph, &frozen);
        let is_small = graph.cost().macs * options.batch as u64 <= SMALL;
        let threads = Threads::new(if is_small { 1 } else { options.threads })?;
        let mut nodes: Vec<NodeState> = vec![];
        let mut batches = vec![];
        let (mut buffers, mut inputs) = (0, 0);
        for node in graph.nodes() {
            let count = |kind| node.params.iter().filter(|p| p.kind == kind).map(|p| p.len()).sum::<usize>();
            let input = (node.op == Op::Input).then_some(inputs);
            inputs += usize::from(input.is_some());
            nodes.push(NodeState {
                layer: layers::build(graph, node),
                channels: node.shape[0],
                positions: node.shape[1..].iter().product(),
                params: 0..count(Kind::Parameter),
                buffers: buffers..buffers + count(Kind::Buffer),
                sums: 0..0,
                input,
                packed: vec![],
                prepared: vec![],
                mask: None,
            });
            buffers += count(Kind::Buffer);
            batches.push(layers::build_batch(graph, node, options.batch));
        }
        // Frozen parameters last: they have no gradient, and no optimiser meets them.
        let (mut params, mut sums) = (0, 0);
        let ends = [false, true].map(|wanted| {
            for (id, node) in nodes.iter_mut().enumerate().filter(|(id, _)| frozen[*id] == wanted) {
                let len = node.params.len();
                node.params = params..params + len;
                params += len;
                // Batch norms add up their own sums, and what takes the whole batch needs none.
                let is_norm = matches!(graph.nodes()[id].op, Op::BatchNorm { .. });
                let layer = node.layer.as_ref().filter(|_| !is_norm && !wanted);
                node.sums = sums..sums + layer.map_or(0, |layer| layer.sums_len(len));
                sums = node.sums.end;
            }
            params
        });
        let [learned, params] = ends;
        let norms: Vec<Norm> = plan
            .norms
            .iter()
            .filter_map(|norm| {
                let Op::BatchNorm { eps, momentum } = graph.nodes()[norm.node].op else { return None };
                let node = &nodes[norm.node];
                let (channels, positions) = (node.channels, node.positions);
                let buffers = node.buffers.clone();
                Some(Norm::new(channels, positions, eps, momentum, node.params.clone(), buffers))
            })
            .collect();
        let lens: Vec<usize> = graph.nodes().iter().map(|n| n.shape.iter().product()).collect();
        let most = (PARTIALS / usize::max(sums, 1)).clamp(2, PARTS).min(options.batch);
        let capacity = options.batch.div_ceil(most);
        let places = Places::new(&plan, capacity);
        let parts = (0..options.batch.div_ceil(capacity))
            .map(|_| Part::new(capacity, &plan, &nodes, &norms, &places, &lens, sums))
            .collect();
        let heads = Head::all(graph, &plan, &nodes, options.batch);
        let mut engine = Engine {
            graph: graph.clone(),
            batch: options.batch,
            threads,
            plan,
            nodes,
            batches,
            norms,
            places: places.places,
            lens,
            parts,
            params: Buffer::zeros(params),
            packed: false,
            gradient_sums: Buffer::zeros(sums),
            dparams: Buffer::zeros(learned),
            optimizer: Memory::default(),
            buffers: vec![0.0; buffers],
            heads,
            last: 0,
            trained: None,
            dropout: (0, 0),
        };
        engine.set_weights(weights)?;
        Ok(engine)
    }

    /// The network that was compiled.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Replaces all parameters and running statistics; optimisers start anew.
    ///
    /// # Errors
    /// Missing, extra or misshaped tensors, by name; nothing is replaced then.
    pub fn set_weights(&mut self, weights: &Weights) -> Result<()> {
        weights.check(&self.graph)?;
        for (id, node) in self.graph.nodes().iter().enumerate() {
            let (mut param_at, mut buffer_at) = (self.nodes[id].params.start, self.nodes[id].buffers.start);
            for param in &node.params {
                let Some(tensor) = weights.get(&param.name) else { continue };
                let (arena, at) = match param.kind {
                    Kind::Parameter => (&mut *self.params, &mut param_at),
                    Kind::Buffer => (&mut *self.buffers, &mut buffer_at),
                };
                layers::read_tensor(node, param, &tensor.data, &mut arena[*at..*at + param.len()]);
                *at += param.len();
            }
        }
        self.optimizer = Memory::default();
        self.packed = false;
        self.trained = None;
        Ok(())
    }

    /// All parameters and running statistics, PyTorch's names and axis order.
    pub fn weights(&self) -> Weights {
        self.export(&self.params, true)
    }

    /// Gradients of the last [`Engine::backward`], by parameter name; frozen parameters have none.
    pub fn gradients(&self) -> Weights {
        self.export(&self.dparams, false)
    }

    /// What the optimisers remember.
    pub fn optimizer_state(&self) -> OptimizerState {
        OptimizerState {
            step: self.optimizer.step,
            momentum_buffer: self.export(&self.optimizer.velocity, false),
            exp_avg: self.export(&self.optimizer.first, false),
            exp_avg_sq: self.export(&self.optimizer.second, false),
        }
    }

    /// Goes on where [`Engine::optimizer_state`] was taken.
    ///
    /// # Errors
    /// A group that is neither empty nor holds exactly the parameters that learn, by name; nothing is
    /// replaced then.
    pub fn set_optimizer_state(&mut self, state: &OptimizerState) -> Result<()> {
        let groups = [&state.momentum_buffer, &state.exp_avg, &state.exp_avg_sq];
        for group in groups.iter().filter(|group| !group.is_empty()) {
            let learned = self.graph.nodes().iter().zip(&self.nodes).filter(|(_, n)| self.learns(n));
            let params = learned.flat_map(|(node, _)| &node.params).filter(|p| p.kind == Kind::Parameter);
            group.check_params(self.graph.name(), params)?;
        }
        let mut buffers = groups.map(|_| Buffer::default());
        for (buffer, group) in buffers.iter_mut().zip(groups).filter(|(_, group)| !group.is_empty()) {
            fill_up(buffer, self.dparams.len());
            for (node, placed) in self.graph.nodes().iter().zip(&self.nodes) {
                let mut at = placed.params.start;
                for param in node.params.iter().filter(|p| p.kind == Kind::Parameter) {
                    let inner = buffer.get_mut(at..at + param.len());
                    let (Some(tensor), Some(inner)) = (group.get(&param.name), inner) else { continue };
                    layers::read_tensor(node, param, &tensor.data, inner);
                    at += param.len();
                }
            }
        }
        let [velocity, first, second] = buffers;
        self.optimizer = Memory { step: state.step, velocity, first, second };
        Ok(())
    }

    /// Whether a node's parameters get gradients.
    fn learns(&self, node: &NodeState) -> bool {
        node.params.end <= self.dparams.len()
    }

    fn export(&self, arena: &[f32], with_buffers: bool) -> Weights {
        let mut weights = Weights::new();
        for (id, node) in self.graph.nodes().iter().enumerate() {
            let (mut param_at, mut buffer_at) = (self.nodes[id].params.start, self.nodes[id].buffers.start);
            for param in &node.params {
                let (arena, at) = match param.kind {
                    Kind::Parameter => (arena, &mut param_at),
                    Kind::Buffer if with_buffers => (self.buffers.as_slice(), &mut buffer_at),
                    Kind::Buffer => continue,
                };
                // Gradients and moments of frozen parameters have no place.
                let Some(inner) = arena.get(*at..*at + param.len()) else { continue };
                let data = layers::write_tensor(node, param, inner);
                *at += param.len();
                weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
            }
        }
        weights
    }

    /// Logits [n, classes] of a batch: the first output; [`Engine::outputs`] gives all.
    ///
    /// `inputs` are the graph's inputs in order, each [n, …] in PyTorch's axis order, row-major.
    ///
    /// # Errors
    /// An empty or too large batch, or inputs of another length than `n` samples have.
    pub fn forward(&mut self, inputs: &[&[f32]], n: usize, mode: Mode) -> Result<&[f32]> {
        self.trained = None;
        self.check_inputs(inputs, n)?;
        // Equal shares of this batch, whatever its size.
        let each = n.div_ceil(self.parts.len());
        for (number, part) in self.parts.iter_mut().enumerate() {
            part.first = (number * each).min(n);
            part.count = ((number + 1) * each).min(n) - part.first;
        }
        self.pack();
        let train = mode == Mode::Train;
        self.draw_masks(train);
        if train {
            self.parts.iter_mut().flat_map(|p| &mut p.moments).for_each(|m| m.clear());
        }
        for (norm, plan) in self.norms.iter_mut().zip(&self.plan.norms) {
            if !train || plan.frozen {
                norm.evaluate(&self.params, &self.buffers);
            }
        }
        for number in 0..if train { self.plan.train.len() } else { self.plan.eval.len() } {
            let phase = if train { &self.plan.train[number] } else { &self.plan.eval[number] };
            match phase {
                Phase::Samples(steps) => {
                    let shared = shared!(self, train);
                    self.threads.each(&mut self.parts, 1, |_, part| part[0].forward(&shared, steps, inputs));
                }
                Phase::Norms(numbers) => {
                    for &number in numbers {
                        let moments = self.parts.iter().map(|p| &p.moments[number]);
                        self.norms[number].train(moments, &self.params, &mut self.buffers);
                    }
                }
                &Phase::Batch(id) => self.forward_batch(id, n, train),
            }
        }
        self.heads.iter_mut().for_each(|head| head.read(&self.parts, &self.norms));
        self.last = n;
        if train {
            self.trained = Some(n);
        }
        Ok(&self.heads[0].values[..n * self.heads[0].len()])
    }

    /// Names and values [n, …] of all outputs of the last forward pass, in the graph's order.
    pub fn outputs(&self) -> impl Iterator<Item = (&str, &[f32])> {
        self.heads.iter().map(|head| (head.name.as_str(), &head.values[..self.last * head.len()]))
    }

    fn pack(&mut self) {
        if std::mem::replace(&mut self.packed, true) {
            return;
        }
        let (params, buffers) = (&self.params, &self.buffers);
        self.threads.each(&mut self.nodes, 1, |_, node| {
            let node = &mut node[0];
            if let Some(layer) = &node.layer {
                layer.pack(&params[node.params.clone()], &mut node.packed);
                layer.keep(&buffers[node.buffers.clone()], &mut node.packed);
            }
        });
    }

    /// What the dropouts drop in the next pass: of every training pass something else, in evaluation
    /// nothing.
    fn draw_masks(&mut self, train: bool) {
        let (seed, step) = self.dropout;
        for (state, node) in self.nodes.iter_mut().zip(self.graph.nodes()) {
            if let Op::Dropout { probability } = node.op {
                state.mask = train.then(|| DropoutMask::new(seed, &node.name, step, probability));
            }
        }
        self.dropout.1 += u64::from(train);
    }

    /// Gathers a node's input rows, runs it, and gives the rows back to the parts.
    fn forward_batch(&mut self, id: usize, n: usize, train: bool) {
        let seen = self.plan.nodes[id].inputs[0];
        let Some(batch) = &mut self.batches[id] else { return };
        let (view, channels) = (view(&seen, &self.norms), self.nodes[seen.stored].channels);
        for part in self.parts.iter().filter(|p| p.count > 0) {
            let (from, len) = (part.first * batch.inputs, part.count * batch.inputs);
            view.apply(channels, &part.values[seen.stored][..len], &mut batch.x[from..from + len]);
        }
        let (params, outputs) = (&self.params[self.nodes[id].params.clone()], batch.outputs);
        let (x, y) = (&batch.x[..n * batch.inputs], &mut batch.y[..n * outputs]);
        batch.layer.forward(&self.threads, n, params, x, y);
        let shared = shared!(self, train);
        for part in &mut self.parts {
            let (from, len) = (part.first * outputs, part.count * outputs);
            part.values[id][..len].copy_from_slice(&y[from..from + len]);
            for sample in 0..if train { part.count } else { 0 } {
                part.measure(&shared, id, sample);
            }
        }
    }

    /// Mean softmax cross-entropy of the last training pass, and the gradients of all parameters; of several
    /// outputs the sum, weighted as the graph says.
    ///
    /// # Errors
    /// No training pass before it, or labels that are not one class number per sample.
    pub fn backward(&mut self, labels: &[u32]) -> Result<f32> {
        self.backward_with(Loss::SoftmaxCrossEntropy, Targets::Labels(labels))
    }

    /// `loss` of the last training pass between every output and `targets`, weighted as the graph says, and
    /// the gradients of all parameters.
    ///
    /// # Errors
    /// No training pass before it, or targets that do not fit the batch or the loss; the pass stays usable.
    pub fn backward_with(&mut self, loss: Loss, targets: Targets) -> Result<f32> {
        let Some(n) = self.trained else {
            let (model, reason) =
                (self.graph.name().into(), "backward needs a forward pass in training".into());
            return Err(Error::Batch { model, reason });
        };
        for head in &self.heads {
            head.check(self.graph.name(), loss, n, targets)?;
        }
        self.trained = None;
        let mut sum = 0.0;
        for head in &mut self.heads {
            sum += head.loss(loss, n, targets);
            head.seed(&mut self.parts, &self.places);
        }
        for part in &mut self.parts {
            part.gradient_sums.fill(0.0);
            part.sums.iter_mut().for_each(|sums| sums.fill(0.0));
        }
        let params = &self.params;
        self.threads.each(&mut self.nodes, 1, |_, node| {
            let node = &mut node[0];
            if let Some(layer) = &node.layer {
                layer.prepare(&params[node.params.clone()], &mut node.prepared);
            }
        });
        for number in 0..self.plan.backward.len() {
            match &self.plan.backward[number] {
                Phase::Samples(steps) => {
                    let shared = shared!(self, true);
                    self.threads.each(&mut self.parts, 1, |_, part| part[0].backward(&shared, steps));
                }
                Phase::Norms(numbers) => {
                    for &number in numbers {
                        let mut sums = vec![0.0; 2 * self.norms[number].channels];
                        for part in &self.parts {
                            sums.iter_mut().zip(&part.sums[number]).for_each(|(sum, value)| *sum += value);
                        }
                        self.norms[number].backward(n, &sums, &self.params, &mut self.dparams);
                    }
                }
                &Phase::Batch(id) => self.backward_batch(id, n),
            }
        }
        let parts = &self.parts;
        self.threads.each(&mut self.gradient_sums, 1 << 14, |piece, sums| {
            let range = piece << 14..(piece << 14) + sums.len();
            sums.copy_from_slice(&parts[0].gradient_sums[range.clone()]);
            for part in &parts[1..] {
                taxel_kernels::pointwise::copy(&part.gradient_sums[range.clone()], sums, true);
            }
        });
        for node in self.nodes.iter().filter(|node| !node.sums.is_empty()) {
            if let Some(layer) = &node.layer {
                let dparams = &mut self.dparams[node.params.clone()];
                layer.finish(&self.gradient_sums[node.sums.clone()], dparams);
            }
        }
        Ok(sum)
    }

    fn backward_batch(&mut self, id: usize, n: usize) {
        let target = self.plan.nodes[id].slots[0];
        let shared = shared!(self, true);
        let Some(batch) = &mut self.batches[id] else { return };
        let (inputs, outputs) = (batch.inputs, batch.outputs);
        for part in &mut self.parts {
            for sample in 0..part.count {
                let len = outputs;
                let to = (part.first + sample) * len;
                let gradient = match part.collect(&shared, id, sample) {
                    Some(slot) => {
                        let Place { buffer, stride } = self.places[slot];
                        &part.slots[buffer][sample * stride..][..len]
                    }
                    None => part.collected(len),
                };
                batch.dy[to..to + len].copy_from_slice(gradient);
            }
        }
        let range = self.nodes[id].params.clone();
        // Frozen parameters have no gradients.
        let (params, dparams) =
            (&self.params[range.clone()], self.dparams.get_mut(range).unwrap_or_default());
        let (x, dy) = (&batch.x[..n * inputs], &batch.dy[..n * outputs]);
        let dx = target.is_some().then_some(&mut batch.dx[..n * inputs]);
        batch.layer.backward(BatchBackward { threads: &self.threads, n, params, x, dy }, dparams, dx);
        let Some((slot, add)) = target else { return };
        for part in &mut self.parts {
            let (from, len) = (part.first * inputs, part.count * inputs);
            taxel_kernels::pointwise::copy(
                &batch.dx[from..from + len],
                &mut part.slots[self.places[slot].buffer][..len],
                add,
            );
        }
    }

    /// Scales the gradients of the last [`Engine::backward`] so that the norm of all together is at most
    /// `largest`; returns the norm before (`torch.nn.utils.clip_grad_norm_`).
    pub fn clip_gradients(&mut self, largest: f32) -> f32 {
        clip_by_global_norm(&mut self.dparams, largest)
    }

    /// One step of SGDM with the gradients of the last [`Engine::backward`].
    pub fn sgdm(&mut self, step: &Sgdm) {
        self.packed = false;
        self.optimizer.sgdm(&mut self.params[..self.dparams.len()], &self.dparams, step);
    }

    /// One step of Adam (`torch.optim.Adam`: coupled weight decay) with those gradients.
    pub fn adam(&mut self, settings: &Adam) {
        self.packed = false;
        self.optimizer.adam(&mut self.params[..self.dparams.len()], &self.dparams, settings, false);
    }

    /// One step of AdamW (`torch.optim.AdamW`: decoupled weight decay) with those gradients.
    pub fn adamw(&mut self, settings: &Adam) {
        self.packed = false;
        self.optimizer.adam(&mut self.params[..self.dparams.len()], &self.dparams, settings, true);
    }

    /// Seed of the dropout masks, and the step of the next training pass; 0 and 0 at first.
    pub fn dropout(&self) -> (u64, u64) {
        self.dropout
    }

    /// Which masks dropout draws from now on (see [`DropoutMask`]): the next training pass those of `step`
    /// in a run with `seed`, the one after it those of `step + 1`.
    pub fn set_dropout(&mut self, seed: u64, step: u64) {
        self.dropout = (seed, step);
    }

    /// From now on, training passes gather batch-norm statistics over everything they see.
    pub fn begin_population(&mut self) {
        // Frozen ones see none, and so keep what they have.
        self.norms.iter_mut().for_each(Norm::begin_population);
    }

    /// Running statistics become mean and variance over all training passes since
    /// [`Engine::begin_population`]; without such a pass they stay.
    pub fn end_population(&mut self) {
        self.norms.iter_mut().for_each(|norm| norm.end_population(&mut self.buffers));
    }

    fn check_inputs(&self, inputs: &[&[f32]], n: usize) -> Result<()> {
        let model = self.graph.name().to_string();
        let refuse = |reason: String| Error::Batch { model: model.clone(), reason };
        if n == 0 || n > self.batch {
            return Err(refuse(format!("a batch of {n} samples; compiled for 1 to {}", self.batch)));
        }
        let expected = self.graph.inputs().len();
        if inputs.len() != expected {
            return Err(refuse(format!("{} inputs given, {expected} expected", inputs.len())));
        }
        for (node, x) in self.graph.inputs().zip(inputs) {
            let len = node.shape.iter().product::<usize>();
            if x.len() != n * len {
                return Err(refuse(format!(
                    "input `{}` holds {} values; {n} samples of {} have {}",
                    node.name,
                    x.len(),
                    taxel_graph::describe(&node.shape),
                    n * len
                )));
            }
        }
        Ok(())
    }
}
