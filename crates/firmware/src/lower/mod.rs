//! From the runtime's steps to layers of C, or a refusal that says which layer cannot become one.

use taxel_kernels::Rectifier;
use taxel_kernels::frozen::bytes::{Add, ByteOutput, Ending, Map, Mean};
use taxel_kernels::frozen::{Pooling, Reach};
use taxel_runtime::{Blueprint, PlannedOp, PlannedStep};

use crate::floats::layer::FloatWork;
use crate::floats::lower::float_work;
use crate::layer::{Layer, Memory, Row, Span, Stage, Windows, Work};

mod conv;
mod places;

use conv::{convolution, depthwise};
use places::Places;

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

/// Lowers a network that reads samples of `channels` × `steps`; the steps of an image are its pixels.
///
/// # Errors
/// The reason, where a step has no C of the same bits.
pub(crate) fn lower(blueprint: &Blueprint, sample: [usize; 2]) -> Result<Network, String> {
    if blueprint.inputs.len() != 1 || blueprint.outputs.len() != 1 {
        let (inputs, outputs) = (blueprint.inputs.len(), blueprint.outputs.len());
        return Err(format!("it has {inputs} inputs and {outputs} outputs; one of each can be exported"));
    }
    let steps = &blueprint.steps;
    let Places { rows, memories } = Places::new(blueprint)?;
    let in_floats = blueprint.in_floats;
    let mut lower = Lower { steps, in_floats, rows, memories, layers: vec![], sample };
    for id in 0..steps.len() {
        lower.step(id).map_err(|reason| format!("layer `{}`: {reason}", name_of(steps, id)))?;
    }
    let logits = lower.rows[blueprint.outputs[0].1];
    if logits.len() != 1 || logits.scale.is_some() {
        return Err(format!("its output has {} positions; logits of classes are needed", logits.len()));
    }
    Ok(Network { logits, layers: lower.layers, memories: lower.memories })
}

/// Returns the name of a step, or of the nearest one before it that has one.
fn name_of(steps: &[PlannedStep], id: usize) -> &str {
    steps[..=id].iter().rev().map(|step| step.name.as_str()).find(|name| !name.is_empty()).unwrap_or("input")
}

struct Lower<'a> {
    steps: &'a [PlannedStep],
    in_floats: bool,
    rows: Vec<Row>,
    memories: Vec<Memory>,
    layers: Vec<Layer>,
    /// Channels and time steps of a sample; of an image channels and pixels.
    sample: [usize; 2],
}

impl Lower<'_> {
    fn step(&mut self, id: usize) -> Result<(), String> {
        let step = &self.steps[id];
        let (from, to) = (self.inputs(id), self.rows[id]);
        if let Some(work) = float_work(&step.op, self.in_floats, &from, &to, self.memories.len())? {
            if let Work::Floats(FloatWork::Lstm(lstm)) = &work {
                self.memories.push(Memory::of_floats(5 * lstm.hidden));
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
            PlannedOp::Pool { pooling, axes } => pool(*pooling, axes, &from[0], &to)?,
            PlannedOp::Deviation(eps) if from[0].scale.is_none() && from[0].line().is_some() => {
                Work::Deviation { share: 1.0 / from[0].len() as f32, eps: *eps }
            }
            PlannedOp::Shuffle(groups) if to.scale.is_some() => Work::Shuffle(*groups),
            PlannedOp::Flatten if to.scale.is_none() && from[0].line().is_some() => Work::Flatten,
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
        (self.rows[id].channels, self.rows[id].len()) == (channels, steps)
    }

    fn input(&mut self, id: usize) -> Result<(), String> {
        if self.is_staged(id) {
            return Ok(());
        }
        let to = self.rows[id];
        let ending = ByteOutput::Floats.ending(Rectifier::None);
        let work = Work::Stage(self.staged(&to, None, ending)?);
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
        let Work::Map { mut factors, mut shifts, ending } = map(&self.inputs(id)[0], &to, affine, rectifier)
        else {
            return Err(OTHER_FORM.into());
        };
        if !self.keeps_channels(id) {
            factors = vec![factors[0]; self.sample[0]];
            shifts = vec![shifts[0]; self.sample[0]];
        }
        let work = Work::Stage(self.staged(&to, Some((factors, shifts)), ending)?);
        self.push(id, work, vec![], to);
        Ok(())
    }

    /// Returns how a sample comes into `to`: how far neighbouring channels and time steps are from each other there.
    fn staged(
        &self,
        to: &Row,
        scales: Option<(Vec<f32>, Vec<f32>)>,
        ending: Ending,
    ) -> Result<Stage, String> {
        let [channels, steps] = self.sample;
        let size = if to.rows == 1 {
            format!("{}×{}", to.channels, to.positions)
        } else {
            format!("{}×{}×{}", to.channels, to.rows, to.positions)
        };
        if channels * steps != to.channels * to.len() {
            return Err(format!(
                "it reads {size} values, a sample has {channels}×{steps}; the encoding between them cannot be exported"
            ));
        }
        let (by_channel, by_step) = if to.len() == steps {
            (1, to.pitch)
        } else if to.len() == 1 {
            (steps, 1)
        } else if to.channels == 1 && to.rows == 1 {
            (steps * to.pitch, to.pitch)
        } else if to.channels == 1 && to.positions == steps {
            (to.row_pitch, to.pitch)
        } else {
            return Err(format!("it reads samples of {channels}×{steps} as {size}"));
        };
        let has_gaps = to.len() == steps && to.line().is_none();
        let by_row = has_gaps.then_some([to.positions, to.row_pitch]);
        Ok(Stage { by_channel, by_step, by_row, scales, ending })
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

fn pool(
    pooling: Pooling,
    [_, of_rows, of_columns]: &[Vec<Reach>; 3],
    from: &Row,
    to: &Row,
) -> Result<Work, String> {
    if of_rows.iter().chain(of_columns).any(|reach| reach.from >= reach.to) {
        return Err("a window of it lies outside of its input".into());
    }
    let spans =
        |reaches: &[Reach]| -> Vec<Span> { reaches.iter().map(|reach| [reach.from, reach.to]).collect() };
    let windows = Windows { rows: spans(of_rows), columns: spans(of_columns) };
    // Of every output: values that its mean counts, and those that lie inside.
    let counts = of_rows.iter().flat_map(|row| {
        let of_row =
            |column: &Reach| (row.count * column.count, (row.to - row.from) * (column.to - column.from));
        of_columns.iter().map(of_row).collect::<Vec<_>>()
    });
    match (pooling, from.scale) {
        (Pooling::Max, _) if from.scale == to.scale => Ok(Work::Most(windows)),
        (Pooling::Max, _) => Err(OTHER_FORM.into()),
        (Pooling::Mean, Some(scale)) => {
            let one = |(count, inside)| Mean::coefficients(scale, output(to), count, inside);
            let scales = counts.map(one).collect();
            Ok(Work::Mean { windows, scales, ending: output(to).ending(Rectifier::None) })
        }
        (Pooling::Mean, None) if to.scale.is_none() => {
            let shares = counts.map(|(count, _)| 1.0 / count as f32).collect();
            Ok(Work::MeanFloats { windows, shares })
        }
        (Pooling::Mean, None) => Err(OTHER_FORM.into()),
    }
}
