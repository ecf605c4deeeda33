//! Scores on the starts of test samples: what a stream that is decided early may expect.

use ndarray::{ArrayD, Axis};
use rayon::prelude::*;
use taxel_data::Padding;
use taxel_learn::metrics::{Metric, Outcome};

use super::parts::{BATCH, RawOutputs, TestPart, outcome, parts, predict};
use super::threads::on;
use crate::case::Case;
use crate::error::Result;
use crate::values::{Early, EarlyDecisions, EarlyNetwork, EarlyPoint};

/// Shares of a sample that are there, in %.
pub(super) const SHARES: [u8; 10] = [10, 20, 30, 40, 50, 60, 70, 80, 90, 100];
/// Confidences at which is decided.
const CONFIDENCES: [f64; 7] = [0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99];

/// Options of the scores on starts of samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EarlyOptions {
    /// At most so many test samples of each network; the others are left out evenly. Default 1000.
    pub samples: usize,
    /// Worker threads, at most one per core; results do not depend on them.
    pub threads: usize,
}

impl Default for EarlyOptions {
    fn default() -> Self {
        EarlyOptions { samples: 1000, threads: taxel_learn::threads(None) }
    }
}

/// Scores of one network on the starts of its test samples, share by share.
struct EarlyScores {
    /// Contribution of each sample to the primary metric.
    terms: Vec<Vec<f64>>,
    /// Of each sample the least of the attributes' highest probabilities; below 0 where it was refused. Nothing of
    /// values.
    sure: Vec<Vec<f32>>,
    refused: Vec<usize>,
}

/// Scores the saved networks of a run on the starts of test samples, filled up as `taxel stream` does it. None for
/// samples without time.
///
/// # Errors
/// Models that are missing.
pub(super) fn early(case: &Case, options: &EarlyOptions) -> Result<Option<Early>> {
    let spec = &case.dataset.spec;
    let (_, ticks, _) = spec.around_time();
    if spec.layout.time_axis().is_none() || ticks < 2 {
        return Ok(None);
    }
    let names = case.compared();
    let (parts, of) = parts(case, &names, options.samples)?;
    let padding = spec.padding();
    let mut all: Vec<EarlyScores> = names.iter().map(|_| EarlyScores::new()).collect();
    for part in &parts {
        let clean = case.dataset.x.select(Axis(0), &part.rows);
        let starts: Vec<ArrayD<f32>> = SHARES.map(|seen| started(case, &clean, seen, padding)).into();
        for key in &part.keys {
            let predictor = case.model(key)?.predictor(BATCH, 1)?;
            let Some(at) = names.iter().position(|name| *name == key.network) else { continue };
            let predict = || starts.par_iter().map(|start| predict(&predictor, &clean, start)).collect();
            all[at].add(case, part, on(taxel_learn::threads(Some(options.threads)), predict)?);
        }
    }
    let mut folds: Vec<(usize, usize)> = parts.iter().map(|part| (part.fold, part.len())).collect();
    folds.sort_unstable();
    folds.dedup();
    let metric = case.primary().metric();
    let networks = names.iter().zip(all).map(|(name, network)| network.network(name, metric)).collect();
    let samples = folds.into_iter().map(|(_, count)| count).sum();
    Ok(Some(Early { samples, of, ticks, padding, networks }))
}

/// Returns the first `seen` % of each sample, at least one reading, filled up.
pub(super) fn started(case: &Case, clean: &ArrayD<f32>, seen: u8, padding: Padding) -> ArrayD<f32> {
    let (before, ticks, after) = case.dataset.spec.around_time();
    let known = known(ticks, seen);
    let mut starts = clean.as_standard_layout().into_owned();
    if let Some(values) = starts.as_slice_mut() {
        for sample in values.chunks_exact_mut((before * ticks * after).max(1)) {
            padding.fill(sample, (before, after), known);
        }
    }
    starts
}

/// Returns the number of readings that are `seen` % of `ticks`.
fn known(ticks: usize, seen: u8) -> usize {
    (ticks * usize::from(seen)).div_ceil(100)
}

impl EarlyScores {
    fn new() -> Self {
        let count = SHARES.len();
        EarlyScores { terms: vec![vec![]; count], sure: vec![vec![]; count], refused: vec![0; count] }
    }

