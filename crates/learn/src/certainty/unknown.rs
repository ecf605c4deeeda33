//! A gate in front of classes that nobody learned: trainings without some of the classes.

use std::collections::HashSet;

use ndarray::{ArrayRef, Axis, IxDyn};
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use taxel_data::Layout;

use crate::certainty::gate::Gates;
use crate::certainty::held_out::HeldOut;
use crate::certainty::place::Place;
use crate::certainty::seen::FALSE_ALARMS;
use crate::metrics::Levels;
use crate::problem::{Problem, within};

/// Draws beyond those asked for, in place of classes that were drawn before.
const SPARE: usize = 50;

/// The `[unknown]` table: every row is trained without some classes, and its gate sees samples of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct UnknownTrial {
    /// Share of the classes that a training leaves out, (0, 1), at least one class. Default 0.25.
    pub hold_out: f64,
    /// Number of times that classes are drawn. Default 3.
    pub draws: usize,
}

impl Default for UnknownTrial {
    fn default() -> Self {
        UnknownTrial { hold_out: 0.25, draws: 3 }
    }
}

impl UnknownTrial {
    /// Checks the settings.
    ///
    /// # Errors
    /// A share or a number that is out of its range.
    pub fn check(&self) -> Result<(), Problem> {
        if !(self.hold_out > 0.0 && self.hold_out < 1.0) {
            return Err(Problem::new("hold_out", self.hold_out, "must be above 0 and below 1"));
        }
        within("draws", self.draws, 1, 100)
    }

    /// Draws the classes of `classes` that are left out, each time others; two are left at least. Fewer draws than asked for where
    /// there are no others, none of fewer than three classes.
    pub fn drawn(&self, classes: usize, seed: u64) -> Vec<Vec<u32>> {
        if classes < 3 {
            return vec![];
        }
        let count = ((self.hold_out * classes as f64).round() as usize).clamp(1, classes - 2);
        let mut draws: Vec<Vec<u32>> = vec![];
        for number in 0..self.draws + SPARE {
            if draws.len() == self.draws {
                break;
            }
            let mut all: Vec<u32> = (0..classes as u32).collect();
            all.shuffle(&mut taxel_base::seed::rng(seed, &format!("unknown/{number}")));
            all.truncate(count);
            all.sort_unstable();
            if !draws.contains(&all) {
                draws.push(all);
            }
        }
        draws
    }
}

/// Logits of a training without some classes for all samples of its test part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WithoutClasses {
    /// Classes that were left out, ascending.
    pub classes: Vec<u32>,
    /// The test part: a fold, or a repetition where each has one test part.
    pub fold: u32,
    /// Positions of its samples in the data set.
    pub rows: Vec<usize>,
    /// Their classes.
    pub truth: Vec<u32>,
    /// Their logits `[n, classes]`, those of the classes that were left out too.
    pub logits: Vec<f32>,
    /// Where the logits of its training samples lie, of the classes that were learned; none of a baseline.
    #[serde(alias = "own", default, skip_serializing_if = "Option::is_none")]
    pub places: Option<Vec<Place>>,
}

/// How well the gate of a row tells classes that it has not learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnknownScores {
    /// Name of the row.
    pub network: String,
    /// One for each draw of classes.
    pub draws: Vec<UnknownDraw>,
}

/// The gates of one draw of classes, each on a test part that it was not fitted on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnknownDraw {
    /// Classes that were left out.
    pub classes: Vec<u32>,
    /// Samples of classes that were learned.
    pub known: usize,
    /// Samples of classes that were not.
    pub unknown: usize,
    /// Probability that a sample of an unknown class is farther than one of a known class, 0..1: the area under the ROC curve.
    pub auroc: f64,
    /// The same of one less the highest probability: what no gate gives.
    pub auroc_softmax: f64,
    /// Share of the unknown samples that are refused at a familiarity of [`FALSE_ALARMS`], 0..1.
    pub refused: f64,
    /// Share of the known samples that are, 0..1: false alarms.
    pub false_alarms: f64,
}

