//! Whether a sample is like those that a model has learned from.

use serde::{Deserialize, Serialize};

use crate::certainty::held_out::{HeldOut, LEAST};
use crate::certainty::place::{Place, distance};
use crate::metrics::Levels;

/// Distances of held-out samples that are kept: the share of samples that are farther is known to a hundredth.
pub(super) const RANKS: usize = 100;
/// The familiarity up to which a sample is unknown, where nothing else is said: the share of known samples that are refused too.
pub const FALSE_ALARMS: f32 = 0.05;

/// The gate of a model: how far the logits of a sample are from those of the classes, by the relative Mahalanobis distance
/// (Ren et al. 2021, equation 3), and how far held-out samples were.
///
/// The distance to the nearest class, in deviations of samples from the mean of their class, less the distance to all
/// samples together, in their deviations. It is summed over the attributes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seen {
    /// One for each attribute, in the order of the outputs.
    pub places: Vec<Place>,
    /// Distances of held-out samples, descending: a sample that is farther than the i-th, from 0, is among the farthest
    /// (i + 1)/100 of them and itself. The largest number where they are too few to tell.
    pub distances: Vec<f32>,
    /// The same of samples of which the first tenth is there, the first two, ...: ten lists, the last of the whole. Empty where
    /// that was not measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tenths: Vec<Vec<f32>>,
}

impl Seen {
    /// Fits a gate to the logits of held-out samples. Distances are ranked part by part: from where the model of the part has the
    /// samples that it has learned, if that is known, else from where the other parts have theirs. In the first case the
    /// [places](Seen::places) are left for those of the model that gets the gate. None of fewer than 30 samples, and where all
    /// logits are equal.
    pub fn fit(held: &HeldOut, levels: &Levels) -> Option<Self> {
        let distances = ranked(distances(held, held, levels)?, |_| f32::MAX);
        let places = if held.places.is_empty() {
            Place::of_logits(&held.logits, &held.truth, levels)?
        } else {
            vec![]
        };
        Some(Seen { places, distances, tenths: vec![] })
    }

    /// Ranks the distances of beginnings of the samples `held` that it was fitted to, tenth by tenth. Nothing is kept where one
    /// of them has too few.
    pub fn with_tenths(self, held: &HeldOut, starts: &[HeldOut], levels: &Levels) -> Self {
        let tenths =
            starts.iter().map(|start| distances(held, start, levels).map(|all| ranked(all, |_| f32::MAX)));
        let tenths = tenths.collect::<Option<_>>();
        Seen { tenths: tenths.unwrap_or_default(), ..self }
    }

    /// Returns the relative distance of a row of logits. Nothing is allocated once `scratch` has room.
    pub fn distance(&self, logits: &[f32], scratch: &mut Vec<f64>) -> f64 {
        distance(&self.places, logits, scratch)
    }

    /// Returns the familiarity of a row of logits: the share of held-out samples that are at least as far, 0.01..1. At
    /// [`FALSE_ALARMS`] or below the sample is unlike those that were learned. `share` of the sample is there, above 0 and at most 1; none of a
    /// beginning where that was not measured.
    pub fn familiarity(&self, logits: &[f32], share: f64, scratch: &mut Vec<f64>) -> Option<f32> {
        Some(self.rank(logits, share, scratch)? as f32 / RANKS as f32)
    }

    /// Returns the distance beyond which the familiarity is at most `share`, 0..1; none where no distance is enough.
    pub fn limit(&self, share: f32) -> Option<f32> {
        let rank = (1..=RANKS).filter(|rank| *rank as f32 / RANKS as f32 <= share).count();
        rank.checked_sub(1).map(|at| self.distances[at])
    }

    /// Returns [`Seen::familiarity`] in hundredths.
    pub(super) fn rank(&self, logits: &[f32], share: f64, scratch: &mut Vec<f64>) -> Option<usize> {
        let distances = if share >= 1.0 { &self.distances } else { tenth_of(&self.tenths, share)? };
        Some(rank(distances, self.distance(logits, scratch)))
    }

    /// Returns the familiarity of each of the held-out samples that the gate was fitted to, in hundredths.
    pub(super) fn ranks_of(&self, held: &HeldOut, levels: &Levels) -> Option<Vec<usize>> {
        let distances = distances(held, held, levels)?;
        Some(distances.iter().map(|distance| rank(&self.distances, *distance)).collect())
    }

