//! Accuracy on the starts of test samples: what a stream that is decided early may expect.

use ndarray::{ArrayD, Axis};
use rayon::prelude::*;
use taxel_data::Padding;
use taxel_learn::metrics::Levels;

use super::parts::{BATCH, Part, ask, parts};
use super::threads::on;
use crate::case::Case;
use crate::error::Result;
use crate::values::{Early, EarlyDecisions, EarlyNetwork, EarlyPoint};

/// Shares of a sample that are there, in %.
const SHARES: [u8; 10] = [10, 20, 30, 40, 50, 60, 70, 80, 90, 100];
/// Confidences at which is decided.
const CONFIDENCES: [f64; 7] = [0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99];

/// What starts of samples may cost.
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

/// Probabilities of samples, and those that were refused.
type Answer = (Vec<f32>, Vec<usize>);

/// The answers of one network to the test samples of its folds, each share by itself.
struct Answers {
    /// Of each sample the share of attributes that are right.
    right: Vec<Vec<f64>>,
    /// Of each sample the least of the attributes' highest probabilities; below 0 where it was refused.
    sure: Vec<Vec<f32>>,
    refused: Vec<usize>,
}

/// Asks the saved networks of a run about the starts of test samples, filled up as `taxel stream` does it. None for
/// samples without time.
///
/// # Errors
/// Models that are missing.
pub(super) fn early(case: &Case, options: &EarlyOptions) -> Result<Option<Early>> {
    let reading = &case.dataset.reading;
    let (_, ticks, _) = reading.around_time();
    if reading.layout.time_axis().is_none() || ticks < 2 {
        return Ok(None);
    }
    let names = case.compared();
    let (parts, of) = parts(case, &names, options.samples)?;
    let padding = reading.padding();
    let mut all: Vec<Answers> = names.iter().map(|_| Answers::new()).collect();
    for part in &parts {
        let clean = case.dataset.x.select(Axis(0), &part.rows);
        let starts: Vec<ArrayD<f32>> = SHARES.map(|seen| started(case, &clean, seen, padding)).into();
        for key in &part.keys {
            let predictor = case.model(key)?.predictor(BATCH, 1)?;
            let Some(own) = names.iter().position(|name| *name == key.network) else { continue };
            let ask = || starts.par_iter().map(|start| ask(&predictor, &clean, start)).collect();
            let answers: Vec<Answer> = on(taxel_learn::threads(Some(options.threads)), ask)?;
            all[own].hear(part, answers, &case.levels());
        }
    }
    let mut folds: Vec<(usize, usize)> = parts.iter().map(|part| (part.fold, part.len())).collect();
    folds.sort_unstable();
    folds.dedup();
    let networks = names.iter().zip(all).map(|(name, own)| own.network(name)).collect();
    let samples = folds.into_iter().map(|(_, count)| count).sum();
    Ok(Some(Early { samples, of, ticks, padding, networks }))
}

/// The first `seen` % of each sample, at least one reading, filled up.
fn started(case: &Case, clean: &ArrayD<f32>, seen: u8, padding: Padding) -> ArrayD<f32> {
    let (before, ticks, after) = case.dataset.reading.around_time();
    let known = known(ticks, seen);
    let mut starts = clean.as_standard_layout().into_owned();
    if let Some(values) = starts.as_slice_mut() {
        for sample in values.chunks_exact_mut((before * ticks * after).max(1)) {
            padding.fill(sample, (before, after), known);
        }
    }
    starts
}

/// Readings that are `seen` % of `ticks`.
fn known(ticks: usize, seen: u8) -> usize {
    (ticks * usize::from(seen)).div_ceil(100)
}

impl Answers {
    fn new() -> Self {
        let count = SHARES.len();
        Answers { right: vec![vec![]; count], sure: vec![vec![]; count], refused: vec![0; count] }
    }

