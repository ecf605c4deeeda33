//! Intervals that hold the true value as often as they say.

use std::collections::BTreeSet;
use std::fmt::{self, Display, Formatter};

use ndarray::{ArrayRef, IxDyn};
use serde::{Deserialize, Serialize};
use taxel_data::{Dataset, Layout};

use crate::certainty::fitted::{FittedOn, HeldOutParts};
use crate::certainty::gate::Gates;
use crate::certainty::held_out::{LEAST, conformal_rank, large_groups};
use crate::certainty::readings::Readings;
use crate::certainty::sets::SHARES;
use crate::metrics::Outcome;
use crate::run::records::FoldRecord;

/// Values that a model has answered without having learned them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeldOutValues {
    /// Number of quantities.
    pub quantities: usize,
    /// True values `[n, quantities]`.
    pub truth: Vec<f32>,
    /// The answers `[n, quantities]`.
    pub predicted: Vec<f32>,
    /// How far below and above the model itself expects the true value, `[n, quantities, 2]`; empty where it says nothing of it.
    pub spread: Vec<f32>,
    /// The part of the split that each sample was tested in, `[n]`.
    pub parts: Vec<u32>,
    /// The position of each sample in the data set, `[n]`; empty where that is not known.
    pub rows: Vec<usize>,
    /// The group of each sample, `[n]`; none without groups.
    pub groups: Option<Vec<u32>>,
}

impl HeldOutValues {
    /// Gathers the test parts of the folds of one row of a run. None of classes.
    pub fn of_folds<'r>(
        records: impl IntoIterator<Item = &'r FoldRecord>,
        dataset: &Dataset,
    ) -> Option<Self> {
        let quantities = dataset.targets.values()?.quantities().len();
        let groups = dataset.groups.as_ref().map(|_| vec![]);
        let mut held = HeldOutValues { quantities, groups, ..HeldOutValues::default() };
        for (part, record) in records.into_iter().filter(|record| !record.diverged).enumerate() {
            let Outcome::Values { truth, predicted, spread } = &record.outcome else { return None };
            held.truth.extend(truth);
            held.predicted.extend(predicted);
            held.spread.extend(spread);
            held.parts.extend(record.index.iter().map(|_| part as u32));
            held.rows.extend(&record.index);
            if let (Some(held), Some(groups)) = (&mut held.groups, &dataset.groups) {
                held.extend(record.index.iter().map(|row| groups[*row]));
            }
        }
        Some(held)
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Checks whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Returns the error of each sample for one quantity, in its spread.
    fn errors(&self, quantity: usize) -> Vec<f64> {
        let of_row = |row: usize| {
            let at = row * self.quantities + quantity;
            let missing = f64::from(self.truth[at]) - f64::from(self.predicted[at]);
            let side = usize::from(missing > 0.0);
            missing.abs() / self.spread.get(2 * at + side).map_or(1.0, |around| f64::from(*around))
        };
        (0..self.len()).map(of_row).collect()
    }
}

/// Intervals around the answers of a model, fitted to held-out errors.
///
/// # Reference
/// Split conformal prediction (Lei et al. 2018) by the folds of a run; of a network that says how far off it may be, with errors
/// counted in that (Papadopoulos et al. 2002; Romano, Patterson and Candès 2019).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intervals {
    /// The predictions that they were fitted on.
    pub fitted_on: FittedOn,
    /// At 80, 90, 95 and 99 %, as far as there are enough predictions.
    pub at: Vec<IntervalAt>,
    /// Whether the readings of a sample are like those that were learned; none where they were too few, or all equal. No interval
    /// holds what it says for others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub readings: Option<Readings>,
}

/// Intervals that hold the true value in one share of samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IntervalAt {
    /// Share of samples whose interval is to hold the true value, 0..1.
    pub share: f64,
    /// Half the interval of each quantity, in its unit; of a model that says how far off it may be, in that.
    pub half: Vec<f64>,
    /// Share of held-out samples whose interval held the true value, 0..1, each part with the intervals of the others; mean
    /// over the quantities.
    pub covered: f64,
    /// The same in the worst group of five samples or more; none without groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_group: Option<f64>,
    /// Mean width of the intervals of each quantity, in its unit.
    pub width: Vec<f64>,
}

