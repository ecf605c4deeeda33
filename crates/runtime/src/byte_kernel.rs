//! Calls that read or write bytes.

use taxel_kernels::frozen::bytes::{
    Add, ByteOutput, ByteScale, Conv, Depthwise, Deviation, Map, Mean, SourceValues, Sums, max, shuffle,
};
use taxel_kernels::frozen::{ImagePlace, Pooling, Reach, Route};

use crate::memory::ProgramBuffer;
use crate::step::{self, Algorithm, StepOp};

/// Largest weight.
const MOST: f64 = 127.0;
/// Largest biases, in units of the sums: of sums of 32 bits, and of those that floats hold.
const BIAS: [f64; 2] = [(1u32 << 30) as f64, (1u32 << 21) as f64];

/// The kernel of a call in bytes.
pub(crate) enum ByteKernel {
    Conv(Box<Conv>),
    Depthwise(Box<Depthwise>),
    Map(Map),
    Add(Add),
    Max { axes: [Vec<Reach>; 3], from: ImagePlace, to: ImagePlace },
    Mean(Mean),
    Deviation(Deviation),
    Shuffle { groups: usize, from: ImagePlace, to: ImagePlace },
}

/// Where a value lies, and how it is written in bytes; none for floats.
type ValuePlace = (ImagePlace, Option<ByteScale>);

impl ByteKernel {
    /// Checks whether a network in bytes computes a step between floats by a kernel of this kind too, for others fuse
    /// products and sums where the processor can.
    pub fn computes_floats(work: &StepOp) -> bool {
        matches!(work, StepOp::Affine { .. } | StepOp::Deviation(_))
    }

    /// Makes the kernel of a step at least one of whose values is bytes, or one that [`ByteKernel::computes_floats`].
    pub fn new(work: StepOp, from: &[ValuePlace], to: ValuePlace) -> Self {
        let output = to.1.map_or(ByteOutput::Floats, ByteOutput::Bytes);
        match work {
            StepOp::Conv(conv) => Self::conv(conv, from, to.0, output),
            StepOp::Linear { weight, bias, rectifier } => {
                let conv = step::Conv::over_all(from[0].0.size, weight, bias, rectifier);
                Self::conv(conv, from, to.0, output)
            }
            StepOp::Affine { scale, rectifier } => {
                let affine = scale.as_ref().map(|(scale, shift)| (scale.as_slice(), shift.as_slice()));
                ByteKernel::Map(Map::new(from[0], (to.0, output), affine, rectifier))
            }
            StepOp::Add { rectifier } => {
                let input = |which: usize| (from[which].0, written(from[which]));
                ByteKernel::Add(Add::new([input(0), input(1)], (to.0, output), rectifier))
            }
            StepOp::Pool { pooling: Pooling::Max, axes } => {
                ByteKernel::Max { axes, from: from[0].0, to: to.0 }
            }
            StepOp::Pool { pooling: Pooling::Mean, axes } => {
                ByteKernel::Mean(Mean::new(axes, (from[0].0, written(from[0])), (to.0, output)))
            }
            StepOp::Deviation(eps) => ByteKernel::Deviation(Deviation::new(eps, from[0].0, to.0)),
            StepOp::Shuffle(groups) => ByteKernel::Shuffle { groups, from: from[0].0, to: to.0 },
            _ => unreachable!("the quantisation gives other steps floats"),
        }
    }

    fn conv(conv: step::Conv, from: &[ValuePlace], to: ImagePlace, output: ByteOutput) -> Self {
        let step::Conv { window, dilation, groups, weight, bias, rectifier, algorithm } = conv;
        let is_depthwise = matches!(algorithm, Algorithm::Depthwise);
        let (input, addend) = (written(from[0]), from.get(1).map(|value| written(*value)));
        let whole = Whole::of(&weight, &bias, groups, input, is_depthwise);
        let Whole { weight, unit, bias } = &whole;
        let sums = Sums { weight, unit, bias, input, addend, output };
        let route = Route { from: from[0].0, to, addend: from.get(1).map(|value| value.0), rectifier };
        if is_depthwise {
            ByteKernel::Depthwise(Box::new(Depthwise::new(&window, dilation, &sums, route)))
        } else {
            ByteKernel::Conv(Box::new(Conv::new(&window, dilation, groups, &sums, route)))
        }
    }

