//! Steps with their places become calls of kernels.

use std::mem;

use taxel_graph::Activation;
use taxel_kernels::frozen::bytes::ByteScale;
use taxel_kernels::frozen::{self, ImagePlace, Pool, Route, half};
use taxel_kernels::{
    AffineView, Buffer, Rectifier, activation, deviation, gru, layer_norm, layout, lstm, pointwise,
};

use crate::bands::Bands;
use crate::byte_kernel::ByteKernel;
use crate::dense::{DenseConv, DenseLinear};
use crate::lower::Purpose;
use crate::memory::ProgramBuffer;
use crate::places::ValuePlaces;
use crate::step::{Algorithm, Conv, FrozenStep, StepId, StepOp};
use crate::winograd::Winograd;

/// One call.
pub(crate) struct Call {
    /// The node whose value it computes; empty where no node has it.
    pub name: String,
    pub kernel: CallKernel,
    /// Buffers and places of the inputs, and of the output.
    pub from: Vec<(usize, ImagePlace)>,
    pub to: (usize, ImagePlace),
}

/// The inputs of a call.
#[derive(Clone, Copy)]
pub(crate) struct CallInputs<'a> {
    /// The network's inputs, each of all samples.
    pub inputs: &'a [&'a [f32]],
    /// The sample that is predicted.
    pub sample: usize,
    /// The one of [`Call::parts`] that is run; none for the whole call.
    pub part: Option<usize>,
}

/// Memory of a call besides its values.
#[derive(Default)]
pub(crate) struct Scratch {
    pub input: Buffer,
    pub output: Buffer,
    pub work: Buffer,
}

/// The most values that calls need of each.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct ScratchLens {
    pub input: usize,
    pub output: usize,
    pub work: usize,
}

/// The kernel of a call.
pub(crate) enum CallKernel {
    /// Takes the network's input of this number.
    Input(usize),
    Conv(DenseConv),
    Depthwise(frozen::Depthwise),
    Winograd(Winograd),
    HalfWinograd(half::Winograd),
    Bands(Bands),
    Linear {
        linear: DenseLinear,
        bias: Vec<f32>,
        rectifier: Rectifier,
    },
    Lstm(Box<frozen::Lstm>),
    Gru(Box<frozen::Gru>),
    Affine {
        scale: Option<(Vec<f32>, Vec<f32>)>,
        rectifier: Rectifier,
    },
    Activation(Activation),
    Pool(Pool),
    Add(Rectifier),
    Shuffle(usize),
    Deviation(f32),
    LayerNorm {
        eps: f32,
        weight: Vec<f32>,
        bias: Vec<f32>,
    },
    Flatten,
    Switch,
    /// Reads or writes bytes.
    Bytes(ByteKernel),
}

/// Returns all calls in order, and the lengths of their scratch. A network in bytes predicts the same bits on every
/// processor.
pub(crate) fn program(
    steps: Vec<FrozenStep>,
    places: &ValuePlaces,
    purpose: Purpose,
) -> (Vec<Call>, ScratchLens) {
    let (mut calls, mut scratch) = (vec![], ScratchLens::default());
    let scales: Vec<Option<ByteScale>> = steps.iter().map(|step| step.scale).collect();
    for (id, step) in steps.into_iter().enumerate() {
        let at = |id: StepId| (places.values[id].1, places.values[id].0);
        let from: Vec<(usize, ImagePlace)> = step.inputs.iter().map(|&input| at(input)).collect();
        let to = at(id);
        if let StepOp::Concat = step.work {
            calls.extend(moves(&from, to, step.scale));
            continue;
        }
        if let StepOp::Slice(_) = step.work {
            continue;
        }
        if step.work.needs_dense() {
            scratch.input = scratch.input.max(from.iter().map(|(_, place)| place.len()).sum());
        }
        if !to.1.is_dense() {
            scratch.output = scratch.output.max(to.1.len());
        }
        let read: Vec<Option<ByteScale>> = step.inputs.iter().map(|&input| scales[input]).collect();
        let has_bytes = step.scale.is_some() || read.iter().any(Option::is_some);
        let kernel = if has_bytes || purpose == Purpose::Bytes && ByteKernel::computes_floats(&step.work) {
            let inputs = from.iter().zip(&read).map(|((_, place), scale)| (*place, *scale));
            CallKernel::Bytes(ByteKernel::new(step.work, &inputs.collect::<Vec<_>>(), (to.1, step.scale)))
        } else {
            kernel(step.work, &from, &to.1, purpose, &mut scratch)
        };
        calls.push(Call { name: step.name, kernel, from, to });
    }
    (calls, scratch)
}