    /// Hears the answers of one model to the samples of its test part, share by share.
    fn hear(&mut self, part: &Part, answers: Vec<Answer>, levels: &Levels) {
        let width = part.truth.len() / part.len().max(1);
        for (at, (probabilities, refused)) in answers.into_iter().enumerate() {
            let predicted = levels.predicted(&probabilities);
            let rows = predicted.chunks_exact(width.max(1)).zip(part.truth.chunks_exact(width.max(1)));
            let right = rows.map(|(own, truth)| own.iter().zip(truth).filter(|(a, b)| a == b).count() as f64);
            let sure = probabilities.chunks_exact(levels.outputs().max(1)).map(|row| least_sure(row, levels));
            let first = self.right[at].len();
            self.right[at].extend(right.map(|count| count / width.max(1) as f64));
            self.sure[at].extend(sure);
            for row in refused {
                // No answer: never right, and never sure.
                (self.right[at][first + row], self.sure[at][first + row]) = (0.0, -1.0);
                self.refused[at] += 1;
            }
        }
    }

    fn network(self, name: &str) -> EarlyNetwork {
        let count = self.right[0].len().max(1) as f64;
        let point = |(at, &seen): (usize, &u8)| {
            let accuracy = 100.0 * self.right[at].iter().sum::<f64>() / count;
            EarlyPoint { seen, accuracy, refused: self.refused[at] }
        };
        let decided = |confidence: f64| {
            let last = SHARES.len() - 1;
            let (mut right, mut seen, mut early) = (0.0, 0.0, 0);
            for sample in 0..self.right[last].len() {
                let is_sure = |at: &usize| self.sure[*at][sample] >= confidence as f32;
                let at = (0..last).find(is_sure).unwrap_or(last);
                right += self.right[at][sample];
                seen += f64::from(SHARES[at]);
                early += usize::from(at < last);
            }
            let percent = |value: f64| 100.0 * value / count;
            EarlyDecisions {
                confidence,
                accuracy: percent(right),
                seen: seen / count,
                early: percent(early as f64),
            }
        };
        EarlyNetwork {
            network: name.into(),
            points: SHARES.iter().enumerate().map(point).collect(),
            decisions: CONFIDENCES.map(decided).into(),
        }
    }
}

/// The least of the attributes' highest probabilities.
fn least_sure(row: &[f32], levels: &Levels) -> f32 {
    let mut rest = row;
    let highest = |size: &usize| {
        let (own, after) = rest.split_at(*size);
        rest = after;
        own.iter().copied().fold(0.0f32, f32::max)
    };
    levels.sizes().iter().map(highest).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
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
        let mut own = Answers::new();
        // One sample: wrong and unsure up to 40 %, sure and wrong at 50 %, right from 60 % on. One that is refused early.
        for (at, seen) in SHARES.iter().enumerate() {
            own.right[at] = vec![f64::from(u8::from(*seen > 50)), 1.0];
            own.sure[at] = vec![if *seen < 50 { 0.4 } else { 0.75 }, if *seen < 30 { -1.0 } else { 0.96 }];
        }
        own.refused[0] = 1;
        let network = own.network("own");
        let accuracies: Vec<f64> = network.points.iter().map(|point| point.accuracy).collect();
        assert_eq!(accuracies, [50.0, 50.0, 50.0, 50.0, 50.0, 100.0, 100.0, 100.0, 100.0, 100.0]);
        assert_eq!((network.points[0].seen, network.points[0].refused), (10, 1));
        let of = |confidence: f64| network.decisions.iter().find(|own| own.confidence == confidence).copied();
        let want =
            |confidence, accuracy, seen, early| Some(EarlyDecisions { confidence, accuracy, seen, early });
        assert_eq!(of(0.7), want(0.7, 50.0, 40.0, 100.0));
        assert_eq!(of(0.95), want(0.95, 100.0, 65.0, 50.0));
        assert_eq!(of(0.99), want(0.99, 100.0, 100.0, 0.0));
        assert_eq!(least_sure(&[0.2, 0.8, 0.5, 0.3, 0.2], &Levels::new(&[2, 3])), 0.5);
    }
}
