//! From the runtime's steps to layers of C, or a refusal that says which layer cannot become one.

use taxel_kernels::Rectifier;
use taxel_kernels::frozen::bytes::{Add, ByteOutput, ByteScale, Map, Mean};
use taxel_kernels::frozen::{ImagePlace, Pooling, Reach};
use taxel_runtime::{Blueprint, PlannedConv, PlannedOp, PlannedStep};

use crate::floats::layer::FloatWork;
use crate::floats::lower::float_work;
use crate::layer::{Addend, Conv, Depthwise, Layer, Memory, Row, Span, Stage, Taps, Work};

/// The largest count that a layer's tables hold.
const COUNT: usize = u16::MAX as usize;

/// The reason against values that C has no code for.
const OTHER_FORM: &str = "its values are written in a way that C does not have";

/// A network as layers of C.
#[derive(Debug, Clone)]
pub(crate) struct Network {
    pub layers: Vec<Layer>,
    pub memories: Vec<Memory>,
    /// Where the logits lie.
    pub logits: Row,
}

/// Lowers a network that reads samples of `channels` × `steps`.
///
/// # Errors
/// The reason, where a step has no C of the same bits.
pub(crate) fn lower(blueprint: &Blueprint, sample: [usize; 2]) -> Result<Network, String> {
    if blueprint.inputs.len() != 1 || blueprint.outputs.len() != 1 {
        let (inputs, outputs) = (blueprint.inputs.len(), blueprint.outputs.len());
        return Err(format!("it has {inputs} inputs and {outputs} outputs; one of each can be exported"));
    }
    let steps = &blueprint.steps;
    let rows = steps.iter().map(row).collect::<Result<Vec<Row>, String>>()?;
    let memories = steps.iter().enumerate().map(|(id, step)| memory(steps, id, step)).collect();
    let in_floats = blueprint.in_floats;
    let mut lower = Lower { steps, in_floats, rows, memories, layers: vec![], sample };
    for id in 0..steps.len() {
        lower.step(id).map_err(|reason| format!("layer `{}`: {reason}", name_of(steps, id)))?;
    }
    let logits = lower.rows[blueprint.outputs[0].1];
    if logits.positions != 1 || logits.scale.is_some() {
        return Err(format!("its output has {} positions; logits of classes are needed", logits.positions));
    }
    Ok(Network { logits, layers: lower.layers, memories: lower.memories })
}

/// Returns the name of a step, or of the nearest one before it that has one.
fn name_of(steps: &[PlannedStep], id: usize) -> &str {
    steps[..=id].iter().rev().map(|step| step.name.as_str()).find(|name| !name.is_empty()).unwrap_or("input")
}

fn row(step: &PlannedStep) -> Result<Row, String> {
    let ImagePlace { size, channels, start, pitch, .. } = step.place;
    if size[0] != 1 || size[1] != 1 {
        let [depth, rows, columns] = size;
        let size =
            if depth == 1 { format!("{rows}×{columns}") } else { format!("{depth}×{rows}×{columns}") };
        return Err(format!(
            "layer `{}` computes {channels}×{size} values ({} bytes); only networks on series can be exported",
            step.name,
            step.place.len()
        ));
    }
    if size[2] > COUNT || channels > COUNT || pitch[2] > COUNT {
        return Err(format!(
            "layer `{}` has {channels}×{} values; {COUNT} per axis are the most",
            step.name, size[2]
        ));
    }
    let (positions, pitch) = (size[2], pitch[2]);
    Ok(Row { memory: step.memory, start, pitch, positions, channels, scale: step.scale })
}

fn memory(steps: &[PlannedStep], id: usize, step: &PlannedStep) -> Memory {
    if step.memory != id {
        return Memory { len: 0, margins: [0; 2], zero: None };
    }
    let ImagePlace { size, pitch, margin, .. } = steps[id].place;
    let margins = margin.map(|columns| columns * pitch[2]);
    let len = margins[0] + size[2] * pitch[2] + margins[1];
    Memory { len, margins, zero: step.scale.map(|scale| scale.zero) }
}

struct Lower<'a> {
    steps: &'a [PlannedStep],
    in_floats: bool,
    rows: Vec<Row>,
    memories: Vec<Memory>,
    layers: Vec<Layer>,
    /// Channels and time steps of a sample.
    sample: [usize; 2],
}

