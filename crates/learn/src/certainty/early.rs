//! How often a model is right that decides before a sample is whole.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::certainty::answers::answers;
use crate::certainty::held_out::HeldOut;
use crate::certainty::temperature::{fitted_temperature, tempered};
use crate::metrics::{Levels, wilson};

/// Confidences that are tried.
const CONFIDENCES: [f64; 7] = [0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99];
/// One-sided 95 % quantile of the normal distribution.
const Z: f64 = 1.645;

/// Early decisions of held-out samples at one confidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EarlyRecord {
    /// The probability that the likeliest class of every attribute must reach, 0..1.
    pub confidence: f64,
    /// Samples that were decided before they were whole.
    pub decided: usize,
    /// Of all samples.
    pub of: usize,
    /// Share of the samples decided early that were right in every attribute, 0..1; 0 without any.
    pub right: f64,
    /// Mean share of a sample, of all, that had been seen when it was decided, 0..1.
    pub seen: f64,
    /// The share of the commonest answer, 0..1: what is right by chance.
    pub chance: f64,
}

impl EarlyRecord {
    /// Decides the samples of `starts` (the first tenth of each, the first two, ..., the whole) at each confidence, each part with
    /// the temperatures of the others.
    pub(super) fn all(starts: &[HeldOut], levels: &Levels) -> Vec<Self> {
        let Some(whole) = starts.last().filter(|whole| !whole.is_empty()) else { return vec![] };
        let sure: Vec<BTreeMap<(u32, usize), (f64, bool)>> =
            starts.iter().map(|start| by_place(start, levels)).collect();
        let mut counts: BTreeMap<&[u32], usize> = BTreeMap::new();
        whole
            .truth
            .chunks_exact(levels.sizes().len())
            .for_each(|labels| *counts.entry(labels).or_default() += 1);
        let commonest = counts.values().max().copied().unwrap_or(0);
        let record = |&confidence: &f64| {
            let (mut decided, mut right, mut seen) = (0, 0, 0.0);
            for place in sure[starts.len() - 1].keys() {
                let answer = |at: &usize| sure[*at].get(place).filter(|(sure, _)| *sure >= confidence);
                let at = (0..starts.len() - 1).find(|at| answer(at).is_some());
                seen += at.map_or(1.0, |at| (at + 1) as f64 / starts.len() as f64);
                if let Some((_, is_right)) = at.and_then(|at| answer(&at)) {
                    decided += 1;
                    right += usize::from(*is_right);
                }
            }
            EarlyRecord {
                confidence,
                decided,
                of: whole.len(),
                right: right as f64 / decided.max(1) as f64,
                seen: seen / whole.len() as f64,
                chance: commonest as f64 / whole.len() as f64,
            }
        };
        CONFIDENCES.iter().map(record).collect()
    }

    /// Checks whether decisions at this confidence are no better than chance, as far as held-out samples can tell: the lower
    /// end of a one-sided 95 % interval (Wilson 1927) is not above the share of the commonest answer. False without a decision.
    pub fn is_chance(&self) -> bool {
        self.decided > 0 && wilson(self.right, self.decided as f64, Z)[0] <= self.chance
    }
}

/// Returns how sure the answer to each sample is, the least of all attributes, and whether all are right: by part and position in
/// the data set.
fn by_place(start: &HeldOut, levels: &Levels) -> BTreeMap<(u32, usize), (f64, bool)> {
    let mut all = BTreeMap::new();
    for part in start.each_part() {
        let others = start.select(|row| start.parts[row] != part);
        let own = start.select(|row| start.parts[row] == part);
        let temperature = fitted_temperature(&others.probabilities, &others.truth, levels.sizes());
        let mut probabilities = own.probabilities;
        tempered(&mut probabilities, levels.sizes(), temperature.unwrap_or(1.0));
        for (place, answers) in own.rows.iter().zip(answers(&probabilities, &own.truth, levels)) {
            let least = answers.iter().map(|(sure, _)| *sure).fold(1.0, f64::min);
            all.insert((part, *place), (least, answers.iter().all(|(_, right)| *right)));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers to 200 samples of two classes: of `tenth` tenths all are `sure` and right in `right` of 100.
    fn start(right: usize, sure: f32) -> HeldOut {
        let truth: Vec<u32> = (0..200).map(|sample| sample % 2).collect();
        let answer = |(sample, label): (usize, &u32)| {
            let is_right = sample / 2 % 100 < right;
            let class = if is_right { *label } else { 1 - *label };
            if class == 0 { [sure, 1.0 - sure] } else { [1.0 - sure, sure] }
        };
        let probabilities = truth.iter().enumerate().flat_map(answer).collect();
        HeldOut { probabilities, truth, parts: vec![0; 200], rows: (0..200).collect(), ..HeldOut::default() }
    }

    #[test]
    fn beginnings_that_know_nothing_are_chance_and_do_not_decide() {
        let starts: Vec<HeldOut> =
            (1..=10).map(|tenth| start(if tenth < 6 { 50 } else { 97 }, 0.92)).collect();
        let records = EarlyRecord::all(&starts, &Levels::new(&[2]));
        assert_eq!(records.len(), CONFIDENCES.len());
        // One part alone has no temperature of others: as sure as it says.
        let at_90 = records[4];
        assert_eq!((at_90.decided, at_90.chance), (200, 0.5));
        assert!((at_90.seen - 0.1).abs() < 1e-9, "{at_90:?}");
        assert!(at_90.is_chance() && !records[5].is_chance(), "0.95 is never reached: {records:?}");
        let parts =
            |held: &HeldOut| HeldOut { parts: (0..200).map(|row| row / 2 % 2).collect(), ..held.clone() };
        let apart = EarlyRecord::all(&starts.iter().map(parts).collect::<Vec<_>>(), &Levels::new(&[2]));
        assert!(
            apart[4].decided == 200 && (apart[4].seen - 0.6).abs() < 1e-9,
            "calibrated beginnings wait: {apart:?}"
        );
        assert!(!apart[4].is_chance() && apart[4].right > 0.95);
    }
}
