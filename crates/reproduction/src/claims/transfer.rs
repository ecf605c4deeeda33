//! Rouhafzay et al. 2021: what tuning changes and freezing costs.

use super::benchmark::{Benchmark, RunNetwork};
use super::contrast::Contrast;
use super::finding::{Finding, accuracy, against_all, between_runs, effects, lacks, not_worse};
use taxel::judge::statistics::ranks;
use taxel::judge::{Predicted, Result};
use taxel::learn::FoldRecord;
use taxel::learn::metrics::mean_sd;
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
    let frozen: Vec<&RunNetwork> = run.full().filter(|entry| is_body_frozen(entry)).collect();
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

/// Checks whether a network started from a checkpoint and kept all but its classifier.
pub(super) fn is_body_frozen(entry: &RunNetwork) -> bool {
    let changes = &entry.judged.results.changes;
    let is_unchanged = !changes.is_empty() && changes.iter().all(|layer| layer.change == 0.0);
    let is_named = entry.frozen.iter().any(|part| part == "features");
    entry.checkpoint && !entry.frozen.is_empty() && (is_named || is_unchanged)
}

/// Lists the networks that started from a checkpoint and were tuned as a whole.
pub(super) fn all_tuned<'r>(run: &'r Benchmark) -> impl Iterator<Item = &'r RunNetwork> {
    run.full().filter(|entry| entry.checkpoint && entry.frozen.is_empty() && !entry.judged.baseline)
}

/// Tests that `zoo`, tuned, is better than every other tuned network, and frozen than every other frozen one.
pub(super) fn best_from_checkpoint(run: &Benchmark, zoo: &str) -> Result<Finding> {
    let kinds: [Vec<&RunNetwork>; 2] =
        [all_tuned(run).collect(), run.full().filter(|entry| is_body_frozen(entry)).collect()];
    let is_own = |entry: &&RunNetwork| entry.results().zoo == zoo;
    let (Some(_), true) = (kinds[0].iter().find(|e| is_own(e)), kinds[0].len() > 1) else {
        return Ok(lacks(format!("{zoo} and another network, both tuned from a checkpoint")));
    };
    let mut found = vec![];
    let count = kinds.iter().map(|kind| kind.iter().filter(|e| !is_own(e)).count()).sum();
    for kind in &kinds {
        let Some(own) = kind.iter().copied().find(is_own) else { continue };
        let others: Vec<&RunNetwork> = kind.iter().copied().filter(|e| !is_own(e)).collect();
        let words = |pair: &str| format!("accuracy: {pair}, points");
        found.extend(effects(run, own, &others, &accuracy, count, words)?);
    }
    Ok(against_all(0.0, found))
}

/// Tests that tuning changes the convolutions of `zoo` less than those of every other network: the mean change over its
/// layers, training by training. One training says nothing of another.
pub(super) fn changes_least(run: &Benchmark, zoo: &str) -> Result<Finding> {
    let with_changes: Vec<&RunNetwork> =
        all_tuned(run).filter(|entry| !entry.judged.results.changes.is_empty()).collect();
    let (own, others): (Vec<_>, Vec<_>) =
        with_changes.into_iter().partition(|entry| entry.results().zoo == zoo);
    let (Some(own), false) = (own.first(), others.is_empty()) else {
        return Ok(lacks(format!("{zoo} and another network, both tuned from a checkpoint")));
    };
    if run.comparison.records(&own.name).len() < 2 {
        return Ok(lacks(format!("a second training of {zoo}")));
    }
    let mean = |record: &FoldRecord| {
        let changes: Vec<f64> = record.changes.iter().map(|layer| layer.change).collect();
        (!changes.is_empty()).then(|| mean_sd(&changes).0)
    };
    let mut found = vec![];
    for other in &others {
        let more = |both: &[Predicted]| Some(mean(both[1].record())? - mean(both[0].record())?);
        let text = format!("mean weight change: {} less {}", other.name, own.name);
        let contrast = run.contrast(text, &[&own.name, &other.name], &more, others.len())?;
        found.extend(contrast.map(|found| Contrast { margin: None, ..found }));
    }
    Ok(against_all(0.0, found))
}

/// Tests that freezing MobileNetV2's layers `range` costs less than freezing any of the `others`.
pub(super) fn cheapest_to_freeze(run: &Benchmark, range: &str, others: &[&str]) -> Result<Finding> {
    let zoo = "mobilenet-v2";
    let find = |range: &str| {
        let names = layers(zoo, range).ok()?;
        run.full().find(|entry| is_frozen_at(entry, zoo, &names))
    };
    let missing: Vec<&str> =
        std::iter::once(range).chain(others.iter().copied()).filter(|r| find(r).is_none()).collect();
    let Some(own) = find(range).filter(|_| missing.is_empty()) else {
        return Ok(lacks(format!("{zoo} from a checkpoint with {} frozen", missing.join(", "))));
    };
    let others: Vec<&RunNetwork> = others.iter().filter_map(|range| find(range)).collect();
    let words = |pair: &str| format!("accuracy: {pair}, points");
    Ok(against_all(0.0, effects(run, own, &others, &accuracy, others.len(), words)?))
}

fn is_frozen_at(entry: &RunNetwork, zoo: &str, names: &[String]) -> bool {
    let mut frozen = entry.frozen.clone();
    frozen.sort_unstable();
    entry.results().zoo == zoo && entry.checkpoint && frozen == names
}

/// Tests that freezing MobileNetV2's layers `range`, by MATLAB's numbers, costs less than `margin` points against tuning
/// everything. Runs record the names that the range stands for.
pub(super) fn freezing_costs(run: &Benchmark, range: &str, margin: f64) -> Result<Finding> {
    let zoo = "mobilenet-v2";
    let names = match layers(zoo, range) {
        Ok(names) => names,
        Err(reason) => return Ok(lacks(reason)),
    };
    let frozen = run.full().find(|entry| is_frozen_at(entry, zoo, &names));
    let tuned = run.tuned(zoo);
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
        let Some(twin) = twin else { continue };
        let text = format!("accuracy of {}: {many} less {few} elements a side, points", fine.name);
        contrasts.extend(between_runs(run, [fine, twin], [0.0; 2], count, text)?);
    }
    if contrasts.is_empty() {
        Ok(lacks("a network that the run with fewer elements has too"))
    } else {
        Ok(against_all(least, contrasts))
    }
}
