//! One comparison of a claim: its size, how sure it is, and what follows.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};
use taxel::judge::Effect;

use super::verdict::Verdict;

/// Difference that is not worth naming where the paper prints none, in points or percent.
pub(super) const POINT: f64 = 1.0;

/// A comparison of a claim on a run, or over several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contrast {
    /// The comparison and its unit: `accuracy: a less b, points`.
    pub effect: String,
    /// Size, in that unit.
    pub size: f64,
    /// Interval that must lie above a bound to support the claim; none where nothing tells how much it varies.
    pub interval: Option<[f64; 2]>,
    /// Interval that must lie below to refute it: wider, since one of several contrasts is enough (Bonferroni).
    pub refuting: Option<[f64; 2]>,
    /// Standard error.
    pub error: Option<f64>,
    /// Two-sided, for no difference.
    pub p: Option<f64>,
    /// Difference that is not worth naming; none of an effect in another unit than points or percent.
    pub margin: Option<f64>,
}

impl Contrast {
    /// Makes a contrast of an effect and the same at the confidence that refutes.
    pub(super) fn new(effect: String, measured: Effect, refuting: Effect) -> Self {
        Contrast {
            effect,
            size: measured.size,
            interval: measured.interval,
            refuting: refuting.interval,
            error: measured.error,
            p: measured.p,
            margin: Some(POINT),
        }
    }

    /// Returns what this contrast says of a claim that it supports above `least`.
    pub(crate) fn verdict(&self, least: f64) -> Verdict {
        let (Some([low, high]), Some([_, refuting])) = (self.interval, self.refuting) else {
            return Verdict::CannotBeTested;
        };
        let is_within = |margin: f64| least == 0.0 && -margin < low && high < margin;
        if low > least {
            Verdict::Holds
        } else if refuting <= least {
            Verdict::DoesNotHold
        } else if self.margin.is_some_and(is_within) {
            Verdict::NoDifference
        } else {
            Verdict::TooFewData
        }
    }

    /// Describes the contrast, the weakest of `count`.
    pub(crate) fn words(&self, least: f64, count: usize) -> String {
        let mut words = self.effect.clone();
        if least != 0.0 {
            words += &format!("; holds above {least}");
        }
        if count > 1 {
            words += &format!("; nearest of {count}");
        }
        match self.verdict(least) {
            Verdict::CannotBeTested => {
                words += "; the run lacks test parts or groups that tell how much it varies"
            }
            Verdict::NoDifference => words += &format!("; within ± {:.2}", self.margin.unwrap_or(POINT)),
            _ => {}
        }
        words
    }
}

/// Returns the contrast that comes nearest to refuting a claim: first one that does, then one that may, one without an
/// interval, one that shows no difference, one that supports it; of alike ones the one with the lowest bound.
pub(crate) fn weakest(least: f64, contrasts: &[Contrast]) -> Option<&Contrast> {
    contrasts.iter().min_by(|a, b| by_strength(least, a, b))
}

/// Returns the contrast that comes nearest to supporting a claim.
pub(super) fn strongest(least: f64, contrasts: &[Contrast]) -> Option<&Contrast> {
    contrasts.iter().max_by(|a, b| by_strength(least, a, b))
}

fn by_strength(least: f64, a: &Contrast, b: &Contrast) -> Ordering {
    let rank = |contrast: &Contrast| match contrast.verdict(least) {
        Verdict::DoesNotHold => 0,
        Verdict::TooFewData => 1,
        Verdict::CannotBeTested => 2,
        Verdict::NoDifference => 3,
        Verdict::Holds => 4,
    };
    let low = |contrast: &Contrast| contrast.interval.map_or(least, |[low, _]| low);
    rank(a).cmp(&rank(b)).then(low(a).total_cmp(&low(b)))
}
