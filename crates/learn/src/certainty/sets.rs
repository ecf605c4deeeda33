//! Sets of classes that hold the true one as often as they say.

use serde::{Deserialize, Serialize};

use crate::certainty::held_out::{HeldOut, conformal_rank, large_groups};
use crate::metrics::Levels;

/// Shares of samples whose set is to hold the true class.
pub(super) const SHARES: [f64; 4] = [0.8, 0.9, 0.95, 0.99];

/// Least ambiguous sets (Sadinle, Lei & Wasserman 2019): all classes whose probability is high enough, and always the likeliest
/// one.
///
/// The share that it covered was seen on held-out samples, and is no promise: with fewer than nine groups nothing can be promised at
/// 90 % for a new one (Lee, Barber & Willett 2023, hierarchical conformal prediction).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnswerSet {
    /// Share of samples whose set is to hold the true class, 0..1.
    pub share: f64,
    /// The least probability of a class in the set, one for each attribute.
    pub least: Vec<f32>,
    /// Share of held-out samples whose set held the true class, 0..1, each part with the limits of the others; mean over the
    /// attributes.
    pub covered: f64,
    /// The same in the worst group of five samples or more; none without groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_group: Option<f64>,
    /// Mean number of classes in a set.
    pub size: f64,
}

impl AnswerSet {
    /// Fits sets for each of [`SHARES`] to held-out probabilities.
    pub(super) fn fit(held: &HeldOut, levels: &Levels) -> Vec<Self> {
        SHARES.into_iter().map(|share| Self::of_share(held, levels, share)).collect()
    }

    fn of_share(held: &HeldOut, levels: &Levels, share: f64) -> Self {
        let truths = of_truth(held, levels);
        let width = levels.sizes().len();
        let limits = |keep: &dyn Fn(usize) -> bool| -> Vec<f32> {
            let of_attribute = |attribute: usize| {
                let own =
                    truths.iter().enumerate().filter(|(row, _)| keep(*row)).map(|(_, all)| all[attribute]);
                least(own.collect(), share)
            };
            (0..width).map(of_attribute).collect()
        };
        let (mut covered, mut sizes) = (vec![0.0; held.len()], 0.0);
        for part in held.each_part() {
            let least = limits(&|row| held.parts[row] != part);
            for row in (0..held.len()).filter(|row| held.parts[*row] == part) {
                let probabilities = &held.probabilities[row * levels.outputs()..][..levels.outputs()];
                for (attribute, set) in sets(probabilities, levels, &least).enumerate() {
                    let label = held.truth[row * width + attribute] as usize;
                    covered[row] += f64::from(u8::from(set.contains(&label))) / width as f64;
                    sizes += set.len() as f64;
                }
            }
        }
        let mean = |rows: &[usize]| rows.iter().map(|row| covered[*row]).sum::<f64>() / rows.len() as f64;
        let groups = large_groups(held.groups.as_deref());
        AnswerSet {
            share,
            least: limits(&|_| true),
            covered: mean(&(0..held.len()).collect::<Vec<_>>()),
            worst_group: groups.iter().map(|members| mean(members)).min_by(f64::total_cmp),
            size: sizes / (held.len() * width) as f64,
        }
    }

    /// Lists the classes of each attribute in the set of a sample with `probabilities` `[outputs]`, the likeliest first.
    pub fn classes(&self, probabilities: &[f32], levels: &Levels) -> Vec<Vec<usize>> {
        sets(probabilities, levels, &self.least).collect()
    }
}

/// Returns the probability of the true class of each attribute of each sample.
fn of_truth(held: &HeldOut, levels: &Levels) -> Vec<Vec<f32>> {
    let width = levels.sizes().len();
    let rows = held.probabilities.chunks_exact(levels.outputs()).zip(held.truth.chunks_exact(width));
    let of_row = |(row, labels): (&[f32], &[u32])| {
        let mut first = 0;
        let of_attribute = |(size, label): (&usize, &u32)| {
            let probability = row[first + *label as usize];
            first += size;
            probability
        };
        levels.sizes().iter().zip(labels).map(of_attribute).collect()
    };
    rows.map(of_row).collect()
}

/// Returns the probability that the share of n + 1 true classes reaches; 0 where n are too few.
fn least(mut truths: Vec<f32>, share: f64) -> f32 {
    truths.sort_by(|a, b| b.total_cmp(a));
    truths.get(conformal_rank(truths.len(), share)).copied().unwrap_or(0.0)
}

