//! Test samples that are worth a look, with what networks see of them and say about them.

use std::collections::BTreeSet;
use std::sync::Arc;

use ndarray::Axis;
use taxel_data::{Attribute, Task};
use taxel_learn::metrics::Outcome;
use taxel_learn::{Card, FoldRecord};
use taxel_report::numbers::digits;

use crate::case::Case;
use crate::error::Result;
use crate::measure::pictures::{picture_of, reading};
use crate::values::{Example, Primary, Verdict};

/// Examples of a report.
const MOST: usize = 6;

/// A network's first fold: what it said, and how it reads.
type FirstFold<'a> = (&'a FoldRecord, Arc<Card>);

/// Returns some test samples of the first fold: those that divide the networks most, and one that all get right; of
/// values one that all come near to.
///
/// # Errors
/// Damaged models.
pub(super) fn examples(case: &Case) -> Result<Vec<Example>> {
    let mut records: Vec<&FoldRecord> =
        case.compared().into_iter().filter_map(|name| case.first_repetition(name).next()).collect();
    let Some(index) = records.first().map(|record| record.index.clone()) else { return Ok(vec![]) };
    records.retain(|record| record.index == index);
    let order = match case.task() {
        Task::Values(_) => by_distance(case.task(), &records),
        Task::Classes(_) | Task::Levels(_) => by_votes(case, &records, index.len()),
    };
    let mut chosen: Vec<usize> = vec![];
    let (strata, mut classes) = (case.dataset.strata(), BTreeSet::new());
    for &at in &order.divided {
        if chosen.len() + 1 < MOST && classes.insert(strata[index[at]]) {
            chosen.push(at);
        }
    }
    chosen.extend(order.agreed.iter().find(|at| !chosen.contains(at)));
    let seen: Vec<FirstFold> =
        records.into_iter().map(|record| Ok((record, case.card(&record.key)?))).collect::<Result<_>>()?;
    chosen.into_iter().map(|at| example(case, &seen, index[at], at)).collect()
}

/// Numbers of test samples.
struct Order {
    /// Those that divide the networks most first.
    divided: Vec<usize>,
    /// Those that all get right; of values those that all come near to, the nearest first.
    agreed: Vec<usize>,
}

/// Orders `count` samples by how many networks get them right.
fn by_votes(case: &Case, records: &[&FoldRecord], count: usize) -> Order {
    let width = case.levels().sizes().len();
    let votes = |at: usize| records.iter().filter(|record| right(record, at, width)).count();
    // Nearest to half right first; of equals the first of the data set.
    let mut divided: Vec<usize> = (0..count).collect();
    divided.sort_by_key(|&at| (2 * votes(at)).abs_diff(records.len()));
    let agreed = divided.iter().rev().copied().filter(|&at| votes(at) == records.len()).collect();
    Order { divided, agreed }
}

/// Orders samples of values by how far the networks lie apart in what they are off by.
fn by_distance(task: &Task, records: &[&FoldRecord]) -> Order {
    let metric = Primary::of(task).metric();
    let each: Vec<Vec<f64>> =
        records.iter().filter_map(|record| metric.terms(task, &record.outcome)).collect();
    let of = |at: usize| each.iter().filter_map(move |terms| terms.get(at).copied());
    let least = |at: usize| of(at).fold(f64::INFINITY, f64::min);
    let most = |at: usize| of(at).fold(f64::NEG_INFINITY, f64::max);
    let apart = |at: usize| most(at) - least(at);
    let mut divided: Vec<usize> = (0..each.first().map_or(0, Vec::len)).collect();
    let mut agreed = divided.clone();
    divided.sort_by(|&a, &b| apart(b).total_cmp(&apart(a)));
    agreed.sort_by(|&a, &b| most(a).total_cmp(&most(b)));
    Order { divided, agreed }
}

/// Checks whether every label of the test sample number `at` is right.
fn right(record: &FoldRecord, at: usize, width: usize) -> bool {
    let (places, (truth, predicted)) = (at * width..(at + 1) * width, record.outcome.labels());
    truth[places.clone()] == predicted[places]
}

/// Returns the sample `row` of the data set, number `at` of the test part.
fn example(case: &Case, seen: &[FirstFold], row: usize, at: usize) -> Result<Example> {
    let dataset = &case.dataset;
    let x = dataset.x.select(Axis(0), &[row]);
    let mut pictures = vec![reading(x.index_axis(Axis(0), 0), dataset.spec.layout)];
    let mut drawn = BTreeSet::new();
    for (_, card) in seen.iter().filter(|(_, card)| card.graph().is_some()) {
        for input in &card.inputs {
            if drawn.insert(&input.name) {
                let encoded = input.transform.apply(&x, &card.name)?;
                pictures.extend(picture_of(&input.name, encoded.index_axis(Axis(0), 0)));
            }
        }
    }
    Ok(Example {
        origin: dataset.origins[row].clone(),
        truth: truth(case, row),
        pictures,
        verdicts: seen.iter().map(|(record, _)| verdict(case.task(), record, at)).collect(),
    })
}

/// Returns the true target of the sample `row` of the data set.
fn truth(case: &Case, row: usize) -> String {
    match Outcome::new(&case.dataset.targets, &[row], vec![0.0; case.task().outputs()]) {
        Outcome::Labels { truth, .. } => named(&case.task().attributes(), &truth),
        Outcome::Values { truth, .. } => valued(case.task(), &truth),
    }
}

fn verdict(task: &Task, record: &FoldRecord, at: usize) -> Verdict {
    let (network, attributes) = (record.key.network.clone(), task.attributes());
    let (width, outputs) = (attributes.len(), task.outputs());
    let (predicted, probabilities) = match &record.outcome {
        Outcome::Labels { predicted, probabilities, .. } => (predicted, probabilities),
        Outcome::Values { predicted, .. } => {
            let predicted = valued(task, &predicted[at * outputs..(at + 1) * outputs]);
            return Verdict { network, predicted, probability: None, right: None };
        }
    };
    let predicted = &predicted[at * width..(at + 1) * width];
    let mut first = at * outputs;
    let mut least = 1.0f64;
    for (&label, attribute) in predicted.iter().zip(&attributes) {
        least = least.min(f64::from(probabilities[first + label as usize]));
        first += attribute.classes.len();
    }
    Verdict {
        network,
        predicted: named(&attributes, predicted),
        probability: Some(least),
        right: Some(right(record, at, width)),
    }
}

/// Returns values in words: `1.25 N`, or `force 1.25 N, depth 0.310 mm`.
fn valued(task: &Task, values: &[f32]) -> String {
    let quantities = task.quantities();
    let one = |(quantity, &value): (&taxel_data::Quantity, &f32)| {
        let name = Some(quantity.name.clone()).filter(|_| quantities.len() > 1);
        let parts = [name, Some(digits(f64::from(value))), quantity.unit.clone()];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" ")
    };
    quantities.iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
}

/// Returns labels in words: `shore-10`, or `elasticity:3, hardness:7`.
fn named(attributes: &[Attribute], labels: &[u32]) -> String {
    let name = |(attribute, &label): (&Attribute, &u32)| {
        let class = &attribute.classes[label as usize];
        if attributes.len() > 1 { format!("{}:{class}", attribute.name) } else { class.clone() }
    };
    attributes.iter().zip(labels).map(name).collect::<Vec<_>>().join(", ")
}
