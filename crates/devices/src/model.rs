//! A graph with candle tensors.

use std::collections::HashMap;

use candle_core::{D, Device, Tensor, Var};
use taxel_graph::{DropoutMask, Graph, Loss, Node, Op, Targets, TensorKind, Weights};

use crate::error::{Error, Result};
use crate::gather::Gather;
use crate::{activation, objective, recurrent};

/// A graph and its tensors on a device.
pub struct Model {
    graph: Graph,
    device: Device,
    tensors: HashMap<String, Var>,
    /// Seed and step of the dropout masks.
    dropout: (u64, u64),
}

impl Model {
    /// Puts `weights` on `device`.
    ///
    /// # Errors
    /// Missing, extra or misshaped tensors, by name.
    pub fn new(graph: &Graph, weights: &Weights, device: &Device) -> Result<Self> {
        weights.check(graph)?;
        let mut tensors = HashMap::new();
        for param in graph.params() {
            let Some(tensor) = weights.get(&param.name) else { continue };
            let var = Tensor::from_slice(&tensor.data, tensor.shape.as_slice(), device)
                .and_then(|t| Var::from_tensor(&t))
                .map_err(|source| Error::Node { node: param.name.clone(), source })?;
            tensors.insert(param.name.clone(), var);
        }
        Ok(Model { graph: graph.clone(), device: device.clone(), tensors, dropout: (0, 0) })
    }

    /// Chooses which masks dropout draws in training passes from now on: those of `step` in a run with `seed` (see
    /// [`DropoutMask`]); 0 and 0 at first.
    pub fn set_dropout(&mut self, seed: u64, step: u64) {
        self.dropout = (seed, step);
    }

    /// Computes the outputs by name, each [n, …] row-major; batch statistics when `train`.
    ///
    /// `inputs` are the graph's inputs in order, each [n, …] in PyTorch's axis order, row-major.
    ///
    /// # Errors
    /// Inputs of another length than `n` samples have.
    pub fn forward(&self, inputs: &[&[f32]], n: usize, train: bool) -> Result<Vec<(String, Vec<f32>)>> {
        let values = self.run(inputs, n, train)?;
        let read = |(name, id): &(String, usize)| {
            let flat = values[*id].flatten_all().and_then(|t| t.to_vec1());
            flat.map(|v| (name.clone(), v)).map_err(|source| Error::Node { node: name.clone(), source })
        };
        self.graph.outputs().iter().map(read).collect()
    }

    /// Computes the mean softmax cross-entropy of a training batch and the gradient of every parameter; of several
    /// outputs the sum, weighted as the graph says.
    ///
    /// # Errors
    /// Inputs or labels that do not fit the batch.
    pub fn loss_and_gradients(&self, inputs: &[&[f32]], labels: &[u32]) -> Result<(f32, Weights)> {
        let (loss, targets) = (Loss::SoftmaxCrossEntropy, Targets::Labels(labels));
        self.loss_and_gradients_with(inputs, labels.len(), loss, targets)
    }

    /// Computes `loss` of a training batch of `n` samples between every output and `targets`, weighted as the graph
    /// says, and the gradient of every parameter.
    ///
    /// # Errors
    /// Inputs or targets that do not fit the batch or the loss.
    pub fn loss_and_gradients_with(
        &self,
        inputs: &[&[f32]],
        n: usize,
        loss: Loss,
        targets: Targets,
    ) -> Result<(f32, Weights)> {
        let model = self.graph.name();
        let at = |source| Error::Node { node: model.into(), source };
        for (_, id) in self.graph.outputs() {
            targets.check(model, loss, n, self.graph.nodes()[*id].shape.iter().product())?;
        }
        let values = self.run(inputs, n, true)?;
        let heads = self.graph.outputs().iter().zip(self.graph.loss_weights());
        let sum = heads
            .map(|((_, id), &weight)| objective::mean_loss(&values[*id], loss, targets)? * f64::from(weight));
        let loss =
            sum.reduce(|a, b| a? + b?).unwrap_or_else(|| Tensor::new(0f32, &self.device)).map_err(at)?;
        let store = loss.backward().map_err(at)?;
        let mut gradients = Weights::new();
        for param in self.graph.params().filter(|p| p.kind == TensorKind::Parameter) {
            let at = |source| Error::Node { node: param.name.clone(), source };
            let Some(gradient) = store.get(self.tensors[&param.name].as_tensor()) else { continue };
            let data = gradient.flatten_all().and_then(|t| t.to_vec1()).map_err(at)?;
            gradients.insert(&param.name, taxel_graph::Tensor { shape: param.shape.clone(), data });
        }
        Ok((loss.to_scalar().map_err(at)?, gradients))
    }

