//! Certainty and intervals of a model of all samples from its answers to each as if that had not been learned, where these cost no
//! training.

use taxel_data::Task;

use crate::certainty::{Certainty, HeldOut, HeldOutParts, HeldOutValues, Intervals};
use crate::error::Result;
use crate::estimator::estimator::{Fitted, TrainingSet};
use crate::metrics::{Levels, softmax};
use crate::model::Model;
use crate::run::protocol::Protocol;

/// Returns the model with the certainty, or the intervals, that follow from what it says of samples that are left out.
///
/// # Errors
/// Samples that the method refuses.
pub(crate) fn with_left_out(
    model: Model,
    (protocol, seed): (&Protocol, u64),
    set: &TrainingSet,
    fitted: &dyn Fitted,
) -> Result<Model> {
    let Some(answers) = fitted.left_out(set)? else { return Ok(model) };
    let parts = HeldOutParts::of(protocol);
    Ok(match set.dataset.task() {
        Task::Values(_) => model.with_intervals(intervals(answers, parts, set)),
        Task::Classes(_) | Task::Levels(_) => model.with_certainty(certainty(answers, parts, seed, set)?),
    })
}

/// Returns the group of each training sample; none without groups.
fn groups(set: &TrainingSet) -> Option<Vec<u32>> {
    let rows = &set.fold.train;
    set.dataset.groups.as_ref().map(|groups| rows.iter().map(|row| groups[*row]).collect())
}

fn certainty(
    logits: Vec<f32>,
    parts: HeldOutParts,
    seed: u64,
    set: &TrainingSet,
) -> Result<Option<Certainty>> {
    let (dataset, rows) = (set.dataset, &set.fold.train);
    let levels = Levels::of_task(&dataset.task());
    let mut probabilities = logits.clone();
    softmax(&mut probabilities, levels.outputs());
    let held = HeldOut {
        probabilities,
        logits,
        truth: dataset.targets.labels().map_or(vec![], |labels| labels.of(rows)),
        parts: vec![0; rows.len()],
        rows: rows.clone(),
        groups: groups(set),
        ..HeldOut::default()
    };
    let certainty = Certainty::fit(&held, &levels, parts, &dataset.digest, seed)?;
    let fit = |certainty: Certainty| {
        certainty.with_logits(&held, &[], &levels).with_readings(
            &held,
            (dataset.spec.layout, &dataset.x),
            &levels,
        )
    };
    Ok(certainty.map(fit))
}

fn intervals(predicted: Vec<f32>, parts: HeldOutParts, set: &TrainingSet) -> Option<Intervals> {
    let (values, rows) = (set.dataset.targets.values()?, &set.fold.train);
    let groups = groups(set);
    let held = HeldOutValues {
        quantities: values.quantities().len(),
        truth: values.of(rows),
        predicted,
        spread: vec![],
        parts: groups.clone().unwrap_or_else(|| vec![0; rows.len()]),
        rows: rows.clone(),
        groups,
    };
    let raw = (set.dataset.spec.layout, &*set.dataset.x);
    Intervals::fit(&held, parts, &set.dataset.digest).map(|intervals| intervals.with_readings(&held, raw))
}