/// Returns the copies of those parts of a concatenation that do not lie there already.
fn moves(
    from: &[(usize, ImagePlace)],
    (buffer, whole): (usize, ImagePlace),
    scale: Option<ByteScale>,
) -> Vec<Call> {
    let (mut calls, mut first) = (vec![], 0);
    for &(source, part) in from {
        let to = ImagePlace { channels: part.channels, start: whole.start + first, ..whole };
        first += part.channels;
        if (source, part) != (buffer, to) {
            let plain = || StepOp::Affine { scale: None, rectifier: Rectifier::None };
            let kernel = match scale {
                // All parts are written alike.
                Some(_) => CallKernel::Bytes(ByteKernel::new(plain(), &[(part, scale)], (to, scale))),
                None => CallKernel::Affine { scale: None, rectifier: Rectifier::None },
            };
            calls.push(Call { name: String::new(), kernel, from: vec![(source, part)], to: (buffer, to) });
        }
    }
    calls
}

fn kernel(
    work: StepOp,
    from: &[(usize, ImagePlace)],
    to: &ImagePlace,
    purpose: Purpose,
    scratch: &mut ScratchLens,
) -> CallKernel {
    match work {
        StepOp::Input(number) => CallKernel::Input(number),
        StepOp::Conv(conv) => convolution(conv, from, to, purpose, scratch),
        StepOp::Pair(pair) => {
            let bands = Bands::new(&pair, from[0].1, *to, purpose);
            scratch.work = scratch.work.max(bands.work_len());
            CallKernel::Bands(bands)
        }
        StepOp::Linear { weight, bias, rectifier } => {
            let linear = DenseLinear::new(from[0].1.len(), to.channels, &weight, purpose);
            scratch.work = scratch.work.max(linear.work_len());
            CallKernel::Linear { linear, bias, rectifier }
        }
        StepOp::Lstm { sizes, weights: [ih, hh, bias_ih, bias_hh] } => {
            let weights = lstm::Weights { ih: &ih, hh: &hh, bias_ih: &bias_ih, bias_hh: &bias_hh };
            let lstm = frozen::Lstm::new(sizes, &weights, from[0].1);
            scratch.work = scratch.work.max(lstm.work_len());
            CallKernel::Lstm(Box::new(lstm))
        }
        StepOp::Gru { sizes, weights: [ih, hh, bias_ih, bias_hh] } => {
            let weights = gru::Weights { ih: &ih, hh: &hh, bias_ih: &bias_ih, bias_hh: &bias_hh };
            let gru = frozen::Gru::new(sizes, &weights, from[0].1);
            scratch.work = scratch.work.max(gru.work_len());
            CallKernel::Gru(Box::new(gru))
        }
        StepOp::Affine { scale, rectifier } => CallKernel::Affine { scale, rectifier },
        StepOp::Activation(function) => CallKernel::Activation(function),
        StepOp::Pool { pooling, axes } => CallKernel::Pool(Pool::new(pooling, axes, from[0].1, *to)),
        StepOp::Add { rectifier } => {
            scratch.output = scratch.output.max(to.len());
            CallKernel::Add(rectifier)
        }
        StepOp::Shuffle(groups) => CallKernel::Shuffle(groups),
        StepOp::Deviation(eps) => {
            scratch.work = scratch.work.max(to.channels);
            CallKernel::Deviation(eps)
        }
        StepOp::LayerNorm { eps, weight, bias } => CallKernel::LayerNorm { eps, weight, bias },
        StepOp::Flatten => CallKernel::Flatten,
        StepOp::Switch => CallKernel::Switch,
        StepOp::Concat | StepOp::Slice(_) => unreachable!("they are places, not calls"),
    }
}