    fn run(&self, inputs: &[&[f32]], n: usize, train: bool) -> Result<Vec<Tensor>> {
        let mut inputs = inputs.iter();
        let mut values: Vec<Tensor> = Vec::with_capacity(self.graph.nodes().len());
        for node in self.graph.nodes() {
            let value = if node.op == Op::Input {
                let x = inputs.next().copied().unwrap_or_default();
                self.input(node, x, n)?
            } else {
                let xs: Vec<&Tensor> = node.inputs.iter().map(|&i| &values[i]).collect();
                self.node(node, &xs, train)
                    .map_err(|source| Error::Node { node: node.name.clone(), source })?
            };
            values.push(value);
        }
        if inputs.next().is_some() {
            let reason = format!("more inputs given than the {} expected", self.graph.inputs().len());
            return Err(Error::Batch { model: self.graph.name().into(), reason });
        }
        Ok(values)
    }

    fn input(&self, node: &Node, x: &[f32], n: usize) -> Result<Tensor> {
        let len = n * node.shape.iter().product::<usize>();
        if n == 0 || x.len() != len {
            let shape = taxel_graph::describe(&node.shape);
            let reason = format!(
                "input `{}` holds {} values; {n} samples of {shape} have {len}, and a batch has at least one",
                node.name,
                x.len()
            );
            return Err(Error::Batch { model: self.graph.name().into(), reason });
        }
        let mut shape = vec![n];
        shape.extend(&node.shape);
        Tensor::from_slice(x, shape, &self.device)
            .map_err(|source| Error::Node { node: node.name.clone(), source })
    }

    fn node(&self, node: &Node, xs: &[&Tensor], train: bool) -> candle_core::Result<Tensor> {
        let x = xs[0];
        let tensor = |i: usize| self.tensors[&node.params[i].name].as_tensor();
        match &node.op {
            Op::Input => Ok(x.clone()),
            Op::Conv { window, dilation, groups, bias, .. } => {
                let gather = Gather::dilated(window, dilation, &x.dims()[2..]);
                let y = self.conv(x, tensor(0), &gather, *groups, node)?;
                if *bias { y.broadcast_add(&per_channel(tensor(1), y.rank())?) } else { Ok(y) }
            }
            Op::BatchNorm { eps, momentum } => {
                let (mean, var) = if train {
                    let (mean, var) = moments(x)?;
                    self.move_running(node, x, &mean, &var, f64::from(*momentum))?;
                    (mean, var)
                } else {
                    (tensor(2).clone(), tensor(3).clone())
                };
                batch_norm(x, [&mean, &var, tensor(0), tensor(1)], *eps)
            }
            Op::LayerNorm { eps } => {
                let deviations = x.broadcast_sub(&x.mean_keepdim(1)?)?;
                let sd = (deviations.sqr()?.mean_keepdim(1)? + f64::from(*eps))?.sqrt()?;
                deviations.broadcast_div(&sd)?.broadcast_mul(tensor(0))?.broadcast_add(tensor(1))
            }
            // candle's own relu passes the gradient at 0; PyTorch does not.
            Op::Relu => x.le(0f32)?.where_cond(&x.zeros_like()?, x),
            Op::Activation(function) => activation::apply(*function, x),
            Op::Dropout { probability } if train => self.dropout(node, x, *probability),
            Op::Dropout { .. } => Ok(x.clone()),
            Op::MaxPool(window) => self.maximum(&Gather::new(window, &x.dims()[2..]), x, node),
            Op::AveragePool { window, counted } => {
                let size = &x.dims()[2..];
                let divisors = Gather::divisors(window, size, counted);
                self.mean(&Gather::new(window, size), &divisors, x, node)
            }
            Op::AdaptiveAveragePool { output } => {
                let (gather, divisors) = Gather::adaptive(&x.dims()[2..], output);
                self.mean(&gather, &divisors, x, node)
            }
            Op::GlobalAveragePool => x.flatten_from(2)?.mean(2),
            Op::GlobalStandardDeviation { eps } => standard_deviation(&x.flatten_from(2)?, *eps),
            Op::Flatten => x.flatten_from(1),
            Op::Linear { bias, .. } => {
                let y = x.matmul(&tensor(0).t()?)?;
                if *bias { y.broadcast_add(tensor(1)) } else { Ok(y) }
            }
            Op::Lstm { .. } | Op::Gru { .. } => recurrent::last(&node.op, x, [0, 1, 2, 3].map(tensor)),
            Op::Scale => x.broadcast_mul(tensor(0)),
            Op::ChannelShuffle { groups } => shuffle(x, *groups),
            Op::Slice { start, len } => x.narrow(1, *start, *len)?.contiguous(),
            Op::Standardize { .. } => {
                let rank = x.rank();
                x.broadcast_sub(&per_channel(tensor(0), rank)?)?.broadcast_div(&per_channel(tensor(1), rank)?)
            }
            Op::SwitchScale => switch_scale(x, xs[1]),
            Op::Add => xs[1..].iter().try_fold(x.clone(), |sum, x| sum + *x),
            Op::Concat => Tensor::cat(xs, 1),
        }
    }

