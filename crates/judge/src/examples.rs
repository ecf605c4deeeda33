//! Test samples that are worth a look, with what networks see of them and say about them.

use std::collections::BTreeSet;

use ndarray::{ArrayD, ArrayViewD, Axis};
use taxel_scenes::faults::Layout;
use taxel_trainer::FoldRecord;

use crate::case::Case;
use crate::error::Result;
use crate::judgement::{Example, Picture, PictureKind, Verdict};

/// Examples of a report.
const MOST: usize = 6;
/// Frames shown of a sequence.
const FRAMES: usize = 5;
/// Readings shown of a line; longer ones are thinned out.
const READINGS: usize = 400;

/// Some test samples of the first fold: those that divide the networks most, and one that all get right.
///
/// # Errors
/// Damaged records or models.
pub(crate) fn examples(case: &Case) -> Result<Vec<Example>> {
    let mut records: Vec<FoldRecord> = vec![];
    for name in case.contestants() {
        records.extend(case.first_repetition(name)?.into_iter().take(1));
    }
    let Some(index) = records.first().map(|record| record.index.clone()) else { return Ok(vec![]) };
    records.retain(|record| record.index == index);
    let width = case.levels().sizes().len().max(1);
    let right = |record: &FoldRecord, at: usize| {
        record.truth[at * width..(at + 1) * width] == record.predicted[at * width..(at + 1) * width]
    };
    let votes = |at: usize| records.iter().filter(|record| right(record, at)).count();
    // Nearest to half right first; of equals the first of the data set.
    let mut order: Vec<usize> = (0..index.len()).collect();
    order.sort_by_key(|&at| (2 * votes(at)).abs_diff(records.len()));
    let mut chosen: Vec<usize> = vec![];
    let mut classes = BTreeSet::new();
    for &at in &order {
        if chosen.len() + 1 < MOST && classes.insert(case.samples.y[index[at]]) {
            chosen.push(at);
        }
    }
    chosen.extend(order.iter().rev().find(|at| votes(**at) == records.len() && !chosen.contains(at)));
    chosen.into_iter().map(|at| example(case, &records, index[at], at)).collect()
}

fn example(case: &Case, records: &[FoldRecord], row: usize, at: usize) -> Result<Example> {
    let x = case.samples.x.select(Axis(0), &[row]);
    let (sensor, _) = case.sensor();
    let mut pictures = vec![reading(x.index_axis(Axis(0), 0), sensor.layout)];
    let mut seen = BTreeSet::new();
    let mut verdicts = vec![];
    for record in records {
        let model = case.predictor(&record.key, 1, 1)?;
        if model.graph().is_some() {
            let names: Vec<String> = model.inputs().map(String::from).collect();
            let inputs = model.encode(&x, &case.samples.source)?;
            for (name, input) in names.into_iter().zip(inputs) {
                if seen.insert(name.clone()) {
                    pictures.extend(encoded(name, input.index_axis(Axis(0), 0)));
                }
            }
        }
        verdicts.push(verdict(case, record, at));
    }
    let labels = case.samples.labels.of(&[row]);
    let (origin, truth) = (case.samples.origins[row].clone(), named(case, &labels));
    Ok(Example { origin, truth, pictures, verdicts })
}

fn verdict(case: &Case, record: &FoldRecord, at: usize) -> Verdict {
    let levels = case.levels();
    let (width, outputs) = (levels.sizes().len().max(1), levels.outputs());
    let own = &record.predicted[at * width..(at + 1) * width];
    let mut first = at * outputs;
    let mut least = 1.0f64;
    for (&label, &size) in own.iter().zip(levels.sizes()) {
        least = least.min(f64::from(record.probabilities[first + label as usize]));
        first += size;
    }
    Verdict {
        network: record.key.network.clone(),
        predicted: named(case, own),
        probability: least,
        right: *own == record.truth[at * width..(at + 1) * width],
    }
}

/// `shore-10`, or `elasticity:3, hardness:7`.
fn named(case: &Case, labels: &[u32]) -> String {
    let attributes = case.samples.labels.attributes();
    let name = |(attribute, &label): (&taxel_trainer::Attribute, &u32)| {
        let class = attribute.classes.get(label as usize).map_or("?", String::as_str);
        if attributes.len() > 1 { format!("{}:{class}", attribute.name) } else { class.to_string() }
    };
    attributes.iter().zip(labels).map(name).collect::<Vec<_>>().join(", ")
}

fn reading(x: ArrayViewD<f32>, layout: Layout) -> Picture {
    let x = if x.ndim() == 1 { x.insert_axis(Axis(0)) } else { x };
    match layout {
        Layout::Series => picture("reading", PictureKind::Lines, thinned(x)),
        Layout::Image => picture("reading", PictureKind::Grey, x.to_owned()),
        Layout::Colour => picture("reading", PictureKind::Colour, x.to_owned()),
        Layout::Sequence => picture("reading", PictureKind::Frames, spread(x, 0)),
        Layout::Fingers => picture("reading", PictureKind::Frames, x.to_owned()),
    }
}

/// A picture of an encoded input; none for shapes that nobody can look at.
fn encoded(name: String, x: ArrayViewD<f32>) -> Option<Picture> {
    let kind = match x.shape() {
        [_, _] => return Some(picture(&name, PictureKind::Lines, thinned(x))),
        [1, _, _] => {
            return Some(picture(&name, PictureKind::Grey, x.index_axis_move(Axis(0), 0).to_owned()));
        }
        [3, _, _] => PictureKind::Colour,
        [_, _, _] => PictureKind::Frames,
        // [C, H, W, T]
        [1, _, _, _] => {
            let frames = spread(x.index_axis_move(Axis(0), 0), 2).permuted_axes(vec![2, 0, 1]);
            return Some(picture(&name, PictureKind::Frames, frames));
        }
        _ => return None,
    };
    Some(picture(&name, kind, x.to_owned()))
}

fn picture(name: &str, kind: PictureKind, x: ArrayD<f32>) -> Picture {
    Picture { name: name.into(), kind, shape: x.shape().to_vec(), values: x.iter().copied().collect() }
}

/// A few entries along `axis`, from the first to the last.
fn spread(x: ArrayViewD<f32>, axis: usize) -> ArrayD<f32> {
    let (axis, all) = (Axis(axis), x.len_of(Axis(axis)));
    let count = FRAMES.min(all);
    let at = |i: usize| if count > 1 { i * (all - 1) / (count - 1) } else { 0 };
    x.select(axis, &(0..count).map(at).collect::<Vec<_>>())
}

fn thinned(x: ArrayViewD<f32>) -> ArrayD<f32> {
    let axis = Axis(x.ndim() - 1);
    let every = x.len_of(axis).div_ceil(READINGS).max(1);
    x.select(axis, &(0..x.len_of(axis)).step_by(every).collect::<Vec<_>>())
}