impl UnknownDraw {
    /// Scores the trainings of one draw, one for each test part; `classes` is the number of all classes. A gate is fitted on the
    /// other parts without the samples that it is tried on and, where the split keeps `groups` together, those of their groups.
    /// None where one cannot be fitted.
    pub fn of(
        trainings: &[WithoutClasses],
        classes: usize,
        groups: Option<&[u32]>,
        (layout, x): (Layout, &ArrayRef<f32, IxDyn>),
    ) -> Option<Self> {
        let left_out = trainings.first()?.classes.clone();
        let kept: Vec<usize> = (0..classes).filter(|class| !left_out.contains(&(*class as u32))).collect();
        let levels = Levels::new(&[kept.len()]);
        let (mut known, mut unknown) = (vec![], vec![]);
        for own in trainings {
            let mut others = HeldOut::default();
            let group = |row: &usize| groups.map_or(*row, |groups| groups[*row] as usize);
            let tried: HashSet<usize> = own.rows.iter().map(group).collect();
            for other in trainings.iter().filter(|other| other.fold != own.fold) {
                other.add_known(&kept, classes, |row| !tried.contains(&group(row)), &mut others);
                others.places.extend(other.places.clone().map(|places| (other.fold, places)));
            }
            others.groups = groups.map(|groups| others.rows.iter().map(|row| groups[*row]).collect());
            let gates = Gates::fit(&others, (layout, x), &levels, groups.is_some(), own.places.as_ref());
            let gate = gates.seen.as_ref()?;
            let kept_only = |row: &[f32]| kept.iter().map(|class| row[*class]).collect::<Vec<f32>>();
            let logits: Vec<f32> = own.logits.chunks_exact(classes).flat_map(kept_only).collect();
            let familiarity = gates.familiarities(&logits, (layout, &x.select(Axis(0), &own.rows)))?;
            let mut scratch = vec![];
            let rows = own.truth.iter().zip(logits.chunks_exact(kept.len())).zip(familiarity);
            for ((label, row), familiarity) in rows {
                let scores = (gate.distance(row, &mut scratch), not_sure(row), familiarity);
                if left_out.contains(label) { unknown.push(scores) } else { known.push(scores) }
            }
        }
        let refused = |all: &[(f64, f64, f32)]| {
            all.iter().filter(|(.., familiarity)| *familiarity <= FALSE_ALARMS).count() as f64
                / all.len().max(1) as f64
        };
        let area = |score: fn(&(f64, f64, f32)) -> f64| {
            auroc(
                &known.iter().map(score).collect::<Vec<_>>(),
                &unknown.iter().map(score).collect::<Vec<_>>(),
            )
        };
        Some(UnknownDraw {
            classes: left_out,
            known: known.len(),
            unknown: unknown.len(),
            auroc: area(|scores| scores.0)?,
            auroc_softmax: area(|scores| scores.1)?,
            refused: refused(&unknown),
            false_alarms: refused(&known),
        })
    }
}

impl WithoutClasses {
    /// Finds where logits `[n, classes]` of the training samples lie, of which `truth` are the classes. None where they have no
    /// variance.
    pub fn places_of(left_out: &[u32], classes: usize, logits: &[f32], truth: &[u32]) -> Option<Vec<Place>> {
        let all = WithoutClasses {
            classes: left_out.to_vec(),
            fold: 0,
            rows: vec![0; truth.len()],
            truth: truth.to_vec(),
            logits: logits.to_vec(),
            places: None,
        };
        let kept: Vec<usize> = (0..classes).filter(|class| !left_out.contains(&(*class as u32))).collect();
        let mut held = HeldOut::default();
        all.add_known(&kept, classes, |_| true, &mut held);
        Place::of_logits(&held.logits, &held.truth, &Levels::new(&[kept.len()]))
    }

    /// Adds the samples `of` the data set whose classes were learned, numbered anew.
    fn add_known(&self, kept: &[usize], classes: usize, of: impl Fn(&usize) -> bool, held: &mut HeldOut) {
        let rows = self.truth.iter().zip(self.logits.chunks_exact(classes)).zip(&self.rows);
        for ((label, row), place) in rows.filter(|(_, place)| of(place)) {
            let Some(number) = kept.iter().position(|class| *class == *label as usize) else { continue };
            held.logits.extend(kept.iter().map(|class| row[*class]));
            held.probabilities.extend(kept.iter().map(|class| row[*class]));
            held.truth.push(number as u32);
            held.parts.push(self.fold);
            held.rows.push(*place);
        }
    }
}

/// Returns one less the highest probability of the softmax of a row.
fn not_sure(row: &[f32]) -> f64 {
    let highest = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    1.0 - 1.0 / row.iter().map(|value| f64::from(value - highest).exp()).sum::<f64>()
}

