//! Answers to a claim: from the size of an effect to an outcome.

use std::cmp::Ordering;

use super::benchmark::{Benchmark, Entry};
use super::claim::Outcome;
use taxel::judge::Result;
use taxel::judge::{Answers, Effect};

/// What a run says about a claim.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Answer {
    pub outcome: Outcome,
    pub effect: String,
    pub size: Option<f64>,
    pub interval: Option<[f64; 2]>,
}

/// What keeps a run from being asked.
pub(super) fn lacks(what: impl Into<String>) -> Answer {
    let outcome = Outcome::CannotBeTested;
    Answer { outcome, effect: format!("the run lacks {}", what.into()), size: None, interval: None }
}

/// Holds where the interval lies above `least`, does not where it lies below.
pub(super) fn above(least: f64, effect: String, own: Effect) -> Answer {
    let outcome = outcome(least, &own);
    let effect = match own.interval {
        Some(_) => effect,
        None => format!("{effect}; the run lacks test parts or groups that tell how much it varies"),
    };
    Answer { outcome, effect, size: Some(own.size), interval: own.interval }
}

fn outcome(least: f64, own: &Effect) -> Outcome {
    match own.interval {
        Some([low, _]) if low > least => Outcome::Holds,
        Some([_, high]) if high <= least => Outcome::DoesNotHold,
        Some(_) => Outcome::TooFewData,
        None => Outcome::CannotBeTested,
    }
}

/// What comes nearest to refuting a claim first: effects that do, those that may, those without an interval, those
/// that support it; alike ones by their lower bound.
pub(super) fn nearest(least: f64) -> impl Fn(&(String, Effect), &(String, Effect)) -> Ordering {
    let rank = move |own: &Effect| match outcome(least, own) {
        Outcome::DoesNotHold => 0,
        Outcome::TooFewData => 1,
        Outcome::CannotBeTested => 2,
        Outcome::Holds => 3,
    };
    let low = move |own: &Effect| own.interval.map_or(least, |[low, _]| low);
    move |a, b| rank(&a.1).cmp(&rank(&b.1)).then(low(&a.1).total_cmp(&low(&b.1)))
}

/// Against each of several: the one that comes nearest to refuting the claim.
pub(super) fn against_all(least: f64, effects: Vec<(String, Effect)>) -> Answer {
    let (count, first) = (effects.len(), effects.into_iter().min_by(nearest(least)));
    let Some((effect, own)) = first else { return lacks("test parts that the networks share") };
    let of = if count > 1 { format!("; nearest of {count}") } else { String::new() };
    above(least, format!("{effect}{of}"), own)
}

/// Accuracy of the first less that of the second, in points.
pub(super) fn accuracy(both: &[Answers]) -> Option<f64> {
    Some(both[0].accuracy(None) - both[1].accuracy(None))
}

/// `own` is less than `margin` points worse than each of `others`.
pub(super) fn not_worse(run: &Benchmark, own: &Entry, others: &[&Entry], margin: f64) -> Result<Answer> {
    let mut effects = vec![];
    for other in others {
        if let Some(effect) = run.comparison.effect(&[&own.name, &other.name], &accuracy, 0.95)? {
            let effect_text =
                format!("accuracy: {} less {}, points; holds above -{margin}", own.name, other.name);
            effects.push((effect_text, effect));
        }
    }
    Ok(against_all(-margin, effects))
}