    /// Runs the call: `values` are the inputs' buffers, `y` is the output's.
    pub fn run(&self, values: &[&ProgramBuffer], y: &mut ProgramBuffer) {
        match self {
            ByteKernel::Conv(conv) => {
                conv.run(values[0].bytes(), values.get(1).map(|addend| addend.bytes()), y.target());
            }
            ByteKernel::Depthwise(conv) => conv.run(values[0].bytes(), y.target()),
            ByteKernel::Map(map) => {
                let source = match values[0] {
                    ProgramBuffer::Floats(x) => SourceValues::Floats(x),
                    ProgramBuffer::Bytes(x) => SourceValues::Bytes(x),
                };
                map.run(source, y.target());
            }
            ByteKernel::Add(add) => add.run(values[0].bytes(), values[1].bytes(), y.target()),
            ByteKernel::Mean(mean) => mean.run(values[0].bytes(), y.target()),
            ByteKernel::Deviation(deviation) => {
                let ProgramBuffer::Floats(y) = y else { unreachable!("a deviation of floats is a float") };
                deviation.run(values[0].floats(), y);
            }
            ByteKernel::Max { axes, from, to } => {
                let ProgramBuffer::Bytes(y) = y else { unreachable!("the largest of bytes is a byte") };
                max(axes, from, values[0].bytes(), to, y);
            }
            ByteKernel::Shuffle { groups, from, to } => {
                let ProgramBuffer::Bytes(y) = y else { unreachable!("shuffled bytes are bytes") };
                shuffle(*groups, from, values[0].bytes(), to, y);
            }
        }
    }
}

/// Returns how the bytes of a value are written that the quantisation has made bytes.
fn written(value: ValuePlace) -> ByteScale {
    #[expect(clippy::expect_used, reason = "the quantisation gives these steps bytes")]
    value.1.expect("a value in bytes")
}

/// Weights and biases as whole numbers.
pub(crate) struct Whole {
    pub weight: Vec<i8>,
    pub unit: Vec<f32>,
    pub bias: Vec<i32>,
}

impl Whole {
    /// Rounds the weights and biases of a convolution whose input is written so.
    pub fn of(weight: &[f32], bias: &[f32], groups: usize, input: ByteScale, is_depthwise: bool) -> Self {
        let layout = if is_depthwise { 1 } else { groups };
        Whole::new(weight, bias, layout, input, BIAS[usize::from(is_depthwise)])
    }

    /// Rounds each filter in units of its own, symmetric around 0; `weight` lies as group × … × filters of the group.
    /// A unit is so large that the bias is at most `limit`.
    fn new(weight: &[f32], bias: &[f32], groups: usize, input: ByteScale, limit: f64) -> Self {
        let filters = bias.len() / groups;
        let of_group = weight.len() / groups;
        let step = f64::from(input.step);
        let mut largest = vec![0f64; bias.len()];
        for (group, weight) in weight.chunks_exact(of_group).enumerate() {
            for row in weight.chunks_exact(filters) {
                for (largest, w) in largest[group * filters..].iter_mut().zip(row) {
                    *largest = largest.max(f64::from(w.abs()));
                }
            }
        }
        let unit = |(largest, bias): (&f64, &f32)| {
            let unit = (largest / MOST).max(f64::from(bias.abs()) / (step * limit));
            if unit > 0.0 && unit.is_finite() { unit } else { 1.0 }
        };
        let units: Vec<f64> = largest.iter().zip(bias).map(unit).collect();
        let mut whole = vec![];
        for (group, weight) in weight.chunks_exact(of_group).enumerate() {
            for row in weight.chunks_exact(filters) {
                let row = row.iter().zip(&units[group * filters..]);
                whole.extend(row.map(|(w, unit)| (f64::from(*w) / unit).round_ties_even() as i8));
            }
        }
        let bias =
            bias.iter().zip(&units).map(|(b, u)| (f64::from(*b) / (step * u)).round_ties_even() as i32);
        let bias = bias.collect();
        let unit = units.iter().map(|unit| (unit * step) as f32).collect();
        Whole { weight: whole, unit, bias }
    }
}