/// Returns the probability that a value of `high` is above one of `low`, halves for equal ones (Mann & Whitney 1947). None
/// where there are none.
fn auroc(low: &[f64], high: &[f64]) -> Option<f64> {
    let mut low = low.to_vec();
    low.sort_by(f64::total_cmp);
    let wins = |value: &f64| {
        let below = low.partition_point(|other| other < value);
        let not_above = low.partition_point(|other| other <= value);
        0.5 * (below + not_above) as f64
    };
    let pairs = (low.len() * high.len()) as f64;
    (pairs > 0.0).then(|| high.iter().map(wins).sum::<f64>() / pairs)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use ndarray::ArrayD;
    use rand::RngExt;

    use super::*;

    #[test]
    fn a_quarter_of_the_classes_is_drawn_and_two_are_left() {
        let trial = UnknownTrial::default();
        let draws = trial.drawn(28, 0);
        assert!(draws.len() == 3 && draws.iter().all(|drawn| drawn.len() == 7));
        assert_eq!((trial.drawn(28, 0), trial.drawn(2, 0)), (draws, vec![]));
        let all = UnknownTrial { hold_out: 0.99, ..trial };
        assert!(all.drawn(4, 0).iter().all(|drawn| drawn.len() == 2));
        // Of three classes there are three draws, none of them twice.
        for asked in [3, 7] {
            let mut draws = UnknownTrial { draws: asked, ..trial }.drawn(3, 0);
            draws.sort_unstable();
            assert_eq!(draws, [[0], [1], [2]]);
        }
        assert!(UnknownTrial { hold_out: 1.0, ..trial }.check().is_err() && trial.check().is_ok());
    }

    #[test]
    fn areas_are_those_of_all_pairs() {
        assert_eq!(auroc(&[1.0, 2.0, 2.0], &[2.0, 3.0]), Some((1.0 + 0.5 + 0.5 + 3.0) / 6.0));
        assert_eq!(auroc(&[], &[1.0]), None);
    }

    /// Scores trainings of samples without readings that tell anything.
    fn of(trainings: &[WithoutClasses], classes: usize, groups: Option<&[u32]>) -> Option<UnknownDraw> {
        UnknownDraw::of(trainings, classes, groups, (Layout::Features, &ArrayD::zeros(IxDyn(&[300, 4]))))
    }

    #[test]
    fn a_class_between_those_that_were_learned_is_refused() {
        let mut rng = taxel_base::seed::rng(4, "unknown");
        let mut noise = || (0..6).map(|_| rng.random::<f32>() - 0.5).sum::<f32>();
        let mut training = |fold: u32| {
            let truth: Vec<u32> = (0..60).map(|sample| sample % 4).collect();
            let logits = truth.iter().flat_map(|label| match label {
                3 => [4.0 + noise(), 4.0 + noise(), noise(), -3.0],
                other => [0, 1, 2, 9].map(|class| if class == *other { 8.0 } else { 0.0 } + noise()),
            });
            WithoutClasses {
                classes: vec![3],
                fold,
                rows: (60 * fold as usize..60 * fold as usize + 60).collect(),
                logits: logits.collect(),
                truth,
                places: None,
            }
        };
        let trainings: Vec<WithoutClasses> = (0..4).map(&mut training).collect();
        let scores = of(&trainings, 4, None).unwrap();
        assert_eq!((scores.known, scores.unknown), (180, 60));
        assert!(scores.auroc > 0.98 && scores.refused > 0.9 && scores.false_alarms < 0.12, "{scores:?}");
        assert!(of(&trainings[..1], 4, None).is_none(), "no part to fit a gate on");
        // Test parts that overlap, as those of repeated cuts do: no gate has seen the samples that it is tried on.
        let same = |training: &WithoutClasses| WithoutClasses { rows: (0..60).collect(), ..training.clone() };
        let overlapping: Vec<WithoutClasses> = trainings.iter().map(same).collect();
        assert!(of(&overlapping, 4, None).is_none(), "all samples are tried on");
        assert!(of(&trainings, 4, Some(&[7; 240])).is_none(), "all are of one group");
        let halves: Vec<u32> = (0..240).map(|row| row / 120).collect();
        let by_group = of(&trainings, 4, Some(&halves)).unwrap();
        assert!(by_group.known == 180 && by_group != scores, "the part of the same group is left out");
        // Networks whose logits lie elsewhere in each fold, each with its own places.
        let moved = |training: &WithoutClasses| {
            let off = 50.0 * training.fold as f32;
            let logits: Vec<f32> = training.logits.iter().map(|value| value + off).collect();
            let places = WithoutClasses::places_of(&[3], 4, &logits, &training.truth);
            WithoutClasses { logits, places, ..training.clone() }
        };
        let moved = of(&trainings.iter().map(moved).collect::<Vec<_>>(), 4, None).unwrap();
        assert!(moved.auroc > 0.98 && moved.refused > 0.9 && moved.false_alarms < 0.15, "{moved:?}");
    }
}
