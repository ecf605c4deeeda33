//! Whether the readings of a sample are like those that a model has learned from, whatever the model makes of them.

use std::collections::BTreeSet;

use ndarray::{ArrayRef, IxDyn};
use serde::{Deserialize, Serialize};
use taxel_data::Layout;

use crate::certainty::held_out::LEAST;
use crate::certainty::place::whitening;
use crate::certainty::seen::{RANKS, is_ranking, rank, ranked};
use crate::certainty::summary::Summary;

/// The part of the mean variance that is added to every variance: summary numbers depend on each other.
const RIDGE: f64 = 0.05;
/// The least deviation of a summary number, in parts of the range of the readings, or of a factor for logarithms.
const LEAST_DEVIATION: f64 = 1e-3;
/// How much farther than all held-out samples a sample is that is surely unlike them, where they are too few to tell.
const BEYOND: f64 = 1.5;

/// The gate of readings: how far the summary of a sample is from those of known samples, and how far held-out samples were.
///
/// Logits alone do not tell a dead sensor or noise from an object: a network may give them those of a class. The summary is the
/// mean, the spread, the roughness over time and the ends of the readings, and the means of single channels, its distance that of
/// Mahalanobis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Readings {
    /// Highest less lowest reading of the known samples, in the unit of the readings.
    pub range: f32,
    /// Mean of each summary number.
    pub center: Vec<f32>,
    /// Lower triangle of the matrix that brings deviations from the center to variance 1, row by row.
    pub around: Vec<f32>,
    /// Distances of held-out samples, descending, as those of the logits.
    pub distances: Vec<f32>,
    /// The familiarity by logits and readings together where the lesser of the two is 0.01, 0.02, ..., 1. Empty of methods
    /// without logits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub together: Vec<f32>,
}

/// Held-out samples for a gate of readings.
pub(super) struct HeldReadings<'x> {
    /// The axes of a sample, and its shape.
    pub of: (Layout, &'x [usize]),
    /// Raw samples, one for each row.
    pub samples: Vec<&'x [f32]>,
    /// Samples that have a number in common are not apart.
    pub apart: Vec<u32>,
}

impl Readings {
    /// Fits a gate to `rows` of the raw samples `x` `[n, ..]` of that layout, [`Readings::fit`].
    pub(super) fn of_rows(
        rows: &[usize],
        apart: &[u32],
        (layout, x): (Layout, &ArrayRef<f32, IxDyn>),
    ) -> Option<(Self, Vec<f32>)> {
        let x = x.as_standard_layout();
        let (shape, values) = (x.shape().get(1..)?, x.as_slice()?);
        let each = shape.iter().product::<usize>();
        let samples = rows.iter().map(|row| values.get(row * each..(row + 1) * each));
        let samples = samples.collect::<Option<Vec<_>>>().filter(|_| each > 0)?;
        Readings::fit(&HeldReadings { of: (layout, shape), samples, apart: apart.to_vec() })
    }

    /// Fits a gate to samples. The distance of each is taken from the samples of all other parts. None of fewer than 30.
    pub(super) fn fit(held: &HeldReadings) -> Option<(Self, Vec<f32>)> {
        let all = held.samples.iter().copied().flatten();
        let (low, high) =
            all.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        let range = high - low;
        if held.samples.len() < LEAST || !is_usable(range) {
            return None;
        }
        let (layout, shape) = held.of;
        let mut summary = Summary::new(layout, shape);
        let numbers: Vec<Vec<f32>> =
            held.samples.iter().map(|sample| summary.of(sample, range).to_vec()).collect();
        let parts: BTreeSet<u32> = held.apart.iter().copied().collect();
        let mut distances = vec![0.0; numbers.len()];
        for part in parts {
            let others = numbers.iter().zip(&held.apart).filter(|(_, apart)| **apart != part);
            let others: Vec<&[f32]> = others.map(|(numbers, _)| &**numbers).collect();
            let (center, around) = place(&summary, &others, range)?;
            for (row, numbers) in numbers.iter().enumerate().filter(|(row, _)| held.apart[*row] == part) {
                distances[row] = distance(&center, &around, numbers);
            }
        }
        let rows: Vec<&[f32]> = numbers.iter().map(|numbers| &**numbers).collect();
        let (center, around) = place(&summary, &rows, range)?;
        let all = distances.iter().map(|distance| f64::from(*distance)).collect();
        let ranking = ranked(all, |farthest| (BEYOND * farthest) as f32);
        let gate = Readings { range, center, around, distances: ranking, together: vec![] };
        gate.check().ok().map(|()| (gate, distances))
    }