    fn maximum(&self, gather: &Gather, x: &Tensor, node: &Node) -> candle_core::Result<Tensor> {
        let patches = gather.patches(x, f32::NEG_INFINITY, &self.device)?;
        // candle's own maximum gives every tie the gradient; PyTorch the first only.
        let first = patches.detach().argmax_keepdim(2)?;
        self.shaped(patches.contiguous()?.gather(&first, 2)?.squeeze(2)?, node)
    }

    fn conv(
        &self,
        x: &Tensor,
        weight: &Tensor,
        gather: &Gather,
        groups: usize,
        node: &Node,
    ) -> candle_core::Result<Tensor> {
        let (n, filters) = (x.dim(0)?, node.shape[0]);
        let patches = gather.patches(x, 0.0, &self.device)?;
        let (_, channels, volume, positions) = patches.dims4()?;
        let depth = channels / groups * volume;
        let patches = patches.reshape((n, groups, depth, positions))?;
        let weight = weight.reshape((1, groups, filters / groups, depth))?;
        self.shaped(weight.broadcast_matmul(&patches)?, node)
    }

    fn dropout(&self, node: &Node, x: &Tensor, probability: f32) -> candle_core::Result<Tensor> {
        let mask = DropoutMask::new(self.dropout.0, &node.name, self.dropout.1, probability);
        let scale = 1.0 / (1.0 - probability);
        let len = x.elem_count() / x.dim(0)?;
        let factor = |at: usize| if mask.keeps(at / len, at % len) { scale } else { 0.0 };
        let factors: Vec<f32> = (0..x.elem_count()).map(factor).collect();
        x * Tensor::from_vec(factors, x.shape(), &self.device)?
    }

    /// Sums under the windows of `gather`, each divided by its own divisor.
    fn mean(
        &self,
        gather: &Gather,
        divisors: &[f32],
        x: &Tensor,
        node: &Node,
    ) -> candle_core::Result<Tensor> {
        let sum = gather.patches(x, 0.0, &self.device)?.sum(2)?;
        let divisors = Tensor::from_slice(divisors, (1, 1, divisors.len()), &self.device)?;
        self.shaped(sum.broadcast_div(&divisors)?, node)
    }