impl Lower<'_> {
    fn step(&mut self, id: usize) -> Result<(), String> {
        let step = &self.steps[id];
        let (from, to) = (self.inputs(id), self.rows[id]);
        if let Some(work) = float_work(&step.op, self.in_floats, &from, &to, self.memories.len())? {
            if let Work::Floats(FloatWork::Lstm(lstm)) = &work {
                self.memories.push(Memory { len: 5 * lstm.hidden, margins: [0; 2], zero: None });
            }
            self.push(id, work, from, to);
            return Ok(());
        }
        let work = match &step.op {
            PlannedOp::Input(_) => return self.input(id),
            PlannedOp::Slice => return Ok(()),
            PlannedOp::Concat => {
                self.concat(id);
                return Ok(());
            }
            PlannedOp::Map { affine, rectifier } => {
                if self.is_staged(step.inputs[0]) {
                    return self.stage(id, affine.as_ref(), *rectifier);
                }
                map(&from[0], &to, affine.as_ref(), *rectifier)
            }
            PlannedOp::Conv(conv) if conv.is_depthwise => depthwise(conv, &from, &to)?,
            PlannedOp::Conv(conv) => convolution(conv, &from, &to)?,
            PlannedOp::Add(rectifier) => add(&from, &to, *rectifier)?,
            PlannedOp::Pool { pooling, axes } => pool(*pooling, &axes[2], &from[0], &to)?,
            PlannedOp::Deviation(eps) if from[0].scale.is_none() => {
                Work::Deviation { share: 1.0 / from[0].positions as f32, eps: *eps }
            }
            PlannedOp::Shuffle(groups) if to.scale.is_some() => Work::Shuffle(*groups),
            PlannedOp::Flatten if to.scale.is_none() => Work::Flatten,
            PlannedOp::Floats(what) => {
                return Err(format!("it is {what}, which C does not have"));
            }
            PlannedOp::FloatConv(_)
            | PlannedOp::FloatLinear(_)
            | PlannedOp::Lstm(_)
            | PlannedOp::LayerNorm { .. } => return Err("its floats are read as bytes".into()),
            PlannedOp::Deviation(_) | PlannedOp::Shuffle(_) | PlannedOp::Flatten => {
                return Err(OTHER_FORM.into());
            }
        };
        self.push(id, work, from, to);
        Ok(())
    }

    fn inputs(&self, id: usize) -> Vec<Row> {
        self.steps[id].inputs.iter().map(|&input| self.rows[input]).collect()
    }

    fn push(&mut self, id: usize, work: Work, from: Vec<Row>, to: Row) {
        self.layers.push(Layer { name: name_of(self.steps, id).into(), work, from, to });
    }

    /// Checks whether step `id` is the network's input and one step alone reads it, which makes bytes of it.
    fn is_staged(&self, id: usize) -> bool {
        let readers: Vec<&PlannedStep> = self.steps.iter().filter(|step| step.inputs.contains(&id)).collect();
        let makes_bytes = |step: &&PlannedStep| {
            let plain =
                !matches!(&step.op, PlannedOp::Map { affine: Some(_), .. }) || self.keeps_channels(id);
            matches!(step.op, PlannedOp::Map { .. }) && step.scale.is_some() && plain
        };
        matches!(self.steps[id].op, PlannedOp::Input(_))
            && readers.len() == 1
            && readers.iter().all(makes_bytes)
    }

    /// Checks whether the channels of a value are those of the sample.
    fn keeps_channels(&self, id: usize) -> bool {
        let [channels, steps] = self.sample;
        (self.rows[id].channels, self.rows[id].positions) == (channels, steps)
    }

    fn input(&mut self, id: usize) -> Result<(), String> {
        if self.is_staged(id) {
            return Ok(());
        }
        let to = self.rows[id];
        let (by_channel, by_step) = self.distances(&to)?;
        let ending = ByteOutput::Floats.ending(Rectifier::None);
        let work = Work::Stage(Stage { by_channel, by_step, scales: None, ending });
        self.push(id, work, vec![], to);
        Ok(())
    }

    /// Adds the step that makes bytes of the sample.
    fn stage(
        &mut self,
        id: usize,
        affine: Option<&(Vec<f32>, Vec<f32>)>,
        rectifier: Rectifier,
    ) -> Result<(), String> {
        let to = self.rows[id];
        let (by_channel, by_step) = self.distances(&to)?;
        let Work::Map { mut factors, mut shifts, ending } = map(&self.inputs(id)[0], &to, affine, rectifier)
        else {
            return Err(OTHER_FORM.into());
        };
        if !self.keeps_channels(id) {
            factors = vec![factors[0]; self.sample[0]];
            shifts = vec![shifts[0]; self.sample[0]];
        }
        let work = Work::Stage(Stage { by_channel, by_step, scales: Some((factors, shifts)), ending });
        self.push(id, work, vec![], to);
        Ok(())
    }

    /// Returns how far neighbouring channels and time steps of a sample are from each other in `to`.
    fn distances(&self, to: &Row) -> Result<(usize, usize), String> {
        let [channels, steps] = self.sample;
        if channels * steps != to.channels * to.positions {
            return Err(format!(
                "it reads {}×{} values, a sample has {channels}×{steps}; the encoding between them cannot be exported",
                to.channels, to.positions
            ));
        }
        if to.positions == steps {
            Ok((1, to.pitch))
        } else if to.positions == 1 {
            Ok((steps, 1))
        } else if to.channels == 1 {
            Ok((steps * to.pitch, to.pitch))
        } else {
            Err(format!("it reads samples of {channels}×{steps} as {}×{}", to.channels, to.positions))
        }
    }

    /// Adds copies of the parts of a concatenation that do not lie there already.
    fn concat(&mut self, id: usize) {
        let (whole, mut first) = (self.rows[id], 0);
        for part in self.inputs(id) {
            let to = Row { channels: part.channels, start: whole.start + first, ..whole };
            first += part.channels;
            if (part.memory, part.start) != (to.memory, to.start) {
                self.push(id, Work::Copy, vec![part], to);
            }
        }
    }
}

