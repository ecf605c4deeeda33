//! Rouhafzay et al. 2021: what tuning changes and freezing costs.

use super::benchmark::{Benchmark, RunNetwork};
use super::contrast::Contrast;
use super::finding::{Finding, accuracy, against_all, effects, lacks, not_worse};
use taxel::judge::Effect;
use taxel::judge::Result;
use taxel::judge::statistics::{independent, ranks};
use taxel::learn::FoldRecord;
use taxel::learn::metrics::{mean_sd, t_quantile};
use taxel::zoo::{Settings, find, matlab};

/// Tests that `one`, tuned from a checkpoint, is less than `margin` points worse than `other`.
pub(super) fn tuned_close(run: &Benchmark, one: &str, other: &str, margin: f64) -> Result<Finding> {
    match (run.tuned(one), run.tuned(other)) {
        (Some(entry), Some(baseline)) => not_worse(run, entry, &[baseline], margin),
        _ => Ok(lacks(format!("{one} and {other}, both tuned from a checkpoint"))),
    }
}

/// Compares every network that the run both tunes and trains with all but its classifier frozen: by name of
/// MobileNetV2's body, or no convolution of it having changed.
pub(super) fn tuned_beats_frozen(run: &Benchmark) -> Result<Finding> {
    let is_unchanged = |e: &RunNetwork| {
        let changes = &e.judged.results.changes;
        !changes.is_empty() && changes.iter().all(|layer| layer.change == 0.0)
    };
    let named = |e: &RunNetwork| e.frozen.iter().any(|part| part == "features");
    let is_frozen = |e: &&RunNetwork| e.checkpoint && !e.frozen.is_empty() && (named(e) || is_unchanged(e));
    let frozen: Vec<&RunNetwork> = run.full().filter(is_frozen).collect();
    let (count, mut found) = (frozen.len(), vec![]);
    for one in frozen {
        let tuned =
            |e: &&RunNetwork| e.checkpoint && e.frozen.is_empty() && e.results().zoo == one.results().zoo;
        let Some(tuned) = run.full().find(tuned) else { continue };
        let words = |pair: &str| format!("accuracy of {}: {pair}, points", one.results().zoo);
        found.extend(effects(run, tuned, &[one], &accuracy, count, words)?);
    }
    if found.is_empty() {
        Ok(lacks("a network from a checkpoint both tuned and frozen up to its classifier"))
    } else {
        Ok(against_all(0.0, found))
    }
}

/// Tests that freezing MobileNetV2's layers `range`, by MATLAB's numbers, costs less than `margin` points against tuning
/// everything. Runs record the names that the range stands for.
pub(super) fn freezing_costs(run: &Benchmark, range: &str, margin: f64) -> Result<Finding> {
    let zoo = "mobilenet-v2";
    let names = match layers(zoo, range) {
        Ok(names) => names,
        Err(reason) => return Ok(lacks(reason)),
    };
    let is_frozen = |e: &&RunNetwork| {
        let mut frozen = e.frozen.clone();
        frozen.sort_unstable();
        e.results().zoo == zoo && e.checkpoint && frozen == names
    };
    let (frozen, tuned) = (run.full().find(is_frozen), run.tuned(zoo));
    match (frozen, tuned) {
        (Some(frozen), Some(tuned)) => not_worse(run, frozen, &[tuned], margin),
        _ => Ok(lacks(format!("{zoo} from a checkpoint, once tuned and once with {range} frozen"))),
    }
}

/// Returns the names of the nodes in a range of layers, sorted.
fn layers(zoo: &str, range: &str) -> std::result::Result<Vec<String>, String> {
    let graph = find(zoo).and_then(|entry| entry.graph(&Settings::new())).map_err(|e| e.to_string())?;
    let mut names = matlab::range(&graph, range).map_err(|e| e.to_string())?;
    names.sort_unstable();
    Ok(names)
}

