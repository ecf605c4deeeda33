//! Opens a model by the kind that its card says.

use std::ops::Range;
use std::path::Path;

use taxel_engine::Precision;
use taxel_graph::Weights;
use taxel_runtime::Frozen;

use super::card::Card;
use super::kind::ModelKind;
use super::members::{Member, members};
use super::ready::Ready;
use super::responder::Responder;
use super::workspace::ModelMemory;
use crate::error::{Error, Result};
use crate::estimator::baseline::FittedBaseline;

/// Opens the method of a card with its tensors, to predict up to `batch` samples at a time on each of `threads` threads.
///
/// # Errors
/// Tensors that do not fit the card, products that the processor lacks, threads that cannot be started.
pub(crate) fn open(card: &Card, weights: &Weights, batch: usize, threads: usize) -> Result<Box<dyn Ready>> {
    match &card.kind {
        ModelKind::Network { graph, loss, .. } => {
            let frozen = match (&card.quantized, card.precision) {
                (Some(quantized), _) => Frozen::quantized(graph, weights, &quantized.ranges)?,
                (None, Precision::Bf16) => Frozen::half(graph, weights)?,
                (None, Precision::F32) => Frozen::new(graph, weights)?,
            };
            let network = Responder::new(frozen, batch, threads)?;
            let has_labels = card.value_loss().is_none();
            Ok(Box::new(if has_labels { network.of_labels(*loss, card.levels()) } else { network }))
        }
        ModelKind::Baseline { method, series } => {
            let fitted = FittedBaseline::read(*method, *series, &card.task, weights);
            let refuse = |source| Error::Baseline { baseline: card.name.clone(), source };
            Ok(Box::new(ReadyBaseline { fitted: fitted.map_err(refuse)?, name: card.name.clone() }))
        }
        ModelKind::Average { .. } => {
            let members =
                members(card, weights).map_err(|reason| Error::damaged(Path::new(&card.name), reason))?;
            let open = |member: Member| -> Result<ReadyMember> {
                let (card, inputs) = (member.card, member.inputs);
                Ok(ReadyMember {
                    ready: open(&card, &member.weights, batch, threads)?,
                    inputs,
                    width: card.width(),
                })
            };
            let members = members.into_iter().map(open).collect::<Result<_>>()?;
            Ok(Box::new(ReadyAverage { members, outputs: card.task.outputs() }))
        }
    }
}

struct ReadyBaseline {
    fitted: FittedBaseline,
    name: String,
}

impl Ready for ReadyBaseline {
    fn memory(&self) -> ModelMemory {
        ModelMemory::Baseline(self.fitted.workspaces())
    }

    fn decide_one(&self, inputs: &[Vec<f32>], memory: &mut ModelMemory, logits: &mut [f32]) -> Result<bool> {
        let (ModelMemory::Baseline(memory), [series]) = (memory, inputs) else { return Ok(false) };
        self.fitted.decide_one(series, memory, logits)?;
        Ok(true)
    }

    fn finish(&self, logits: &mut [f32]) {
        self.fitted.soften(logits);
    }

    fn has_logits(&self) -> bool {
        self.fitted.has_decisions()
    }

    fn decide(&self, inputs: &[&[f32]], _n: usize) -> Result<Vec<f32>> {
        match inputs {
            [series] => self.fitted.decide(series),
            _ => {
                let (model, expected) = (self.name.clone(), "one input".to_string());
                Err(Error::Samples { model, expected, given: format!("{} are given", inputs.len()) })
            }
        }
    }
}

struct ReadyMember {
    ready: Box<dyn Ready>,
    /// Which inputs of the model are its own.
    inputs: Range<usize>,
    /// Values that it computes for one sample.
    width: usize,
}

/// The mean of what members predict: of probabilities, or of values.
struct ReadyAverage {
    members: Vec<ReadyMember>,
    outputs: usize,
}

impl Ready for ReadyAverage {
    fn memory(&self) -> ModelMemory {
        let each = |member: &ReadyMember| (member.ready.memory(), vec![0.0; member.width]);
        ModelMemory::Average(self.members.iter().map(each).collect())
    }

    fn decide_one(&self, inputs: &[Vec<f32>], memory: &mut ModelMemory, logits: &mut [f32]) -> Result<bool> {
        let ModelMemory::Average(memories) = memory else { return Ok(false) };
        if memories.len() != self.members.len() || logits.len() != self.outputs {
            return Ok(false);
        }
        logits.fill(0.0);
        for (member, (memory, own)) in self.members.iter().zip(memories) {
            let Some(inputs) = inputs.get(member.inputs.clone()) else { return Ok(false) };
            if own.len() != member.width || !member.ready.decide_one(inputs, memory, own)? {
                return Ok(false);
            }
            let answers = &mut own[..self.outputs];
            member.ready.finish(answers);
            logits.iter_mut().zip(answers).for_each(|(sum, answer)| *sum += *answer);
        }
        logits.iter_mut().for_each(|sum| *sum /= self.members.len() as f32);
        Ok(true)
    }

    fn decide(&self, inputs: &[&[f32]], n: usize) -> Result<Vec<f32>> {
        let mut sums = vec![0.0; n * self.outputs];
        for member in &self.members {
            let own = inputs.get(member.inputs.clone()).unwrap_or_default();
            let decided = member.ready.decide(own, n)?;
            let rows = decided.chunks_exact(member.width).flat_map(|row| &row[..self.outputs]);
            let mut answers: Vec<f32> = rows.copied().collect();
            member.ready.finish(&mut answers);
            sums.iter_mut().zip(answers).for_each(|(sum, answer)| *sum += answer);
        }
        sums.iter_mut().for_each(|sum| *sum /= self.members.len() as f32);
        Ok(sums)
    }

    fn finish(&self, _logits: &mut [f32]) {}

    fn has_logits(&self) -> bool {
        false
    }
}