    /// Ranks the familiarity of held-out samples by logits, hundredths, and by the `distances` of their readings together.
    pub(super) fn with_logits(self, logits: &[usize], distances: &[f32]) -> Self {
        let lesser: Vec<usize> = logits
            .iter()
            .zip(distances)
            .map(|(logits, distance)| lesser(*logits, rank(&self.distances, f64::from(*distance))))
            .collect();
        let count = lesser.len() as f32;
        let share = |least: usize| {
            let as_far = lesser.iter().filter(|lesser| **lesser <= least).count() as f32;
            ((as_far + 1.0) / (count + 1.0)).max(1.0 / RANKS as f32)
        };
        Readings { together: (1..=RANKS).map(share).collect(), ..self }
    }

    /// Returns the familiarity of a sample by its readings, and by its logits where their `rank` in hundredths is known, 0.01..1.
    pub(super) fn familiarity(&self, logits: Option<usize>, summary: &[f32]) -> f32 {
        let readings = rank(&self.distances, f64::from(self.distance(summary)));
        let least = logits.map_or(readings, |logits| lesser(logits, readings));
        match logits.and(self.together.get(least - 1)) {
            Some(together) => *together,
            None => least as f32 / RANKS as f32,
        }
    }

    /// Returns the distance of a summary from those of known samples, in deviations.
    fn distance(&self, summary: &[f32]) -> f32 {
        distance(&self.center, &self.around, summary)
    }

    /// Returns the distance of a raw sample of that layout and shape from known samples, in deviations.
    pub fn distance_of(&self, sample: &[f32], layout: Layout, shape: &[usize]) -> f32 {
        self.distance(Summary::new(layout, shape).of(sample, self.range))
    }

    /// Returns what is added to deviations before their logarithm is taken, in the unit of the readings.
    pub fn floor(&self) -> f32 {
        Summary::floor(self.range)
    }

    /// Returns the distances by logits and by readings beyond which the familiarity of a sample is at most `share`; none where no
    /// distance is enough. `seen` are the distances of held-out samples by logits; none of methods without logits.
    pub fn limits(&self, seen: Option<&[f32]>, share: f32) -> [Option<f32>; 2] {
        let of_rank = |rank: usize| match self.together.get(rank - 1).filter(|_| seen.is_some()) {
            Some(together) => *together,
            None => rank as f32 / RANKS as f32,
        };
        let rank = (1..=RANKS).filter(|rank| of_rank(*rank) <= share).count();
        let readings =
            if seen.is_some() { (1..=rank).filter(|own| lesser(RANKS, *own) <= rank).count() } else { rank };
        let nth = |distances: &[f32], rank: usize| rank.checked_sub(1).map(|at| distances[at]);
        [seen.and_then(|seen| nth(seen, rank)), nth(&self.distances, readings)]
    }

    /// Checks whether the numbers belong together; says what is wrong otherwise.
    fn check(&self) -> Result<(), String> {
        let size = self.center.len();
        let numbers = self.center.iter().chain(&self.around).chain(&self.together);
        let is_whole = size > 0
            && self.around.len() == size * (size + 1) / 2
            && numbers.into_iter().all(|value| value.is_finite())
            && is_usable(self.range)
            && is_ranking(&self.distances)
            && matches!(self.together.len(), 0 | RANKS);
        if is_whole { Ok(()) } else { Err("its card holds a damaged gate of readings".into()) }
    }

