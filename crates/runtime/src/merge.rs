//! Convolutions of one input that are too narrow to fill a vector are computed together.

use std::mem;

use crate::step::{Algorithm, Conv, FrozenStep, StepId, StepOp, ValueShape};

/// Filters up to which a convolution leaves most of a vector empty.
const NARROW: usize = 8;

/// Joins a narrow convolution with one that sees the same input through the same window; both become slices of what
/// they compute together. Gives the new steps, and the new number of every old one.
pub(crate) fn merge(steps: Vec<FrozenStep>) -> (Vec<FrozenStep>, Vec<StepId>) {
    let partners = partners(&steps);
    let mut names = vec![String::new(); steps.len()];
    let mut steps: Vec<Option<FrozenStep>> = steps.into_iter().map(Some).collect();
    let (mut merged, mut now): (Vec<FrozenStep>, Vec<StepId>) = (vec![], vec![]);
    for id in 0..steps.len() {
        let step = match (steps[id].take(), partners[id]) {
            (Some(first), Some(partner)) => {
                let (shape, name) = (first.shape, first.name.clone());
                let second = steps[partner].take();
                names[partner] = second.as_ref().map_or(String::new(), |second| second.name.clone());
                merged.push(join(first, second).renumbered(&now));
                FrozenStep { name, ..FrozenStep::new(StepOp::Slice(0), vec![merged.len() - 1], shape) }
            }
            (Some(step), None) => step.renumbered(&now),
            (None, first) => {
                let rest = slice_of_rest(&merged, now[first.unwrap_or(id)]);
                FrozenStep { name: mem::take(&mut names[id]), ..rest }
            }
        };
        merged.push(step);
        now.push(merged.len() - 1);
    }
    (merged, now)
}

/// Returns the step that replaces the second of two convolutions: the rest of the value whose first slice the first one
/// is.
fn slice_of_rest(merged: &[FrozenStep], first: StepId) -> FrozenStep {
    let slice = &merged[first];
    let whole = slice.inputs[0];
    let (channels, all) = (slice.shape.channels, merged[whole].shape);
    let shape = ValueShape { channels: all.channels - channels, ..all };
    FrozenStep::new(StepOp::Slice(channels), vec![whole], shape)
}

/// Returns for every step the other convolution that it is computed with.
fn partners(steps: &[FrozenStep]) -> Vec<Option<StepId>> {
    let mut partners = vec![None; steps.len()];
    for later in 0..steps.len() {
        let fits =
            |&earlier: &StepId| partners[earlier].is_none() && are_siblings(&steps[earlier], &steps[later]);
        if let Some(earlier) = (0..later).find(fits) {
            (partners[earlier], partners[later]) = (Some(later), Some(earlier));
        }
    }
    partners
}

fn are_siblings(a: &FrozenStep, b: &FrozenStep) -> bool {
    let (Some(x), Some(y)) = (plain(a), plain(b)) else { return false };
    a.inputs == b.inputs
        && x.window == y.window
        && x.dilation == y.dilation
        && x.rectifier == y.rectifier
        && a.shape.channels.min(b.shape.channels) <= NARROW
}

/// Returns the convolution of a step if it has one group, the definition's products and no addend.
fn plain(step: &FrozenStep) -> Option<&Conv> {
    match &step.work {
        StepOp::Conv(conv @ Conv { algorithm: Algorithm::Direct, groups: 1, .. })
            if step.inputs.len() == 1 =>
        {
            Some(conv)
        }
        _ => None,
    }
}

/// Joins both convolutions into one, filter beside filter.
fn join(first: FrozenStep, second: Option<FrozenStep>) -> FrozenStep {
    let Some((StepOp::Conv(a), StepOp::Conv(b))) = second.as_ref().map(|second| (&first.work, &second.work))
    else {
        return first;
    };
    let (left, right) = (a.bias.len(), b.bias.len());
    let rows = a.weight.chunks_exact(left).zip(b.weight.chunks_exact(right));
    let conv = Conv {
        weight: rows.flat_map(|(a, b)| a.iter().chain(b).copied()).collect(),
        bias: [a.bias.as_slice(), &b.bias].concat(),
        window: a.window,
        dilation: a.dilation,
        groups: 1,
        rectifier: a.rectifier,
        algorithm: Algorithm::Direct,
    };
    let shape = ValueShape { channels: left + right, ..first.shape };
    FrozenStep::new(StepOp::Conv(conv), first.inputs, shape)
}
