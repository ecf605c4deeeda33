//! Tests that claims of any paper use: which network is better, closer, steadier, and what it mistakes for what.

use crate::measure::Measure;
use taxel::learn::metrics::Confusion;

use super::benchmark::{Benchmark, RunNetwork};
use super::contrast::Contrast;
use super::finding::{Finding, against_all, effects, lacks, not_worse};
use taxel::judge::Result;
use taxel::judge::statistics::{SpreadRatio, spread_ratio};
use taxel::judge::{Effect, Predicted};

/// Tests that `one` is better than each of `others`.
pub(super) fn beats(run: &Benchmark, one: &str, others: &[&str], measure: Measure) -> Result<Finding> {
    beat(run, &[one], others, measure)
}

/// Tests that each of `ones` is better than each of `others`.
pub(super) fn beat(run: &Benchmark, ones: &[&str], others: &[&str], measure: Measure) -> Result<Finding> {
    let (what, attribute) = (measure.words(), measure.attribute());
    let attributes = &run.judgement.results.task.attributes();
    let at = attribute.map(|name| attributes.iter().position(|known| known.name == name));
    if let (Some(None), Some(name)) = (at, attribute) {
        return Ok(lacks(format!("the attribute {name}")));
    }
    let at = at.flatten();
    let absent = run.absent(&[ones, others].concat());
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let levels = at.map_or(0, |at| attributes[at].classes.len());
    let value = |predictions: Predicted| match measure {
        Measure::Accuracy | Measure::Attribute(_) => Some(predictions.accuracy(at)),
        _ => measure.of_levels(&of_levels(predictions, at.unwrap_or(0), levels)),
    };
    let difference = |both: &[Predicted]| Some(value(both[0])? - value(both[1])?);
    let others: Vec<&RunNetwork> = others.iter().filter_map(|name| run.find(name)).collect();
    let of = attribute.map_or(String::new(), |name| format!(" of {name}"));
    let words = |pair: &str| format!("{what}{of}: {pair}, points");
    let mut contrasts = vec![];
    for one in ones {
        let Some(entry) = run.find(one) else { continue };
        for other in &others {
            let found = effects(run, entry, &[*other], &difference, ones.len() * others.len(), words)?;
            let gap = run.printed.gap(measure, one, &other.results().zoo);
            contrasts
                .extend(found.into_iter().map(|found| Contrast { margin: gap.or(found.margin), ..found }));
        }
    }
    Ok(against_all(0.0, contrasts))
}

/// Returns precision, recall and F1 of each level that occurs, in %.
fn of_levels(predictions: Predicted, attribute: usize, levels: usize) -> Vec<[f64; 3]> {
    let (truth, predicted): (Vec<u32>, Vec<u32>) =
        predictions.each().map(|(truth, predicted)| (truth[attribute], predicted[attribute])).unzip();
    let classes =
        Confusion::new(&truth, &predicted, levels).map_or(vec![], |confusion| confusion.per_class());
    let occurring = classes.iter().filter(|class| class.support > 0);
    occurring.map(|class| [class.precision, class.recall, class.f1].map(|share| 100.0 * share)).collect()
}

/// Tests that more than `least` % of the samples of a class are recognised by each network.
pub(super) fn recognised(run: &Benchmark, zoos: &[&str], class: &str, least: f64) -> Result<Finding> {
    let classes = &run.judgement.results.task.output_names();
    let absent = run.absent(zoos);
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let Some(label) = classes.iter().position(|known| known == class) else {
        return Ok(lacks(format!("the class {class}")));
    };
    let share = |predictions: &[Predicted]| {
        let of_class = predictions[0].each().filter(|(truth, _)| truth[0] as usize == label);
        let (all, right) = of_class.fold((0, 0), |(all, right), (truth, predicted)| {
            (all + 1, right + u32::from(truth[0] == predicted[0]))
        });
        (all > 0).then(|| 100.0 * f64::from(right) / f64::from(all))
    };
    let mut contrasts = vec![];
    for entry in zoos.iter().filter_map(|zoo| run.find(zoo)) {
        let text = format!("{class} recognised by {}, %", entry.name);
        contrasts.extend(run.contrast(text, &[&entry.name], &share, zoos.len())?);
    }
    Ok(against_all(least, contrasts))
}