    /// Adds the outputs of one model for the starts of its test part, share by share.
    fn add(&mut self, case: &Case, part: &TestPart, shares: Vec<RawOutputs>) {
        let (task, levels) = (case.task(), case.levels());
        for (at, outputs) in shares.into_iter().enumerate() {
            let (first, refused) = (self.sure[at].len(), outputs.refused.clone());
            let outcome = outcome(&case.dataset.targets, part, outputs);
            self.terms[at].extend(Metric::primary(task).terms(task, &outcome).unwrap_or_default());
            self.refused[at] += refused.len();
            if let Outcome::Labels { probabilities, .. } = &outcome {
                let rows = probabilities.chunks_exact(levels.outputs().max(1));
                self.sure[at].extend(rows.map(|row| levels.confidence(row)));
                // No prediction is never sure.
                refused.iter().for_each(|row| self.sure[at][first + row] = -1.0);
            }
        }
    }

    fn network(self, name: &str, metric: &Metric) -> EarlyNetwork {
        let count = self.terms[0].len().max(1) as f64;
        let scale = metric.unit.scale();
        let point = |(at, &seen): (usize, &u8)| {
            let score = scale * self.terms[at].iter().sum::<f64>() / count;
            EarlyPoint { seen, score, refused: self.refused[at] }
        };
        // Values are as likely at one start as at another.
        let is_sure_of_any = self.sure.iter().any(|sure| !sure.is_empty());
        let confidences = if is_sure_of_any { &CONFIDENCES[..] } else { &[] };
        let decided = |&confidence: &f64| {
            let last = SHARES.len() - 1;
            let (mut right, mut seen, mut early) = (0.0, 0.0, 0);
            for sample in 0..self.terms[last].len() {
                let is_sure = |at: &usize| self.sure[*at][sample] >= confidence as f32;
                let at = (0..last).find(is_sure).unwrap_or(last);
                right += self.terms[at][sample];
                seen += f64::from(SHARES[at]);
                early += usize::from(at < last);
            }
            let percent = |value: f64| 100.0 * value / count;
            EarlyDecisions {
                confidence,
                score: percent(right),
                seen: seen / count,
                early: percent(early as f64),
            }
        };
        EarlyNetwork {
            network: name.into(),
            points: SHARES.iter().enumerate().map(point).collect(),
            decisions: confidences.iter().map(decided).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use taxel_data::Task;

    use super::*;

    #[test]
    fn a_share_is_at_least_one_reading() {
        assert_eq!(
            [known(50, 10), known(50, 100), known(3, 10), known(3, 50), known(300, 30)],
            [5, 50, 1, 2, 90]
        );
    }

    #[test]
    fn a_sample_is_decided_at_the_first_share_that_is_sure() {
        let mut scores = EarlyScores::new();
        // One sample: wrong and unsure up to 40 %, sure and wrong at 50 %, right from 60 % on. One that is refused early.
        for (at, seen) in SHARES.iter().enumerate() {
            scores.terms[at] = vec![f64::from(u8::from(*seen > 50)), 1.0];
            scores.sure[at] = vec![if *seen < 50 { 0.4 } else { 0.75 }, if *seen < 30 { -1.0 } else { 0.96 }];
        }
        scores.refused[0] = 1;
        let network = scores.network("own", Metric::primary(&Task::Classes(vec![])));
        let accuracies: Vec<f64> = network.points.iter().map(|point| point.score).collect();
        assert_eq!(accuracies, [50.0, 50.0, 50.0, 50.0, 50.0, 100.0, 100.0, 100.0, 100.0, 100.0]);
        assert_eq!((network.points[0].seen, network.points[0].refused), (10, 1));
        let of = |confidence: f64| {
            network.decisions.iter().find(|decision| decision.confidence == confidence).copied()
        };
        let want = |confidence, score, seen, early| Some(EarlyDecisions { confidence, score, seen, early });
        assert_eq!(of(0.7), want(0.7, 50.0, 40.0, 100.0));
        assert_eq!(of(0.95), want(0.95, 100.0, 65.0, 50.0));
        assert_eq!(of(0.99), want(0.99, 100.0, 100.0, 0.0));
    }
}