/// Returns as what a row is stored.
fn output(to: &Row) -> ByteOutput {
    to.scale.map_or(ByteOutput::Floats, ByteOutput::Bytes)
}

fn map(from: &Row, to: &Row, affine: Option<&(Vec<f32>, Vec<f32>)>, rectifier: Rectifier) -> Work {
    if affine.is_none() && rectifier == Rectifier::None && from.scale == to.scale {
        return Work::Copy;
    }
    let affine = affine.map(|(scale, shift)| (scale.as_slice(), shift.as_slice()));
    let (factors, shifts) = Map::coefficients(from.channels, from.scale, output(to), affine);
    Work::Map { factors, shifts, ending: output(to).ending(rectifier) }
}

fn add(from: &[Row], to: &Row, rectifier: Rectifier) -> Result<Work, String> {
    let ending = output(to).ending(rectifier);
    match (from[0].scale, from[1].scale) {
        (Some(a), Some(b)) => {
            let (factors, shift) = Add::coefficients([a, b], output(to));
            Ok(Work::Add { factors, shift, ending })
        }
        (None, None) if to.scale.is_none() => Ok(Work::AddFloats(ending)),
        _ => Err("it adds bytes to floats".into()),
    }
}

fn pool(pooling: Pooling, reaches: &[Reach], from: &Row, to: &Row) -> Result<Work, String> {
    if reaches.iter().any(|reach| reach.from >= reach.to) {
        return Err("a window of it lies outside of the series".into());
    }
    let spans: Vec<Span> = reaches.iter().map(|reach| [reach.from, reach.to]).collect();
    match (pooling, from.scale) {
        (Pooling::Max, _) if from.scale == to.scale => Ok(Work::Most(spans)),
        (Pooling::Max, _) => Err(OTHER_FORM.into()),
        (Pooling::Mean, Some(scale)) => {
            let one =
                |reach: &Reach| Mean::coefficients(scale, output(to), reach.count, reach.to - reach.from);
            let scales = reaches.iter().map(one).collect();
            Ok(Work::Mean { spans, scales, ending: output(to).ending(Rectifier::None) })
        }
        (Pooling::Mean, None) if to.scale.is_none() => {
            let shares = reaches.iter().map(|reach| 1.0 / reach.count as f32).collect();
            Ok(Work::MeanFloats { spans, shares })
        }
        (Pooling::Mean, None) => Err(OTHER_FORM.into()),
    }
}