impl Intervals {
    /// Fits intervals to held-out values of the data set of that digest. None of fewer than 30 samples.
    pub fn fit(held: &HeldOutValues, parts: HeldOutParts, digest: &str) -> Option<Self> {
        if held.len() < LEAST {
            return None;
        }
        let errors: Vec<Vec<f64>> = (0..held.quantities).map(|quantity| held.errors(quantity)).collect();
        let fitted_on = FittedOn::of(held.len(), held.groups.as_deref(), parts, digest);
        let at = SHARES.into_iter().filter_map(|share| IntervalAt::fit(held, &errors, share)).collect();
        Some(Intervals { fitted_on, at, readings: None })
    }

    /// Fits the gate of readings to the held-out samples, rows of the raw samples `x` `[n, ..]` of that layout. What has too few
    /// samples is left out.
    pub fn with_readings(self, held: &HeldOutValues, raw: (Layout, &ArrayRef<f32, IxDyn>)) -> Self {
        let groups = held.groups.as_deref().filter(|_| self.fitted_on.parts == HeldOutParts::Groups);
        Intervals { readings: Gates::of_readings(&held.rows, groups, raw).readings, ..self }
    }

    /// Widens the intervals by so much of each quantity, in its unit; of a model that says how far off it may be, in that.
    pub fn widened(self, more: &[f64]) -> Self {
        let wider = |mut at: IntervalAt| {
            for ((half, width), more) in at.half.iter_mut().zip(&mut at.width).zip(more) {
                *width *= if *half > 0.0 { (*half + more) / *half } else { 1.0 };
                *half += more;
            }
            at
        };
        Intervals { at: self.at.into_iter().map(wider).collect(), ..self }
    }

    /// Returns the intervals at a share of 0.8, 0.9, 0.95 or 0.99.
    pub fn at(&self, share: f64) -> Option<&IntervalAt> {
        self.at.iter().find(|at| (at.share - share).abs() < 1e-9)
    }
}

impl IntervalAt {
    fn fit(held: &HeldOutValues, errors: &[Vec<f64>], share: f64) -> Option<Self> {
        let halves = |keep: &dyn Fn(usize) -> bool| -> Option<Vec<f64>> {
            let of_quantity = |errors: &Vec<f64>| {
                let kept = errors.iter().enumerate().filter(|(row, _)| keep(*row)).map(|(_, error)| *error);
                quantile(kept.collect(), share)
            };
            errors.iter().map(of_quantity).collect()
        };
        let half = halves(&|_| true)?;
        let mut covered = vec![0.0; held.len()];
        for part in held.parts.iter().collect::<BTreeSet<_>>() {
            // A single part, or too few others: the intervals of all.
            let others = halves(&|row| held.parts[row] != *part).unwrap_or_else(|| half.clone());
            for row in (0..held.len()).filter(|row| held.parts[*row] == *part) {
                let held = errors.iter().zip(&others).filter(|(errors, half)| errors[row] <= **half).count();
                covered[row] = held as f64 / errors.len() as f64;
            }
        }
        let mean = |rows: &[usize]| rows.iter().map(|row| covered[*row]).sum::<f64>() / rows.len() as f64;
        let width =
            half.iter().enumerate().map(|(quantity, half)| half * mean_spread(held, quantity)).collect();
        Some(IntervalAt {
            share,
            covered: mean(&(0..held.len()).collect::<Vec<_>>()),
            worst_group: large_groups(held.groups.as_deref())
                .iter()
                .map(|rows| mean(rows))
                .min_by(f64::total_cmp),
            width,
            half,
        })
    }

    /// Returns the ends of the interval of one quantity; `around` is how far below and above the model expects the true value, 1
    /// where it says nothing of it.
    pub fn ends(&self, quantity: usize, answer: f32, around: [f32; 2]) -> [f32; 2] {
        let half = self.half.get(quantity).copied().unwrap_or(f64::INFINITY);
        let [below, above] = around.map(|distance| half * f64::from(distance));
        [(f64::from(answer) - below) as f32, (f64::from(answer) + above) as f32]
    }
}

/// Returns the mean width of an interval of half 1.
fn mean_spread(held: &HeldOutValues, quantity: usize) -> f64 {
    if held.spread.is_empty() {
        return 2.0;
    }
    let rows = held.spread.chunks_exact(2 * held.quantities);
    rows.map(|row| f64::from(row[2 * quantity]) + f64::from(row[2 * quantity + 1])).sum::<f64>()
        / held.len() as f64
}