fn convolution(
    mut conv: Conv,
    from: &[(usize, ImagePlace)],
    to: &ImagePlace,
    purpose: Purpose,
    scratch: &mut ScratchLens,
) -> CallKernel {
    let x = from[0].1;
    let addend = from.get(1).map(|(_, place)| *place);
    let route = Route { from: x, to: *to, addend, rectifier: conv.rectifier };
    match mem::replace(&mut conv.algorithm, Algorithm::Direct) {
        Algorithm::Direct => {
            let dense = DenseConv::new(&conv, &conv.window, route, purpose);
            scratch.work = scratch.work.max(dense.work_len());
            CallKernel::Conv(dense)
        }
        Algorithm::Depthwise => {
            let Conv { window, dilation, weight, bias, .. } = &conv;
            CallKernel::Depthwise(frozen::Depthwise::new(window, *dilation, weight, bias, route))
        }
        Algorithm::Winograd(_) if purpose == Purpose::Half => {
            let half = half::Winograd::new(&conv.window, &conv.weight, &conv.bias, route);
            scratch.work = scratch.work.max(half.work_len());
            CallKernel::HalfWinograd(half)
        }
        Algorithm::Winograd(plan) => {
            scratch.input = scratch.input.max(x.len() + plan.padded_len());
            scratch.output = scratch.output.max(to.len());
            scratch.work = scratch.work.max(plan.work_len());
            CallKernel::Winograd(Winograd::new(conv, plan))
        }
    }
}

/// Returns `x` without margins and other channels: itself where it has none, else in `scratch`.
fn dense<'a>(place: &ImagePlace, x: &'a [f32], scratch: &'a mut [f32]) -> &'a [f32] {
    if place.is_dense() {
        return &x[..place.len()];
    }
    let to = ImagePlace::dense(place.size, place.channels);
    frozen::copy(place, x, &to, scratch);
    &scratch[..place.len()]
}

/// Runs `make` on a dense output, which then goes where it belongs.
fn staged(to: &ImagePlace, y: &mut [f32], scratch: &mut [f32], make: impl FnOnce(&mut [f32])) {
    if to.is_dense() {
        return make(&mut y[..to.len()]);
    }
    let scratch = &mut scratch[..to.len()];
    make(scratch);
    frozen::copy(&ImagePlace::dense(to.size, to.channels), scratch, to, y);
}

impl Call {
    /// Returns the number of parts that `samples` go through one after the other, so that they share what is read of
    /// large weights.
    pub fn parts(&self, samples: usize) -> usize {
        match &self.kernel {
            // Inputs that have to be gathered first would be gathered for every part.
            CallKernel::Linear { linear, .. } if samples > 1 && self.from[0].1.is_dense() => linear.panels(),
            _ => 1,
        }
    }

    /// Runs the call on the `buffers` of one sample.
    pub fn run(&self, given: CallInputs, buffers: &mut [ProgramBuffer], scratch: &mut Scratch) {
        // Nothing is written where it is read, so the output's buffer can be taken out.
        let mut y = mem::take(&mut buffers[self.to.0]);
        let unread = ProgramBuffer::default();
        let mut values = [&unread; 2];
        values.iter_mut().zip(&self.from).for_each(|(value, (buffer, _))| *value = &buffers[*buffer]);
        let count = self.from.len().min(values.len());
        match (&self.kernel, &mut y) {
            (CallKernel::Bytes(kernel), y) => kernel.run(&values[..count], y),
            (_, ProgramBuffer::Floats(y)) => {
                self.run_floats(given, &values.map(ProgramBuffer::floats)[..count], y, scratch);
            }
            (_, ProgramBuffer::Bytes(_)) => unreachable!("calls of floats write to floats"),
        }
        buffers[self.to.0] = y;
    }