    /// Checks whether the numbers fit attributes of these sizes; says what is wrong otherwise.
    pub(crate) fn check(&self, sizes: &[usize]) -> Result<(), String> {
        let fits = |(place, size): (&Place, &usize)| {
            let triangle = size * (size + 1) / 2;
            let lengths = (place.center.len(), place.within.len(), place.around.len());
            lengths == (*size, triangle, triangle)
                && !place.means.is_empty()
                && place.means.len().is_multiple_of(*size)
        };
        let numbers = |place: &Place| {
            let all = [&place.center, &place.within, &place.around, &place.means];
            all.into_iter().flatten().all(|value| value.is_finite())
        };
        let is_whole = self.places.len() == sizes.len()
            && self.places.iter().zip(sizes).all(fits)
            && self.places.iter().all(numbers)
            && matches!(self.tenths.len(), 0 | 10)
            && self.tenths.iter().chain([&self.distances]).all(|list| is_ranking(list));
        if is_whole { Ok(()) } else { Err("its card holds a gate of other classes, or a damaged one".into()) }
    }
}

/// Returns the list of the tenth that `share` of a sample ends in.
pub(super) fn tenth_of<T>(tenths: &[T], share: f64) -> Option<&T> {
    let tenth = (share * tenths.len() as f64).ceil() as usize;
    tenths.get(tenth.max(1) - 1)
}

/// Computes the distances of the samples `of`, each with the places of the other parts of `held`. None of fewer than 30.
fn distances(held: &HeldOut, of: &HeldOut, levels: &Levels) -> Option<Vec<f64>> {
    if of.len() < LEAST || [held, of].iter().any(|held| held.logits.len() != held.probabilities.len()) {
        return None;
    }
    let (mut all, mut scratch) = (vec![0.0; of.len()], vec![]);
    for part in of.each_part() {
        let others = match held.places.get(&part) {
            Some(places) => places.clone(),
            None => {
                let others = held.select(|row| held.parts[row] != part);
                Place::of_logits(&others.logits, &others.truth, levels)?
            }
        };
        let rows = of.logits.chunks_exact(levels.outputs());
        for ((to, row), _) in all.iter_mut().zip(rows).zip(&of.parts).filter(|(_, own)| **own == part) {
            *to = distance(&others, row, &mut scratch);
        }
    }
    all.iter().all(|distance| distance.is_finite()).then_some(all)
}

/// Returns the distances that [`Seen::distances`] are, of all. Where they are too few to tell, `beyond` makes one of the farthest.
pub(super) fn ranked(mut distances: Vec<f64>, beyond: impl Fn(f64) -> f32) -> Vec<f32> {
    distances.sort_by(|a, b| b.total_cmp(a));
    let count = distances.len() + 1;
    let of_share = |rank: usize| match rank * count / RANKS {
        0 => beyond(distances[0]),
        of_all => distances[of_all.min(distances.len()) - 1] as f32,
    };
    (1..=RANKS).map(of_share).collect()
}

/// Returns how many hundredths of held-out samples are at least as far, 1..100.
pub(super) fn rank(distances: &[f32], distance: f64) -> usize {
    let as_far = distances.partition_point(|held| f64::from(*held) >= distance);
    (as_far + 1).min(RANKS)
}

