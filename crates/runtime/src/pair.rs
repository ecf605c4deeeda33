//! Pointwise convolutions whose values are too many for the cache become one step with the depthwise one that reads them.

use crate::step::{Algorithm, Conv, FrozenStep, Pair, StepId, StepOp};

/// Bytes of values that are worth it: more than stays in the cache until it is read.
const LARGE: usize = 512 << 10;

/// Joins pairs of steps into one. Gives the new steps, and the new number of every old one but the first of a pair:
/// that number stays 0, and nobody reads it.
pub(crate) fn pair(steps: Vec<FrozenStep>, outputs: &[StepId]) -> (Vec<FrozenStep>, Vec<StepId>) {
    let mut readers = vec![0; steps.len()];
    steps.iter().flat_map(|step| &step.inputs).for_each(|&input| readers[input] += 1);
    outputs.iter().for_each(|&output| readers[output] += 1);
    let first = |second: &FrozenStep| {
        let &[input] = second.inputs.as_slice() else { return None };
        let large = size_of::<f32>() * steps[input].shape.len() > LARGE;
        (large && readers[input] == 1 && is_pointwise(&steps[input]) && has_rows(second)).then_some(input)
    };
    let firsts: Vec<Option<StepId>> = steps.iter().map(first).collect();
    let mut waiting: Vec<Option<FrozenStep>> = steps.into_iter().map(Some).collect();
    let (mut paired, mut now) = (vec![], vec![0; waiting.len()]);
    for id in 0..waiting.len() {
        if firsts.contains(&Some(id)) {
            continue;
        }
        let Some(mut step) = waiting[id].take() else { continue };
        if let Some(before) = firsts[id].and_then(|first| waiting[first].take()) {
            step = join(before, step);
        }
        paired.push(step.renumbered(&now));
        now[id] = paired.len() - 1;
    }
    (paired, now)
}

/// Checks whether a step is a depthwise convolution of an image into an image, every row of which sees some of the
/// image.
fn has_rows(step: &FrozenStep) -> bool {
    let StepOp::Conv(Conv { algorithm: Algorithm::Depthwise, window, dilation, .. }) = &step.work else {
        return false;
    };
    let span = (window.kernel[1] - 1) * dilation[1] + 1;
    let [before, last] = [window.before[1], (window.output[1] - 1) * window.stride[1]];
    let is_flat = window.input[0] == 1 && window.output[0] == 1;
    is_flat && before < span && last < before + window.input[1]
}

fn is_pointwise(step: &FrozenStep) -> bool {
    match &step.work {
        StepOp::Conv(Conv { window, groups: 1, algorithm: Algorithm::Direct, .. }) => {
            window.is_identity() && step.inputs.len() == 1
        }
        _ => false,
    }
}

fn join(first: FrozenStep, second: FrozenStep) -> FrozenStep {
    match (first.work, second.work) {
        (StepOp::Conv(a), StepOp::Conv(b)) => {
            let work = StepOp::Pair(Box::new(Pair { first: a, second: b }));
            FrozenStep { work, inputs: first.inputs, ..second }
        }
        _ => unreachable!("both were found to be convolutions"),
    }
}