fn bytes(row: &Row) -> Result<ByteScale, String> {
    row.scale.ok_or_else(|| "it reads floats".to_string())
}

fn convolution(conv: &PlannedConv, from: &[Row], to: &Row) -> Result<Work, String> {
    let input = bytes(&from[0])?;
    let PlannedConv { groups, weight, bias, unit, .. } = conv;
    let Taps { kernel, first, step, apart } = Taps::new(&conv.window, conv.dilation, &from[0]);
    let (channels, filters) = (from[0].channels / groups, to.channels / groups);
    // Channels of neighbouring positions lie one after the other.
    let is_whole = *groups == 1 && conv.dilation[2] == 1 && from[0].pitch == channels;
    let (segments, run) = if is_whole { (1, kernel * channels) } else { (kernel, channels) };
    let fours = run.div_ceil(4);
    let mut packed = vec![0; to.channels * segments * fours * 4];
    let (mut start, mut reach) = (vec![], 0i64);
    for filter in 0..to.channels {
        let (group, inside) = (filter / filters, filter % filters);
        let of_group = &weight[group * kernel * channels * filters..][..kernel * channels * filters];
        let of_filter = of_group.iter().skip(inside).step_by(filters);
        let rows = &mut packed[filter * segments * fours * 4..][..segments * fours * 4];
        for (at, w) in of_filter.clone().enumerate() {
            rows[at / run * fours * 4 + at % run] = *w;
        }
        let (begin, most) = sums(bias[filter], input, of_filter);
        reach = reach.max(most);
        start.push(begin);
    }
    let addend = match from.get(1) {
        None => None,
        Some(row) => {
            let scale = bytes(row)?;
            Some(Addend { zero: scale.zero, factor: output(to).factor(scale.step) })
        }
    };
    let numbers = [step, apart, fours, segments, kernel * channels];
    if numbers.iter().any(|number| *number > COUNT) {
        return Err(format!("its filters have {} weights; {COUNT} are the most", kernel * channels));
    }
    Ok(Work::Conv(Conv {
        weight: packed,
        start,
        factor: unit.iter().map(|unit| output(to).factor(*unit)).collect(),
        first,
        step,
        segments,
        apart,
        fours,
        groups: *groups,
        channels,
        addend,
        ending: output(to).ending(conv.rectifier),
        reach: whole(reach)?,
        macs: to.positions * to.channels * kernel * channels,
        statistics: vec![],
        then: None,
    }))
}

/// Returns where the sums of a filter start, as if bytes were numbers from -128 on, and the largest one whatever the bytes.
fn sums<'w>(bias: i32, input: ByteScale, weights: impl Iterator<Item = &'w i8>) -> (i32, i64) {
    let (mut sum, mut most) = (0i64, 0i64);
    for w in weights {
        sum += i64::from(*w);
        most += 128 * i64::from(w.unsigned_abs());
    }
    let begin = i64::from(bias) - (i64::from(input.zero) - 128) * sum;
    (begin as i32, begin.abs() + most)
}

/// Returns the largest sum, which has to fit 31 bits.
fn whole(reach: i64) -> Result<i32, String> {
    if reach < 1 << 30 {
        Ok(reach as i32)
    } else {
        Err(format!("its sums reach {reach}; 2³⁰ is the most"))
    }
}

fn depthwise(conv: &PlannedConv, from: &[Row], to: &Row) -> Result<Work, String> {
    let input = bytes(&from[0])?;
    let Taps { kernel, first, step, apart } = Taps::new(&conv.window, conv.dilation, &from[0]);
    let (mut start, mut reach) = (vec![], 0i64);
    for channel in 0..to.channels {
        let of_channel = conv.weight.iter().skip(channel).step_by(to.channels);
        let (begin, most) = sums(conv.bias[channel], input, of_channel);
        reach = reach.max(most);
        start.push(begin);
    }
    Ok(Work::Depthwise(Depthwise {
        weight: conv.weight.clone(),
        start,
        factor: conv.unit.iter().map(|unit| output(to).factor(*unit)).collect(),
        first,
        step,
        taps: kernel,
        apart,
        ending: output(to).ending(conv.rectifier),
        reach: whole(reach)?,
        macs: to.positions * to.channels * kernel,
    }))
}