fn sets<'a>(
    probabilities: &'a [f32],
    levels: &'a Levels,
    least: &'a [f32],
) -> impl Iterator<Item = Vec<usize>> + 'a {
    let mut rest = probabilities;
    levels.sizes().iter().zip(least).map(move |(size, least)| {
        let (own, others) = rest.split_at(*size);
        rest = others;
        let mut order: Vec<usize> = (0..*size).collect();
        order.sort_by(|a, b| own[*b].total_cmp(&own[*a]));
        let count = order.iter().filter(|class| own[**class] >= *least).count();
        order.truncate(count.max(1));
        order
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use serde_json::Value;

    use super::*;
    use crate::metrics::{BINS, calibration_error};

    /// `scripts/fixtures/answer_sets.py` writes it with MAPIE.
    const TWIN: &str = include_str!("../../tests/data/answer_sets.json");

    fn singles(value: &Value) -> Vec<f32> {
        serde_json::from_value(value.clone()).unwrap()
    }

    #[test]
    fn sets_are_those_of_mapie_and_never_empty() {
        let twin: Value = serde_json::from_str(TWIN).unwrap();
        for case in twin["cases"].as_array().unwrap() {
            let classes = case["classes"].as_u64().unwrap() as usize;
            let (levels, new) = (Levels::new(&[classes]), singles(&case["new"]));
            let truth: Vec<u32> = serde_json::from_value(case["truth"].clone()).unwrap();
            let (probabilities, parts) = (singles(&case["probabilities"]), vec![0; truth.len()]);
            let ece = calibration_error(&probabilities, &truth, classes, BINS).unwrap();
            assert!((ece - case["calibration_error"].as_f64().unwrap()).abs() < 1e-6, "{ece}");
            let held = HeldOut { probabilities, truth, parts, ..HeldOut::default() };
            let sets = AnswerSet::fit(&held, &levels);
            assert_eq!(sets.len(), 4);
            for set in sets {
                let wanted: Vec<Vec<usize>> =
                    serde_json::from_value(case["sets"][set.share.to_string()].clone()).unwrap();
                for (row, wanted) in new.chunks_exact(classes).zip(wanted) {
                    let mut own = set.classes(row, &levels).remove(0);
                    let likeliest = own[0];
                    own.sort_unstable();
                    let wanted = if wanted.is_empty() { vec![likeliest] } else { wanted };
                    assert_eq!(own, wanted, "{} of {classes} classes", set.share);
                }
            }
        }
    }

    #[test]
    fn sets_cover_as_much_as_they_say_on_parts_that_they_were_not_fitted_on() {
        let mut rng = taxel_base::seed::rng(1, "sets");
        let mut held = HeldOut { groups: Some(vec![]), ..HeldOut::default() };
        for sample in 0..2000u32 {
            let row = [(); 4].map(|()| rand::RngExt::random::<f32>(&mut rng).powi(3));
            let sum: f32 = row.iter().sum();
            let (mut left, mut label) = (sum * rand::RngExt::random::<f32>(&mut rng), 0);
            while label < 3 && left > row[label] {
                left -= row[label];
                label += 1;
            }
            held.probabilities.extend(row.map(|p| p / sum));
            held.truth.push(label as u32);
            held.parts.push(sample % 5);
            held.groups.iter_mut().for_each(|groups| groups.push(sample % 20));
        }
        for set in AnswerSet::fit(&held, &Levels::new(&[4])) {
            assert!((set.covered - set.share).abs() < 0.02, "{set:?}");
            assert!(set.worst_group.unwrap() < set.covered && set.size >= 1.0 && set.size < 4.0, "{set:?}");
        }
    }

    #[test]
    fn too_few_samples_for_a_share_give_sets_of_all_classes() {
        let rows = [[0.9f32, 0.1], [0.2, 0.8]].concat();
        let held = HeldOut {
            probabilities: rows.repeat(15),
            truth: [0, 1].repeat(15),
            parts: vec![0; 30],
            ..HeldOut::default()
        };
        let sets = AnswerSet::fit(&held, &Levels::new(&[2]));
        assert_eq!(sets[3].least, [0.0], "99 % of 31 are 31");
        assert_eq!(
            (sets[1].least[0], sets[3].classes(&[0.3, 0.7], &Levels::new(&[2]))),
            (0.8, vec![vec![1, 0]])
        );
    }
}