    /// Checks whether the gate is of samples of this layout and shape; says what is wrong otherwise.
    pub(crate) fn check_of(&self, layout: Layout, shape: &[usize]) -> Result<(), String> {
        self.check()?;
        let wanted = Summary::new(layout, shape).count();
        if self.center.len() == wanted {
            Ok(())
        } else {
            Err("its card holds a gate of other readings".into())
        }
    }
}

/// Returns the lesser of the ranks by logits and by readings. The second weighs less, two for five: it tells broken sensors and
/// other sensors, which are far away, and the first tells other objects, which are near.
fn lesser(logits: usize, readings: usize) -> usize {
    logits.min((5 * readings).div_ceil(2)).clamp(1, RANKS)
}

/// Finds where summaries `rows` lie: their mean, and the triangle that brings deviations to variance 1.
fn place(summary: &Summary, rows: &[&[f32]], range: f32) -> Option<(Vec<f32>, Vec<f32>)> {
    if rows.len() < LEAST.div_ceil(2) {
        return None;
    }
    let (size, n) = (rows.first()?.len(), rows.len() as f64);
    let mean: Vec<f64> =
        (0..size).map(|k| rows.iter().map(|row| f64::from(row[k])).sum::<f64>() / n).collect();
    let deviation = |k: usize| {
        let square = rows.iter().map(|row| (f64::from(row[k]) - mean[k]).powi(2)).sum::<f64>() / n;
        let unit = if summary.is_logarithm(k) {
            1.0
        } else if k >= summary.shared() && square > 0.0 {
            // Channels may have different units.
            square.sqrt()
        } else {
            f64::from(range)
        };
        (square + (LEAST_DEVIATION * unit).powi(2)).sqrt()
    };
    let scale: Vec<f64> = (0..size).map(deviation).collect();
    let off = rows.iter().map(|row| (0..size).map(|k| (f64::from(row[k]) - mean[k]) / scale[k]).collect());
    let triangle = whitening(size, off, RIDGE)?;
    let columns = (0..size).flat_map(|i| 0..=i);
    let around = triangle.iter().zip(columns).map(|(value, column)| (value / scale[column]) as f32).collect();
    Some((mean.iter().map(|value| *value as f32).collect(), around))
}

/// Returns the distance of a summary, in deviations, as the mean over its numbers. Nothing is allocated. In single precision, one
/// operation after the other, so that C gives the same bits.
fn distance(center: &[f32], around: &[f32], summary: &[f32]) -> f32 {
    let mut off = [0.0; Summary::MOST];
    for ((off, value), center) in off.iter_mut().zip(summary).zip(center) {
        *off = value - center;
    }
    let (size, mut rest, mut squares) = (center.len(), around, 0.0);
    for i in 0..size {
        let (row, others) = rest.split_at(i + 1);
        let sum = row.iter().zip(&off).fold(0.0, |sum, (weight, off)| sum + weight * off);
        squares += sum * sum;
        rest = others;
    }
    (squares / size as f32).sqrt()
}

