//! The result of testing a claim on a run.

use super::benchmark::{Benchmark, RunNetwork};
use super::contrast::Contrast;
use taxel::judge::Result;
use taxel::judge::statistics::independent;
use taxel::judge::{Effect, Predicted, Statistic};
use taxel::learn::metrics::t_quantile;

/// Result of testing a claim on a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Finding {
    /// Bound above which a contrast supports the claim.
    pub least: f64,
    pub contrasts: Vec<Contrast>,
    /// Things that the run lacks, where there is no contrast.
    pub lacks: Option<String>,
}

/// Returns the finding that the run lacks something the claim is about.
pub(super) fn lacks(what: impl Into<String>) -> Finding {
    Finding { least: 0.0, contrasts: vec![], lacks: Some(what.into()) }
}

/// Returns the finding of a claim that every contrast has to support by lying above `least`.
pub(super) fn against_all(least: f64, contrasts: Vec<Contrast>) -> Finding {
    let lacks = contrasts.is_empty().then(|| "test parts that the networks share".into());
    Finding { least, contrasts, lacks }
}

/// Compares a network with one of another run by how far each is above `chance` there, as one of `count` contrasts; none
/// without scores or intervals. `words` describe it.
pub(super) fn between_runs(
    run: &Benchmark,
    [one, other]: [&RunNetwork; 2],
    chance: [f64; 2],
    count: usize,
    words: String,
) -> Result<Option<Contrast>> {
    let above = |network: &RunNetwork, chance: f64| {
        let (score, [low, high]) = (network.results().primary()?, network.results().interval?);
        // A mean over folds may lie a little outside an interval over samples.
        Some((score - chance, [low.min(score), high.max(score)].map(|end| end - chance)))
    };
    let (Some(a), Some(b)) = (above(one, chance[0]), above(other, chance[1])) else { return Ok(None) };
    let (size, interval) = independent(a, b)?;
    let at = |interval| Effect { size, interval: Some(interval), p: None, error: None };
    // Intervals of runs are at 95 %; the normal distribution says how much wider one of several contrasts is.
    let wider = normal(run.refuting(count)) / normal(0.95);
    let refuting = interval.map(|end| size + wider * (end - size));
    Ok(Some(Contrast::new(words, at(interval), at(refuting))))
}

/// Returns how many standard errors an interval of this confidence reaches to either side.
fn normal(confidence: f64) -> f64 {
    t_quantile(f64::INFINITY, (1.0 + confidence) / 2.0)
}

/// Returns the accuracy of the first less that of the second, in points.
pub(super) fn accuracy(both: &[Predicted]) -> Option<f64> {
    Some(both[0].accuracy(None) - both[1].accuracy(None))
}

/// Measures `statistic` of `one` and each of `others` on the test parts that they share, in a claim of `count` contrasts;
/// `words` describe one by `one less other`.
pub(super) fn effects(
    run: &Benchmark,
    one: &RunNetwork,
    others: &[&RunNetwork],
    statistic: Statistic,
    count: usize,
    words: impl Fn(&str) -> String,
) -> Result<Vec<Contrast>> {
    let mut found = vec![];
    for other in others {
        let text = words(&format!("{} less {}", one.name, other.name));
        found.extend(run.contrast(text, &[&one.name, &other.name], statistic, count)?);
    }
    Ok(found)
}

/// Tests that `entry` is less than `margin` points worse than each of `others`.
pub(super) fn not_worse(
    run: &Benchmark,
    entry: &RunNetwork,
    others: &[&RunNetwork],
    margin: f64,
) -> Result<Finding> {
    let words = |pair: &str| format!("accuracy: {pair}, points");
    Ok(against_all(-margin, effects(run, entry, others, &accuracy, others.len(), words)?))
}