/// Tests that the deeper a convolution, the less tuning changes it: the mean rank correlation over trainings. Layers of one
/// network are no sample of anything, so one training says nothing.
pub(super) fn early_layers_change_most(run: &Benchmark, zoo: &str) -> Result<Finding> {
    let is_tuned =
        |e: &&RunNetwork| e.results().zoo == zoo && e.frozen.is_empty() && e.judged.results.changes.len() > 3;
    let Some(tuned) = run.full().find(is_tuned) else {
        return Ok(lacks(format!("{zoo} tuned from a checkpoint")));
    };
    let trainings = run.comparison.records(&tuned.name).iter().filter_map(earliness).count();
    if trainings < 2 {
        return Ok(lacks(format!("a second training of {zoo}: layers of one network are no sample")));
    }
    let text =
        format!("rank correlation of earliness and weight change, {trainings} trainings of {}", tuned.name);
    let contrast = run.contrast(text, &[&tuned.name], &|predicted| earliness(predicted[0].record()), 1)?;
    Ok(against_all(0.0, contrast.map(|found| Contrast { margin: None, ..found }).into_iter().collect()))
}

/// Returns the rank correlation of how early a convolution comes and how much the training changed it; none of three or
/// fewer.
fn earliness(record: &FoldRecord) -> Option<f64> {
    let changes: Vec<f64> = record.changes.iter().map(|layer| layer.change).collect();
    let depth: Vec<f64> = (0..changes.len()).map(|at| at as f64).collect();
    (changes.len() > 3).then(|| -correlation(&ranks(&depth).0, &ranks(&changes).0))
}

/// Returns the rank correlation; 0 where either does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let ((mean_a, _), (mean_b, _)) = (mean_sd(a), mean_sd(b));
    let sum =
        |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| f(a - mean_a, b - mean_b)).sum::<f64>();
    let size = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    if size > 0.0 { sum(&|a, b| a * b) / size } else { 0.0 }
}

/// Returns that the claim cannot be tested: stitched networks are made of two runs and never trained, so no run folder
/// holds one.
pub(super) fn stitched(_: &Benchmark) -> Result<Finding> {
    Ok(lacks("a stitched network: one is made of two trained networks, and no run trains it"))
}

/// Tests that more sensing elements add more than `least` points: two runs of one scene, the same network in both.
pub(super) fn resolution_matters(
    run: &Benchmark,
    others: &[&Benchmark],
    [few, many]: [usize; 2],
    least: f64,
) -> Result<Finding> {
    let size = |run: &Benchmark| match run.judgement.results.sample_shape.as_slice() {
        [height, width] if height == width => Some(*height),
        _ => None,
    };
    let source = |run: &Benchmark| run.judgement.results.source.clone();
    let coarse = others.iter().find(|other| size(other) == Some(few) && source(other) == source(run));
    let (Some(coarse), true) = (coarse, size(run) == Some(many)) else {
        return Ok(lacks(format!(
            "{many} × {many} elements, or a second run of its scene with {few} × {few} beside it"
        )));
    };
    let mut contrasts = vec![];
    let count = run.full().filter(|e| !e.judged.baseline).count();
    for fine in run.full().filter(|e| !e.judged.baseline) {
        let twin = coarse.full().find(|e| e.name == fine.name && e.results().zoo == fine.results().zoo);
        let known = |e: &RunNetwork| Some((e.results().primary()?, e.results().interval?));
        let (Some(a), Some(b)) = (known(fine), twin.and_then(known)) else { continue };
        // A mean over folds may lie a little outside an interval over samples.
        let wide = |(size, [low, high]): (f64, [f64; 2])| (size, [low.min(size), high.max(size)]);
        let (size, interval) = independent(wide(a), wide(b))?;
        let text = format!("accuracy of {}: {many} less {few} elements a side, points", fine.name);
        let at = |interval| Effect { size, interval: Some(interval), p: None, error: None };
        // Intervals of runs are at 95 %; the normal distribution says how much wider one of several contrasts is.
        let wider = normal(run.refuting(count)) / normal(0.95);
        let refuting = interval.map(|end| size + wider * (end - size));
        contrasts.push(Contrast::new(text, at(interval), at(refuting)));
    }
    if contrasts.is_empty() {
        Ok(lacks("a network that the run with fewer elements has too"))
    } else {
        Ok(against_all(least, contrasts))
    }
}

/// Returns how many standard errors an interval of this confidence reaches to either side.
fn normal(confidence: f64) -> f64 {
    t_quantile(f64::INFINITY, (1.0 + confidence) / 2.0)
}
