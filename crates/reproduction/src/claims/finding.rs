//! Findings about a claim: from the size of an effect to a verdict.

use std::cmp::Ordering;

use super::benchmark::{Benchmark, RunNetwork};
use super::claim::Verdict;
use taxel::judge::Result;
use taxel::judge::{Effect, Predicted, Statistic};

/// Result of testing a claim on a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Finding {
    pub outcome: Verdict,
    pub effect: String,
    pub size: Option<f64>,
    pub interval: Option<[f64; 2]>,
}

/// Returns the finding that the run lacks something the claim is about.
pub(super) fn lacks(what: impl Into<String>) -> Finding {
    let outcome = Verdict::CannotBeTested;
    Finding { outcome, effect: format!("the run lacks {}", what.into()), size: None, interval: None }
}

/// Finds that a claim holds where the interval lies above `least`, and that it does not where it lies below.
pub(super) fn above(least: f64, effect: String, measured: Effect) -> Finding {
    let outcome = outcome(least, &measured);
    let effect = match measured.interval {
        Some(_) => effect,
        None => format!("{effect}; the run lacks test parts or groups that tell how much it varies"),
    };
    Finding { outcome, effect, size: Some(measured.size), interval: measured.interval }
}

fn outcome(least: f64, measured: &Effect) -> Verdict {
    match measured.interval {
        Some([low, _]) if low > least => Verdict::Holds,
        Some([_, high]) if high <= least => Verdict::DoesNotHold,
        Some(_) => Verdict::TooFewData,
        None => Verdict::CannotBeTested,
    }
}

/// Orders effects by how near they come to refuting a claim: first those that do, then those that may, those without an
/// interval, those that support it; alike ones by their lower bound.
pub(super) fn nearest(least: f64) -> impl Fn(&(String, Effect), &(String, Effect)) -> Ordering {
    let rank = move |effect: &Effect| match outcome(least, effect) {
        Verdict::DoesNotHold => 0,
        Verdict::TooFewData => 1,
        Verdict::CannotBeTested => 2,
        Verdict::Holds => 3,
    };
    let low = move |effect: &Effect| effect.interval.map_or(least, |[low, _]| low);
    move |a, b| rank(&a.1).cmp(&rank(&b.1)).then(low(&a.1).total_cmp(&low(&b.1)))
}

/// Returns the finding for the effect that comes nearest to refuting the claim.
pub(super) fn against_all(least: f64, effects: Vec<(String, Effect)>) -> Finding {
    let (count, first) = (effects.len(), effects.into_iter().min_by(nearest(least)));
    let Some((effect, measured)) = first else { return lacks("test parts that the networks share") };
    let of = if count > 1 { format!("; nearest of {count}") } else { String::new() };
    above(least, format!("{effect}{of}"), measured)
}

/// Returns the accuracy of the first less that of the second, in points.
pub(super) fn accuracy(both: &[Predicted]) -> Option<f64> {
    Some(both[0].accuracy(None) - both[1].accuracy(None))
}

/// Measures `statistic` of `one` and each of `others` on the test parts that they share; `words` describe an effect by
/// `one less other`.
pub(super) fn effects(
    run: &Benchmark,
    one: &RunNetwork,
    others: &[&RunNetwork],
    (statistic, confidence): (Statistic, f64),
    words: impl Fn(&str) -> String,
) -> Result<Vec<(String, Effect)>> {
    let mut found = vec![];
    for other in others {
        let effect = run.comparison.effect(&[&one.name, &other.name], statistic, confidence)?;
        found.extend(effect.map(|effect| (words(&format!("{} less {}", one.name, other.name)), effect)));
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
    let words = |pair: &str| format!("accuracy: {pair}, points; holds above -{margin}");
    Ok(against_all(-margin, effects(run, entry, others, (&accuracy, 0.95), words)?))
}