/// Returns the error that the share of n + 1 errors does not pass; none where n are too few.
fn quantile(mut errors: Vec<f64>, share: f64) -> Option<f64> {
    errors.sort_by(f64::total_cmp);
    errors.get(conformal_rank(errors.len(), share)).copied()
}

impl Display for Intervals {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let FittedOn { samples, groups, .. } = &self.fitted_on;
        write!(f, "intervals fitted on {samples} held-out predictions")?;
        groups.map_or(Ok(()), |groups| write!(f, " of {groups} groups"))?;
        let Some(IntervalAt { share, covered, worst_group, width, .. }) = self.at(0.9) else { return Ok(()) };
        write!(f, "; those of 90 % covered {:.1} %", 100.0 * covered)?;
        worst_group.map_or(Ok(()), |worst| write!(f, ", {:.1} in the worst group", 100.0 * worst))?;
        let widths: Vec<String> = width.iter().map(|width| format!("{width:.3}")).collect();
        write!(f, ", mean width {}", widths.join(" and "))?;
        self.fitted_on.unpromised(*share).map_or(Ok(()), |words| write!(f, "; {words}"))?;
        let gate = if self.readings.is_some() { "says unknown" } else { "does not say unknown" };
        write!(f, "; {gate}")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use rand::RngExt;

    use super::*;

    /// Draws values whose error is one standard deviation of `sd(row)`.
    fn drawn(samples: usize, sd: impl Fn(usize) -> f32, says: bool) -> HeldOutValues {
        let mut rng = taxel_base::seed::rng(5, "intervals");
        let mut normal = || (0..12).map(|_| rng.random::<f32>()).sum::<f32>() - 6.0;
        let predicted: Vec<f32> = (0..samples).map(|_| 10.0 * normal()).collect();
        let truth = predicted.iter().enumerate().map(|(row, value)| value + sd(row) * normal()).collect();
        let spread = if says { (0..samples).flat_map(|row| [sd(row); 2]).collect() } else { vec![] };
        let parts: Vec<u32> = (0..samples as u32).map(|row| row % 5).collect();
        HeldOutValues {
            quantities: 1,
            truth,
            predicted,
            spread,
            groups: Some(parts.clone()),
            parts,
            rows: vec![],
        }
    }

    fn fit(held: &HeldOutValues) -> Option<Intervals> {
        Intervals::fit(held, HeldOutParts::Groups, "d")
    }

    #[test]
    fn they_cover_what_they_say_and_are_as_wide_as_errors_are() {
        let intervals = fit(&drawn(2000, |_| 2.0, false)).unwrap();
        for at in &intervals.at {
            assert!((at.covered - at.share).abs() < 0.02, "{at:?}");
            assert!(at.worst_group.unwrap() <= at.covered, "{at:?}");
        }
        // 90 % of a normal error of 2 lie within 1.645 times that.
        let ninety = intervals.at(0.9).unwrap();
        assert!((ninety.half[0] - 3.29).abs() < 0.2 && ninety.width[0] == 2.0 * ninety.half[0], "{ninety:?}");
        let [low, high] = ninety.ends(0, 5.0, [1.0, 1.0]);
        assert!((f64::from(high - low) - ninety.width[0]).abs() < 1e-5);
    }

    #[test]
    fn a_model_that_knows_its_spread_has_narrower_intervals_where_it_is_small() {
        let sd = |row: usize| if row.is_multiple_of(2) { 0.5 } else { 5.0 };
        let (knows, not) = (fit(&drawn(2000, sd, true)).unwrap(), fit(&drawn(2000, sd, false)).unwrap());
        let (knows, not) = (knows.at(0.9).unwrap(), not.at(0.9).unwrap());
        assert!(knows.width[0] < 0.8 * not.width[0], "{knows:?} {not:?}");
        assert!((knows.half[0] - 1.645).abs() < 0.1 && (knows.covered - 0.9).abs() < 0.02, "{knows:?}");
        let [low, high] = knows.ends(0, 0.0, [0.5, 1.0]);
        assert!((high / low + 2.0).abs() < 1e-5, "{low} {high}");
    }

    #[test]
    fn few_predictions_promise_little() {
        assert_eq!(fit(&drawn(29, |_| 1.0, false)), None);
        let shares: Vec<f64> =
            fit(&drawn(30, |_| 1.0, false)).unwrap().at.iter().map(|at| at.share).collect();
        assert_eq!(shares, [0.8, 0.9, 0.95]);
    }
}
