//! Test samples that are worth a look, with what networks see of them and say about them.

use std::collections::BTreeSet;
use std::sync::Arc;

use ndarray::Axis;
use taxel_data::Attribute;
use taxel_learn::{Card, FoldRecord};

use crate::case::Case;
use crate::error::Result;
use crate::measure::pictures::{picture_of, reading};
use crate::values::{Example, Verdict};

/// Examples of a report.
const MOST: usize = 6;

/// A network's first fold: what it said, and how it reads.
type Seen<'a> = (&'a FoldRecord, Arc<Card>);

/// Some test samples of the first fold: those that divide the networks most, and one that all get right.
///
/// # Errors
/// Damaged models.
pub(super) fn examples(case: &Case) -> Result<Vec<Example>> {
    let mut records: Vec<&FoldRecord> =
        case.compared().into_iter().filter_map(|name| case.first_repetition(name).next()).collect();
    let Some(index) = records.first().map(|record| record.index.clone()) else { return Ok(vec![]) };
    records.retain(|record| record.index == index);
    let width = case.levels().sizes().len();
    let votes = |at: usize| records.iter().filter(|record| right(record, at, width)).count();
    // Nearest to half right first; of equals the first of the data set.
    let mut order: Vec<usize> = (0..index.len()).collect();
    order.sort_by_key(|&at| (2 * votes(at)).abs_diff(records.len()));
    let mut chosen: Vec<usize> = vec![];
    let (strata, mut classes) = (case.dataset.strata(), BTreeSet::new());
    for &at in &order {
        if chosen.len() + 1 < MOST && classes.insert(strata[index[at]]) {
            chosen.push(at);
        }
    }
    chosen.extend(order.iter().rev().find(|at| votes(**at) == records.len() && !chosen.contains(at)));
    let seen: Vec<Seen> =
        records.into_iter().map(|record| Ok((record, case.card(&record.key)?))).collect::<Result<_>>()?;
    chosen.into_iter().map(|at| example(case, &seen, index[at], at)).collect()
}

/// Whether every label of the test sample number `at` is right.
fn right(record: &FoldRecord, at: usize, width: usize) -> bool {
    let own = at * width..(at + 1) * width;
    record.outcome.labels().0[own.clone()] == record.outcome.labels().1[own]
}

/// The sample `row` of the data set, number `at` of the test part.
fn example(case: &Case, seen: &[Seen], row: usize, at: usize) -> Result<Example> {
    let dataset = &case.dataset;
    let x = dataset.x.select(Axis(0), &[row]);
    let mut pictures = vec![reading(x.index_axis(Axis(0), 0), dataset.reading.layout)];
    let mut drawn = BTreeSet::new();
    for (_, card) in seen.iter().filter(|(_, card)| card.graph().is_some()) {
        for input in &card.inputs {
            if drawn.insert(&input.name) {
                let encoded = input.transform.apply(&x, &card.name)?;
                pictures.extend(picture_of(&input.name, encoded.index_axis(Axis(0), 0)));
            }
        }
    }
    let attributes = dataset.labels()?.attributes();
    Ok(Example {
        origin: dataset.origins[row].clone(),
        truth: named(attributes, &dataset.labels()?.of(&[row])),
        pictures,
        verdicts: seen.iter().map(|(record, _)| verdict(attributes, record, at)).collect(),
    })
}

fn verdict(attributes: &[Attribute], record: &FoldRecord, at: usize) -> Verdict {
    let width = attributes.len();
    let outputs: usize = attributes.iter().map(|own| own.classes.len()).sum();
    let predicted = &record.outcome.labels().1[at * width..(at + 1) * width];
    let mut first = at * outputs;
    let mut least = 1.0f64;
    for (&label, attribute) in predicted.iter().zip(attributes) {
        least = least.min(f64::from(record.outcome.outputs()[first + label as usize]));
        first += attribute.classes.len();
    }
    Verdict {
        network: record.key.network.clone(),
        predicted: named(attributes, predicted),
        probability: least,
        right: right(record, at, width),
    }
}

/// `shore-10`, or `elasticity:3, hardness:7`.
fn named(attributes: &[Attribute], labels: &[u32]) -> String {
    let name = |(attribute, &label): (&Attribute, &u32)| {
        let class = &attribute.classes[label as usize];
        if attributes.len() > 1 { format!("{}:{class}", attribute.name) } else { class.clone() }
    };
    attributes.iter().zip(labels).map(name).collect::<Vec<_>>().join(", ")
}