/// Checks whether deviations of readings of that range have logarithms.
fn is_usable(range: f32) -> bool {
    range.is_finite() && Summary::floor(range).is_normal() && range > 0.0
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use rand::RngExt;
    use serde_json::Value;

    use super::*;
    use crate::certainty::seen::FALSE_ALARMS;

    const SHAPE: [usize; 2] = [3, 40];
    /// `scripts/fixtures/readings.py` writes it with numpy and scikit-learn.
    const TWIN: &str = include_str!("../../tests/data/readings.json");

    #[test]
    fn distances_are_those_of_numpy_and_scikit_learn() {
        let twin: Value = serde_json::from_str(TWIN).unwrap();
        for case in twin["cases"].as_array().unwrap() {
            let list = |key: &str| -> Vec<f32> { serde_json::from_value(case[key].clone()).unwrap() };
            let layout: Layout = serde_json::from_value(case["layout"].clone()).unwrap();
            let shape: Vec<usize> = serde_json::from_value(case["shape"].clone()).unwrap();
            let each: usize = shape.iter().product();
            let known = list("known");
            let samples: Vec<&[f32]> = known.chunks_exact(each).collect();
            let apart = (0..samples.len() as u32).map(|row| row % 5).collect();
            let (gate, _) = Readings::fit(&HeldReadings { of: (layout, &shape), samples, apart }).unwrap();
            let (new, wanted) = (list("new"), list("distances"));
            assert_eq!(new.len(), wanted.len() * each);
            for (sample, wanted) in new.chunks_exact(each).zip(wanted) {
                let distance = gate.distance_of(sample, layout, &shape);
                assert!((distance / wanted - 1.0).abs() < 2e-3, "{layout}: {distance} and {wanted}");
            }
        }
    }

    /// Draws presses: three channels rise from rest to levels of their own and stay there, with a little noise.
    fn presses(count: usize, seed: u64) -> Vec<Vec<f32>> {
        let mut rng = taxel_base::seed::rng(seed, "readings");
        let mut press = || {
            let strength = 0.5 + rng.random::<f32>();
            let onset = 5.0 + 10.0 * rng.random::<f32>();
            let of = |place: usize| (place / 40, place % 40);
            (0..120)
                .map(|place| {
                    let (channel, step) = of(place);
                    let rise = 1.0 / (1.0 + (-(step as f32 - onset)).exp());
                    strength * (1.0 + channel as f32) * rise + 0.02 * (rng.random::<f32>() - 0.5)
                })
                .collect()
        };
        (0..count).map(|_| press()).collect()
    }

    fn fit(samples: &[Vec<f32>]) -> Option<(Readings, Vec<f32>)> {
        let apart = (0..samples.len() as u32).map(|row| row % 5).collect();
        Readings::fit(&HeldReadings {
            of: (Layout::Series, &SHAPE),
            samples: samples.iter().map(|sample| &**sample).collect(),
            apart,
        })
    }

    #[test]
    fn limits_refuse_what_the_familiarity_refuses() {
        let (gate, distances) = fit(&presses(600, 1)).unwrap();
        let mut rng = taxel_base::seed::rng(4, "limits");
        let seen: Vec<f32> = (0..RANKS).map(|rank| 100.0 - rank as f32).collect();
        let ranks: Vec<usize> = (0..600).map(|_| 1 + (100.0 * rng.random::<f32>()) as usize % 100).collect();
        let together = gate.clone().with_logits(&ranks, &distances);
        let mut summary = Summary::new(Layout::Series, &SHAPE);
        let samples: Vec<Vec<f32>> =
            presses(300, 2).into_iter().chain(foreign().into_iter().flat_map(|(_, all)| all)).collect();
        for share in [0.001, 0.01, FALSE_ALARMS, 0.3, 0.99] {
            let (both, own) = (together.limits(Some(&seen), share), gate.limits(None, share));
            assert_eq!(own[0], None);
            for sample in &samples {
                let (numbers, logits) = (summary.of(sample, gate.range), 102.0 * rng.random::<f32>());
                let distance = gate.distance(numbers);
                let beyond = |limit: Option<f32>, distance: f32| limit.is_some_and(|limit| distance > limit);
                let by_logits = rank(&seen, f64::from(logits));
                let refused = together.familiarity(Some(by_logits), numbers) <= share;
                assert_eq!(refused, beyond(both[0], logits) || beyond(both[1], distance), "{share}");
                assert_eq!(gate.familiarity(None, numbers) <= share, beyond(own[1], distance), "{share}");
            }
        }
    }

    fn refused(gate: &Readings, samples: &[Vec<f32>]) -> f64 {
        let mut summary = Summary::new(Layout::Series, &SHAPE);
        let far = |sample: &&Vec<f32>| gate.familiarity(None, summary.of(sample, gate.range)) <= FALSE_ALARMS;
        samples.iter().filter(far).count() as f64 / samples.len() as f64
    }

    /// Makes samples of dead, saturated and noisy sensors, and presses ten times as strong or a tenth.
    fn foreign() -> Vec<(&'static str, Vec<Vec<f32>>)> {
        let mut rng = taxel_base::seed::rng(9, "foreign");
        let mut noise = |low: f32, high: f32| -> Vec<Vec<f32>> {
            (0..50).map(|_| (0..120).map(|_| low + (high - low) * rng.random::<f32>()).collect()).collect()
        };
        let noises = [("noise", noise(0.0, 4.5)), ("faint noise", noise(1.0, 1.5))];
        let times = |factor: f32| -> Vec<Vec<f32>> {
            presses(50, 5).iter().map(|press| press.iter().map(|v| factor * v).collect()).collect()
        };
        let levels = [("dead", 0.0), ("saturated", 4.5), ("stuck", 2.0)];
        let levels = levels.map(|(name, level)| (name, vec![vec![level; 120]; 50]));
        noises.into_iter().chain(levels).chain([("strong", times(10.0)), ("weak", times(0.1))]).collect()
    }

    #[test]
    fn broken_sensors_are_refused_and_a_share_of_known_samples() {
        for count in [400, 40] {
            let (gate, _) = fit(&presses(count, 1)).unwrap();
            gate.check_of(Layout::Series, &SHAPE).unwrap();
            for (name, samples) in foreign() {
                assert!(refused(&gate, &samples) > 0.99, "{name} of {count}");
            }
            let known = refused(&gate, &presses(400, 2));
            assert!(known < if count == 400 { 0.09 } else { 0.3 }, "{known} of the known, {count}");
        }
        assert!(fit(&presses(29, 1)).is_none() && fit(&vec![vec![1.0; 120]; 60]).is_none());
    }

    #[test]
    fn logits_and_readings_together_refuse_no_more_than_either_promises() {
        let mut rng = taxel_base::seed::rng(3, "logits");
        let (gate, distances) = fit(&presses(600, 1)).unwrap();
        let logits: Vec<usize> = (0..600).map(|_| 1 + (100.0 * rng.random::<f32>()) as usize % 100).collect();
        let gate = gate.with_logits(&logits, &distances);
        gate.check().unwrap();
        let mut summary = Summary::new(Layout::Series, &SHAPE);
        let is_refused = |(sample, logits): (&Vec<f32>, &usize)| {
            gate.familiarity(Some(*logits), summary.of(sample, gate.range)) <= FALSE_ALARMS
        };
        let refused = presses(600, 2).iter().zip(&logits).map(is_refused).filter(|refused| *refused).count();
        assert!((10..=48).contains(&refused), "{refused} of 600");
        // Either gate is enough.
        let mut of = |sample: &Vec<f32>, logits| {
            gate.familiarity(Some(logits), summary.of(sample, gate.range)) <= FALSE_ALARMS
        };
        assert!(of(&vec![0.0; 120], 80) && of(&presses(1, 2)[0], 1) && !of(&presses(1, 2)[0], 60));
    }

    #[test]
    fn damaged_gates_are_refused() {
        let gate = fit(&presses(60, 1)).unwrap().0;
        let broken = [
            Readings { range: 0.0, ..gate.clone() },
            Readings { center: vec![0.0; 3], ..gate.clone() },
            Readings { around: vec![f32::NAN; gate.around.len()], ..gate.clone() },
            Readings { distances: vec![1.0; 99], ..gate.clone() },
            Readings { together: vec![1.0; 4], ..gate.clone() },
        ];
        assert!(gate.check().is_ok() && broken.iter().all(|gate| gate.check().is_err()));
        assert!(gate.check_of(Layout::Image, &[3, 40]).is_err());
    }
}
