//! Questions to a run that any paper may ask: who is better, closer, steadier, mistaken for what.

use taxel::learn::metrics::Confusion;

use super::answer::{Answer, against_all, lacks, not_worse};
use super::benchmark::{Benchmark, Entry};
use taxel::judge::Result;
use taxel::judge::statistics::{SpreadRatio, spread_ratio};
use taxel::judge::{Answers, Effect};

/// What is compared.
#[derive(Debug, Clone, Copy)]
pub(super) enum Measure {
    /// Over all attributes.
    Accuracy,
    /// Accuracy on one attribute.
    Attribute(&'static str),
    /// Precision of the worst level of an attribute.
    WorstPrecision(&'static str),
}

/// Some of the names that are in nobody's run.
fn missing(run: &Benchmark, names: &[&str]) -> Vec<String> {
    names.iter().filter(|name| run.find(name).is_none()).map(ToString::to_string).collect()
}

/// `one` is better than each of `others`.
pub(super) fn beats(run: &Benchmark, one: &str, others: &[&str], measure: Measure) -> Result<Answer> {
    let (what, attribute) = match measure {
        Measure::Accuracy => ("accuracy", None),
        Measure::Attribute(name) => ("accuracy", Some(name)),
        Measure::WorstPrecision(name) => ("precision of the worst level", Some(name)),
    };
    let attributes = &run.judgement.results.task.attributes();
    let at = attribute.map(|name| attributes.iter().position(|own| own.name == name));
    if let (Some(None), Some(name)) = (at, attribute) {
        return Ok(lacks(format!("the attribute {name}")));
    }
    let at = at.flatten();
    let absent = missing(run, &[&[one], others].concat());
    let Some(own) = run.find(one).filter(|_| absent.is_empty()) else {
        return Ok(lacks(absent.join(", ")));
    };
    let levels = at.map_or(0, |at| attributes[at].classes.len());
    let value = |answers: Answers| match measure {
        Measure::WorstPrecision(_) => worst_precision(answers, at.unwrap_or(0), levels),
        _ => Some(answers.accuracy(at)),
    };
    let difference = |both: &[Answers]| Some(value(both[0])? - value(both[1])?);
    let mut effects = vec![];
    for other in others.iter().filter_map(|name| run.find(name)) {
        let names = [own.name.as_str(), other.name.as_str()];
        if let Some(effect) = run.comparison.effect(&names, &difference, 0.95)? {
            let of = attribute.map_or(String::new(), |name| format!(" of {name}"));
            effects.push((format!("{what}{of}: {} less {}, points", own.name, other.name), effect));
        }
    }
    Ok(against_all(0.0, effects))
}

/// In %, over the levels that occur.
fn worst_precision(answers: Answers, attribute: usize, levels: usize) -> Option<f64> {
    let (truth, predicted): (Vec<u32>, Vec<u32>) =
        answers.each().map(|(truth, predicted)| (truth[attribute], predicted[attribute])).unzip();
    let classes = Confusion::new(&truth, &predicted, levels).ok()?.per_class();
    let precisions = classes.iter().filter(|class| class.support > 0).map(|class| class.precision);
    precisions.min_by(f64::total_cmp).map(|worst| 100.0 * worst)
}

/// The first of `ones` that the run has is less than `margin` points worse than each of `others`.
pub(super) fn close(run: &Benchmark, ones: &[&str], others: &[&str], margin: f64) -> Result<Answer> {
    let absent = missing(run, others);
    let Some(own) = ones.iter().find_map(|name| run.find(name)) else {
        return Ok(lacks([&[ones[0].to_string()], absent.as_slice()].concat().join(", ")));
    };
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let baselines: Vec<&Entry> = others.iter().filter_map(|name| run.find(name)).collect();
    not_worse(run, own, &baselines, margin)
}

/// Of all mistakes the one that takes the first class for the second is the commonest.
pub(super) fn commonest_error(run: &Benchmark, zoo: &str, [from, to]: [&str; 2]) -> Result<Answer> {
    let classes = &run.judgement.results.task.output_names();
    let label = |name: &str| classes.iter().position(|known| known == name);
    let Some(own) = run.find(zoo) else { return Ok(lacks(zoo)) };
    let (Some(first), Some(second)) = (label(from), label(to)) else {
        return Ok(lacks(format!("the classes {from} and {to}")));
    };
    let mut effects = vec![];
    for (truth, name) in classes.iter().enumerate() {
        for (predicted, said) in classes.iter().enumerate() {
            if truth == predicted || (truth, predicted) == (first, second) {
                continue;
            }
            let more = |answers: &[Answers]| {
                Some(share(answers[0], [first, second]) - share(answers[0], [truth, predicted]))
            };
            if let Some(effect) = run.comparison.effect(&[&own.name], &more, 0.95)? {
                let text = format!("{from} taken for {to} less {name} for {said}, % of all test samples");
                effects.push((text, effect));
            }
        }
    }
    Ok(against_all(0.0, effects))
}

/// Samples of the first class that are taken for the second, in % of all.
fn share(answers: Answers, [from, to]: [usize; 2]) -> f64 {
    let (mut count, mut all) = (0usize, 0usize);
    for (truth, predicted) in answers.each() {
        all += 1;
        count += usize::from((truth[0] as usize, predicted[0] as usize) == (from, to));
    }
    100.0 * count as f64 / all.max(1) as f64
}

/// How much more `one` varies over the folds than `other`, in %.
fn spread(run: &Benchmark, one: &str, other: &str) -> Result<Option<(String, Effect)>> {
    let (Some(own), Some(baseline)) = (run.find(one), run.find(other)) else { return Ok(None) };
    let (a, b) = run.comparison.values(&own.name, &baseline.name, |answers| answers.accuracy(None));
    if a.len() < 3 {
        return Ok(None);
    }
    let text = format!("SD over folds: {} more than {}, %", own.name, baseline.name);
    let effect = |ratio: SpreadRatio| Effect {
        size: 100.0 * (ratio.ratio - 1.0),
        interval: Some(ratio.interval.map(|bound| 100.0 * (bound - 1.0))),
        p: None,
    };
    Ok(spread_ratio(&a, &b, 0.95)?.map(|ratio| (text, effect(ratio))))
}

/// `one` varies more over the folds than `other`.
pub(super) fn larger_spread(run: &Benchmark, one: &str, other: &str) -> Result<Answer> {
    let absent = missing(run, &[one, other]);
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let effect = spread(run, one, other)?;
    Ok(effect.map_or_else(|| lacks("folds that differ"), |own| against_all(0.0, vec![own])))
}

/// `one` varies less over the folds than each of `others`.
pub(super) fn smallest_spread(run: &Benchmark, one: &str, others: &[&str]) -> Result<Answer> {
    let absent = missing(run, &[&[one], others].concat());
    if !absent.is_empty() {
        return Ok(lacks(absent.join(", ")));
    }
    let effects = others.iter().map(|other| spread(run, other, one)).collect::<Result<Vec<_>>>()?;
    let known: Vec<_> = effects.into_iter().flatten().collect();
    Ok(if known.len() < others.len() { lacks("folds that differ") } else { against_all(0.0, known) })
}
