//! Held-out answers sorted by how sure they are.

use serde::{Deserialize, Serialize};

use crate::metrics::BINS;

/// Answers of about the same certainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReliabilityBin {
    /// Number of answers, over all attributes.
    pub answers: usize,
    /// Their mean probability, 0..1.
    pub sure: f64,
    /// The share that is right, 0..1.
    pub right: f64,
}

/// How often held-out answers are right: by their probability, and if only the surest are given.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reliability {
    /// Bins of equal width that have answers, the least sure first (DeGroot & Fienberg 1983).
    pub bins: Vec<ReliabilityBin>,
    /// The share that is right among the surest 10 %, 20 %, ... of the answers, 0..1 (risk and coverage: El-Yaniv & Wiener
    /// 2010).
    pub surest: Vec<f64>,
}

impl Reliability {
    /// Sorts held-out answers, each part at the temperature of the others.
    pub(super) fn of(answers: &[Vec<(f64, bool)>]) -> Self {
        let mut all: Vec<(f64, bool)> = answers.concat();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mean = |of: &[(f64, bool)], value: fn(&(f64, bool)) -> f64| {
            of.iter().map(value).sum::<f64>() / of.len() as f64
        };
        let right: fn(&(f64, bool)) -> f64 = |answer| f64::from(u8::from(answer.1));
        let number = |sure: f64| ((sure * BINS as f64).ceil() as usize).clamp(1, BINS);
        let mut bins: Vec<ReliabilityBin> = all
            .chunk_by(|a, b| number(a.0) == number(b.0))
            .map(|bin| ReliabilityBin {
                answers: bin.len(),
                sure: mean(bin, |answer| answer.0),
                right: mean(bin, right),
            })
            .collect();
        bins.reverse();
        let share = |tenth: usize| {
            let count = (all.len() * tenth).div_ceil(10);
            (count > 0).then(|| mean(&all[..count], right))
        };
        Reliability { bins, surest: (1..=10).filter_map(share).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certainty::answers::answers;
    use crate::metrics::Levels;

    #[test]
    fn the_surest_answers_come_first_and_bins_hold_all() {
        let probabilities = [[0.9f32, 0.1], [0.8, 0.2], [0.55, 0.45], [0.2, 0.8]].concat().repeat(10);
        let truth = [0, 0, 1, 0].repeat(10);
        let found = Reliability::of(&answers(&probabilities, &truth, &Levels::new(&[2])));
        assert_eq!(found.bins.iter().map(|bin| bin.answers).sum::<usize>(), 40);
        assert!(found.bins.is_sorted_by(|a, b| a.sure < b.sure));
        assert_eq!((found.surest[1], found.surest[9], found.surest.len()), (1.0, 0.5, 10));
    }
}