    /// Reshapes [n, channels, positions] → [n, the node's shape].
    fn shaped(&self, y: Tensor, node: &Node) -> candle_core::Result<Tensor> {
        let mut shape = vec![y.dim(0)?];
        shape.extend(&node.shape);
        y.reshape(shape)
    }

    fn move_running(
        &self,
        node: &Node,
        x: &Tensor,
        mean: &Tensor,
        var: &Tensor,
        momentum: f64,
    ) -> candle_core::Result<()> {
        let count = x.elem_count() as f64 / mean.elem_count() as f64;
        let unbiased = (var.detach() * (count / (count - 1.0).max(1.0)))?;
        for (param, batch) in node.params[2..].iter().zip([&mean.detach(), &unbiased]) {
            let running = &self.tensors[&param.name];
            running.set(&((running.as_tensor() * (1.0 - momentum))? + (batch * momentum)?)?)?;
        }
        Ok(())
    }

    /// Returns all tensors, with the running statistics as training passes left them.
    ///
    /// # Errors
    /// The device fails to give its values back.
    pub fn weights(&self) -> Result<Weights> {
        let mut weights = Weights::new();
        for param in self.graph.params() {
            let data = self.tensors[&param.name].flatten_all().and_then(|t| t.to_vec1());
            let data = data.map_err(|source| Error::Node { node: param.name.clone(), source })?;
            weights.insert(&param.name, taxel_graph::Tensor { shape: param.shape.clone(), data });
        }
        Ok(weights)
    }
}

/// Normalises channels by `mean` and `var`, then scales and shifts them.
fn batch_norm(x: &Tensor, [mean, var, scale, shift]: [&Tensor; 4], eps: f32) -> candle_core::Result<Tensor> {
    let rank = x.rank();
    let sd = (per_channel(var, rank)? + f64::from(eps))?.sqrt()?;
    x.broadcast_sub(&per_channel(mean, rank)?)?
        .broadcast_div(&sd)?
        .broadcast_mul(&per_channel(scale, rank)?)?
        .broadcast_add(&per_channel(shift, rank)?)
}

/// Returns the standard deviation of each channel of `[n, channels, positions]`.
fn standard_deviation(x: &Tensor, eps: f32) -> candle_core::Result<Tensor> {
    let deviations = x.broadcast_sub(&x.mean_keepdim(2)?)?;
    (deviations.sqr()?.mean(2)? + f64::from(eps))?.sqrt()
}

/// Deals the channels of `groups` groups out in turn.
fn shuffle(x: &Tensor, groups: usize) -> candle_core::Result<Tensor> {
    let dims = x.dims();
    let split = [&[dims[0], groups, dims[1] / groups], &dims[2..]].concat();
    x.reshape(split)?.transpose(1, 2)?.contiguous()?.reshape(dims)
}

/// Sets the samples to 0 whose `stream` is constant in every channel.
fn switch_scale(x: &Tensor, stream: &Tensor) -> candle_core::Result<Tensor> {
    let stream = stream.detach().flatten_from(2)?;
    let constant = stream.max(2)?.eq(&stream.min(2)?)?;
    let lit = (1.0 - constant.to_dtype(x.dtype())?.min(1)?)?;
    let mut shape = vec![1; x.rank()];
    shape[0] = x.dim(0)?;
    x.broadcast_mul(&lit.reshape(shape)?)
}

/// Reshapes [channels] → [1, channels, 1, …].
fn per_channel(t: &Tensor, rank: usize) -> candle_core::Result<Tensor> {
    let mut shape = vec![1; rank];
    shape[1] = t.elem_count();
    t.reshape(shape)
}

/// Computes batch mean and biased variance per channel.
fn moments(x: &Tensor) -> candle_core::Result<(Tensor, Tensor)> {
    let channels = x.dim(1)?;
    let flat = x.transpose(0, 1)?.contiguous()?.reshape((channels, ()))?;
    let mean = flat.mean_keepdim(D::Minus1)?;
    let var = flat.broadcast_sub(&mean)?.sqr()?.mean(D::Minus1)?;
    Ok((mean.squeeze(D::Minus1)?, var))
}