/// Checks whether a list is one that [`ranked`] makes.
pub(super) fn is_ranking(list: &[f32]) -> bool {
    list.len() == RANKS
        && list.iter().all(|far| far.is_finite())
        && list.is_sorted_by(|far, near| far >= near)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use rand::RngExt;
    use serde_json::Value;

    use super::*;

    /// `scripts/fixtures/seen.py` writes it with pytorch-ood.
    const TWIN: &str = include_str!("../../tests/data/seen.json");

    #[test]
    fn distances_are_those_of_pytorch_ood() {
        let twin: Value = serde_json::from_str(TWIN).unwrap();
        for case in twin["cases"].as_array().unwrap() {
            let list = |key: &str| -> Vec<f32> { serde_json::from_value(case[key].clone()).unwrap() };
            let classes = case["classes"].as_u64().unwrap() as usize;
            let truth: Vec<u32> = serde_json::from_value(case["truth"].clone()).unwrap();
            let (logits, parts) = (list("logits"), (0..truth.len() as u32).map(|row| row % 3).collect());
            let held = HeldOut { probabilities: logits.clone(), logits, truth, parts, ..HeldOut::default() };
            let seen = Seen::fit(&held, &Levels::new(&[classes])).unwrap();
            seen.check(&[classes]).unwrap();
            let mut scratch = vec![];
            let (new, wanted) = (list("new"), list("distances"));
            assert_eq!(new.len(), 30 * classes);
            for (row, wanted) in new.chunks_exact(classes).zip(wanted) {
                let distance = seen.distance(row, &mut scratch);
                assert!(
                    (distance / f64::from(wanted) - 1.0).abs() < 1e-3,
                    "{classes}: {distance} and {wanted}"
                );
            }
        }
    }

    /// Logits of `count` samples around the mean of their class, and those of as many of a class that nobody learned.
    fn drawn(count: usize) -> (HeldOut, Vec<f32>) {
        let mut rng = taxel_base::seed::rng(2, "seen");
        let mut held = HeldOut::default();
        let mut foreign = vec![];
        let mut noise = || (0..6).map(|_| rng.random::<f32>() - 0.5).sum::<f32>();
        for sample in 0..count {
            let class = sample % 3;
            held.logits.extend((0..3).map(|k| if k == class { 8.0 } else { 0.0 } + noise()));
            held.truth.push(class as u32);
            held.parts.push(sample as u32 / 3 % 5);
            foreign.extend([4.0 + noise(), 4.0 + noise(), noise()]);
        }
        held.probabilities = held.logits.clone();
        (held, foreign)
    }

    #[test]
    fn a_share_of_known_samples_is_refused_and_nearly_all_of_another_kind() {
        let (known, foreign) = drawn(900);
        let (fitted, new): (Vec<usize>, Vec<usize>) = (0..900).partition(|row| row % 2 == 0);
        let seen = Seen::fit(&known.select(|row| fitted.contains(&row)), &Levels::new(&[3])).unwrap();
        let mut scratch = vec![];
        let mut share = |logits: &[f32]| {
            let refused = logits
                .chunks_exact(3)
                .filter(|row| seen.familiarity(row, 1.0, &mut scratch) <= Some(FALSE_ALARMS))
                .count();
            refused as f64 / (logits.len() / 3) as f64
        };
        let own = share(&known.select(|row| new.contains(&row)).logits);
        assert!((own - 0.05).abs() < 0.03, "{own} of the known samples");
        assert!(share(&foreign) > 0.95, "foreign samples");
    }

    #[test]
    fn the_farthest_of_few_samples_is_not_rarer_than_they_can_tell() {
        let (known, _) = drawn(40);
        let seen = Seen::fit(&known, &Levels::new(&[3])).unwrap();
        let far = seen.familiarity(&[90.0, 90.0, -90.0], 1.0, &mut vec![]).unwrap();
        assert!((0.02..=0.05).contains(&far), "of 41 samples it is the farthest: {far}");
        assert!(Seen::fit(&drawn(29).0, &Levels::new(&[3])).is_none());
        let flat = HeldOut { logits: vec![1.0; 120], ..known };
        assert!(Seen::fit(&flat, &Levels::new(&[3])).is_none());
    }

    #[test]
    fn damaged_gates_are_refused() {
        let seen = Seen::fit(&drawn(60).0, &Levels::new(&[3])).unwrap();
        let broken = [
            Seen { distances: vec![1.0; 99], ..seen.clone() },
            Seen { distances: (0..100).map(|i| i as f32).collect(), ..seen.clone() },
            Seen { places: vec![], ..seen.clone() },
            Seen { tenths: vec![seen.distances.clone(); 9], ..seen.clone() },
            Seen { places: vec![Place { center: vec![0.0; 2], ..seen.places[0].clone() }], ..seen.clone() },
            Seen {
                places: vec![Place { within: vec![f32::NAN; 6], ..seen.places[0].clone() }],
                ..seen.clone()
            },
        ];
        assert!(seen.check(&[3]).is_ok() && broken.iter().all(|seen| seen.check(&[3]).is_err()));
    }
}