/// Tests that the first of `ones` that the run has is less than `margin` points worse than each of `others`.
pub(super) fn close(run: &Benchmark, ones: &[&str], others: &[&str], margin: f64) -> Result<Finding> {
    let absent = run.absent(others);
    let Some(entry) = ones.iter().find_map(|name| run.find(name)) else {
        return Ok(lacks([&[ones[0].to_string()], absent.as_slice()].concat().join(", ")));
    };
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let baselines: Vec<&RunNetwork> = others.iter().filter_map(|name| run.find(name)).collect();
    not_worse(run, entry, &baselines, margin)
}

/// Tests that of all mistakes the one that takes the first class for the second is the commonest.
pub(super) fn commonest_error(run: &Benchmark, zoo: &str, [from, to]: [&str; 2]) -> Result<Finding> {
    let classes = &run.judgement.results.task.output_names();
    let label = |name: &str| classes.iter().position(|known| known == name);
    let Some(entry) = run.find(zoo) else { return Ok(lacks(run.absent(&[zoo]).join(", "))) };
    let (Some(first), Some(second)) = (label(from), label(to)) else {
        return Ok(lacks(format!("the classes {from} and {to}")));
    };
    let cells = classes.len() * (classes.len() - 1) - 1;
    let mut contrasts = vec![];
    for (truth, name) in classes.iter().enumerate() {
        for (predicted, said) in classes.iter().enumerate() {
            if truth == predicted || (truth, predicted) == (first, second) {
                continue;
            }
            let more = |predictions: &[Predicted]| {
                Some(share(predictions[0], [first, second]) - share(predictions[0], [truth, predicted]))
            };
            let text = format!("{from} taken for {to} less {name} for {said}, % of all test samples");
            contrasts.extend(run.contrast(text, &[&entry.name], &more, cells)?);
        }
    }
    Ok(against_all(0.0, contrasts))
}

/// Returns the share of samples of the first class that are taken for the second, in % of all.
fn share(predictions: Predicted, [from, to]: [usize; 2]) -> f64 {
    let (mut count, mut all) = (0usize, 0usize);
    for (truth, predicted) in predictions.each() {
        all += 1;
        count += usize::from((truth[0] as usize, predicted[0] as usize) == (from, to));
    }
    100.0 * count as f64 / all.max(1) as f64
}

/// Compares how much more `one` varies over the folds than `other`, in %, as one of `count` contrasts.
fn spread(run: &Benchmark, one: &str, other: &str, count: usize) -> Result<Option<Contrast>> {
    let (Some(entry), Some(baseline)) = (run.find(one), run.find(other)) else { return Ok(None) };
    let (a, b) = run.comparison.values(&entry.name, &baseline.name, |predictions| predictions.accuracy(None));
    if a.len() < 3 {
        return Ok(None);
    }
    let at = |confidence| spread_ratio(&a, &b, confidence).map(|found| found.map(of_ratio));
    let (Some(measured), Some(refuting)) = (at(run.confidence)?, at(run.refuting(count))?) else {
        return Ok(None);
    };
    let text = format!("SD over folds: {} more than {}, %", entry.name, baseline.name);
    Ok(Some(Contrast { margin: None, ..Contrast::new(text, measured, refuting) }))
}

fn of_ratio(ratio: SpreadRatio) -> Effect {
    let percent = |ratio: f64| 100.0 * (ratio - 1.0);
    Effect { size: percent(ratio.ratio), interval: Some(ratio.interval.map(percent)), p: None, error: None }
}

/// Tests that the first of each pair varies more over the folds than the second.
pub(super) fn larger_spreads(run: &Benchmark, pairs: &[[&str; 2]]) -> Result<Finding> {
    let mut names: Vec<&str> = vec![];
    for name in pairs.as_flattened() {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let absent = run.absent(&names);
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let found = pairs.iter().map(|[one, other]| spread(run, one, other, pairs.len()));
    let known: Vec<Contrast> = found.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    Ok(if known.len() < pairs.len() { lacks("folds that differ") } else { against_all(0.0, known) })
}

/// Tests that `one` varies less over the folds than each of `others`.
pub(super) fn smallest_spread(run: &Benchmark, one: &str, others: &[&str]) -> Result<Finding> {
    larger_spreads(run, &others.iter().map(|other| [*other, one]).collect::<Vec<_>>())
}
