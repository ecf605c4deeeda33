//! Paper 001: what tuning changes and freezing costs.

use super::answer::{Answer, above, accuracy, against_all, lacks, not_worse};
use super::benchmark::{Benchmark, Entry};
use taxel::judge::Effect;
use taxel::judge::Result;
use taxel::judge::statistics::{independent, ranks};
use taxel::learn::metrics::mean_sd;

/// Tuned from a checkpoint, `one` is less than `margin` points worse than `other`.
pub(super) fn tuned_close(run: &Benchmark, one: &str, other: &str, margin: f64) -> Result<Answer> {
    match (run.tuned(one), run.tuned(other)) {
        (Some(own), Some(baseline)) => not_worse(run, own, &[baseline], margin),
        _ => Ok(lacks(format!("{one} and {other}, both tuned from a checkpoint"))),
    }
}

/// Every network that the run both tunes and trains with all but its classifier frozen: by name of
/// MobileNetV2's body, or no convolution of it having changed.
pub(super) fn tuned_beats_frozen(run: &Benchmark) -> Result<Answer> {
    let still = |e: &Entry| {
        let changes = &e.judged.results.changes;
        !changes.is_empty() && changes.iter().all(|layer| layer.change == 0.0)
    };
    let named = |e: &Entry| e.frozen.iter().any(|part| part == "features");
    let frozen = run.full().filter(|e| e.checkpoint && !e.frozen.is_empty() && (named(e) || still(e)));
    let mut effects = vec![];
    for one in frozen {
        let tuned = |e: &&Entry| e.checkpoint && e.frozen.is_empty() && e.results().zoo == one.results().zoo;
        let Some(tuned) = run.full().find(tuned) else { continue };
        if let Some(effect) = run.comparison.effect(&[&tuned.name, &one.name], &accuracy, 0.95)? {
            let text = format!("accuracy of {}: {} less {}, points", one.results().zoo, tuned.name, one.name);
            effects.push((text, effect));
        }
    }
    match effects.is_empty() {
        true => Ok(lacks("a network from a checkpoint both tuned and frozen up to its classifier")),
        false => Ok(against_all(0.0, effects)),
    }
}

/// Freezing `range` costs less than `margin` points against tuning everything.
pub(super) fn freezing_costs(run: &Benchmark, zoo: &str, range: &str, margin: f64) -> Result<Answer> {
    let own = |e: &&Entry| e.results().zoo == zoo && e.checkpoint && e.frozen == [range];
    let (frozen, tuned) = (run.full().find(own), run.tuned(zoo));
    match (frozen, tuned) {
        (Some(frozen), Some(tuned)) => not_worse(run, frozen, &[tuned], margin),
        _ => Ok(lacks(format!("{zoo} from a checkpoint, once tuned and once with {range} frozen"))),
    }
}

/// The deeper a convolution, the less tuning changes it: rank correlation with Fisher's interval.
pub(super) fn early_layers_change_most(run: &Benchmark, zoo: &str) -> Result<Answer> {
    let tuned = run
        .full()
        .find(|e| e.results().zoo == zoo && e.frozen.is_empty() && e.judged.results.changes.len() > 3);
    let Some(own) = tuned else {
        return Ok(lacks(format!("{zoo} tuned from a checkpoint")));
    };
    let changes: Vec<f64> = own.judged.results.changes.iter().map(|layer| layer.change).collect();
    let depth: Vec<f64> = (0..changes.len()).map(|at| at as f64).collect();
    let r = -correlation(&ranks(&depth).0, &ranks(&changes).0);
    let half = 1.96 / (changes.len() as f64 - 3.0).sqrt();
    // Perfect order has no variance: Fisher's transform of 1 is infinite.
    let z = r.clamp(-0.999_999, 0.999_999).atanh();
    let effect = Effect { size: r, interval: Some([(z - half).tanh(), (z + half).tanh()]), p: None };
    let text =
        format!("rank correlation of earliness and weight change, {} layers of {}", changes.len(), own.name);
    Ok(above(0.0, text, effect))
}

/// 0 where either does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let ((mean_a, _), (mean_b, _)) = (mean_sd(a), mean_sd(b));
    let sum =
        |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| f(a - mean_a, b - mean_b)).sum::<f64>();
    let size = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    if size > 0.0 { sum(&|a, b| a * b) / size } else { 0.0 }
}

/// Stitched networks are made of two runs and never trained: no run folder holds one.
pub(super) fn stitched(_: &Benchmark) -> Result<Answer> {
    Ok(lacks("a stitched network: one is made of two trained networks, and no run trains it"))
}

/// More sensing elements add more than `least` points: two runs of one scene, the same network in both.
pub(super) fn resolution_matters(
    run: &Benchmark,
    others: &[&Benchmark],
    [few, many]: [usize; 2],
    least: f64,
) -> Result<Answer> {
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
    let mut effects = vec![];
    for fine in run.full().filter(|e| !e.judged.baseline) {
        let twin = coarse.full().find(|e| e.name == fine.name && e.results().zoo == fine.results().zoo);
        let known = |e: &Entry| Some((e.results().primary()?, e.results().interval?));
        let (Some(a), Some(b)) = (known(fine), twin.and_then(known)) else { continue };
        // A mean over folds may lie a little outside an interval over samples.
        let wide = |(size, [low, high]): (f64, [f64; 2])| (size, [low.min(size), high.max(size)]);
        let (size, interval) = independent(wide(a), wide(b))?;
        let text = format!(
            "accuracy of {}: {many} less {few} elements a side, points; holds above {least}",
            fine.name
        );
        effects.push((text, Effect { size, interval: Some(interval), p: None }));
    }
    match effects.is_empty() {
        true => Ok(lacks("a network that the run with fewer elements has too")),
        false => Ok(against_all(least, effects)),
    }
}