    fn run_floats(&self, given: CallInputs, values: &[&[f32]], y: &mut [f32], scratch: &mut Scratch) {
        let to = &self.to.1;
        let Scratch { input, output, work } = scratch;
        match &self.kernel {
            CallKernel::Input(number) => staged(to, y, output, |y| {
                let x = &given.inputs[*number][given.sample * to.len()..][..to.len()];
                layout::transpose(to.channels, to.positions(), x, y, false);
            }),
            CallKernel::Conv(conv) => conv.run(values[0], values.get(1).copied(), work, y),
            CallKernel::Depthwise(conv) => conv.run(values[0], y),
            CallKernel::Winograd(winograd) => {
                let from = &self.from[0].1;
                let (copy, padded) = input.split_at_mut(if from.is_dense() { 0 } else { from.len() });
                winograd.run(dense(from, values[0], copy), [padded, output, work], to, y);
            }
            CallKernel::HalfWinograd(winograd) => {
                winograd.run(values[0], values.get(1).copied(), work, y);
            }
            CallKernel::Bands(bands) => bands.run(values[0], work, y),
            CallKernel::Linear { linear, bias, rectifier } => {
                let from = &self.from[0].1;
                let (x, y) = (dense(from, values[0], input), &mut y[to.start..]);
                let panels = match given.part {
                    Some(panel) if from.is_dense() => panel..panel + 1,
                    _ => 0..linear.panels(),
                };
                linear.run(panels, x, bias, *rectifier, work, y);
            }
            CallKernel::Lstm(lstm) => lstm.run(values[0], work, &mut y[to.start..]),
            CallKernel::Gru(gru) => gru.run(values[0], work, &mut y[to.start..]),
            CallKernel::Affine { scale, rectifier } => {
                let affine = scale.as_ref().map(|(scale, shift)| (scale.as_slice(), shift.as_slice()));
                let view = AffineView { affine, rectifier: *rectifier };
                frozen::map(&view, &self.from[0].1, values[0], to, y);
            }
            CallKernel::Activation(function) => {
                let x = dense(&self.from[0].1, values[0], input);
                staged(to, y, output, |y| apply(*function, x, y));
            }
            CallKernel::Pool(pool) => pool.run(values[0], y),
            CallKernel::Add(rectifier) => self.add(*rectifier, values, y, output),
            CallKernel::Shuffle(groups) => {
                let x = dense(&self.from[0].1, values[0], input);
                staged(to, y, output, |y| pointwise::shuffle_columns(x, to.channels, *groups, y, false));
            }
            CallKernel::Deviation(eps) => {
                let (x, n) = (dense(&self.from[0].1, values[0], input), to.channels);
                deviation::forward(n, *eps, x, &mut work[..n], &mut y[to.start..][..n]);
            }
            CallKernel::LayerNorm { eps, weight, bias } => {
                let x = dense(&self.from[0].1, values[0], input);
                layer_norm::forward(*eps, x, weight, bias, &mut y[to.start..][..to.channels]);
            }
            CallKernel::Flatten => {
                let (from, x) = (&self.from[0].1, dense(&self.from[0].1, values[0], input));
                staged(to, y, output, |y| layout::transpose(from.positions(), from.channels, x, y, false));
            }
            CallKernel::Bytes(_) => unreachable!("it is run before"),
            CallKernel::Switch => {
                let (first, second) = input.split_at_mut(self.from[0].1.len());
                let x = dense(&self.from[0].1, values[0], first);
                let stream = dense(&self.from[1].1, values[1], second);
                let factor = f32::from(!is_constant(stream, self.from[1].1.channels));
                // A product, so that NaN stays NaN.
                staged(to, y, output, |y| y.iter_mut().zip(x).for_each(|(y, x)| *y = x * factor));
            }
        }
    }

    fn add(&self, rectifier: Rectifier, values: &[&[f32]], y: &mut [f32], output: &mut [f32]) {
        let to = &self.to.1;
        if rectifier == Rectifier::None {
            frozen::copy(&self.from[0].1, values[0], to, y);
            return frozen::add(&self.from[1].1, values[1], to, y);
        }
        let dense = ImagePlace::dense(to.size, to.channels);
        frozen::copy(&self.from[0].1, values[0], &dense, output);
        frozen::add(&self.from[1].1, values[1], &dense, output);
        frozen::map(&AffineView { affine: None, rectifier }, &dense, output, to, y);
    }
}

/// Applies a function of one value.
fn apply(function: Activation, x: &[f32], y: &mut [f32]) {
    match function {
        Activation::Relu6 => activation::relu6(x, y),
        Activation::LeakyRelu { slope } => activation::leaky_relu(slope, x, y),
        Activation::Sigmoid => activation::sigmoid(x, y),
        Activation::Tanh => activation::tanh(x, y),
        Activation::HardSwish => activation::hard_swish(x, y),
    }
}

/// Checks whether every channel has one value at all positions. NaN is not constant.
fn is_constant(x: &[f32], channels: usize) -> bool {
    let first = &x[..channels];
    x.chunks_exact(channels).all(|row| row.iter().zip(first).all(|(x, first)| x == first))
}
