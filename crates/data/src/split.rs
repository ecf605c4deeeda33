//! Cutting samples into folds: a pure function of labels, groups, copies, seed and repetition.

use crate::{Error, Result};
use rand::seq::SliceRandom;
use std::collections::BTreeMap;

/// One train/test cut of the samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fold {
    /// Indices of the training samples, ascending.
    pub train: Vec<usize>,
    /// Indices of the test samples, ascending; no sample is in both.
    pub test: Vec<usize>,
}

/// Samples that stay together, and their labels with how often each occurs.
struct Unit {
    samples: Vec<usize>,
    labels: BTreeMap<u32, usize>,
}

/// Cuts the samples into `k` folds in which every class is spread evenly.
///
/// `y` `[N]` holds the labels; `units` `[N]`, where given, names for each sample the unit it
/// belongs to ([`Dataset::units`](crate::Dataset::units): exact copies), and no unit is cut. If
/// every unit is one sample, the test counts of a class differ by at most 1 between folds, and so
/// do the fold sizes. Every sample is tested exactly once. `seed` and `repetition` choose the
/// folds.
///
/// # Errors
///
/// If `k` < 2, if `y` is empty, if `units` has another length, or if a class has fewer than `k`
/// units.
pub fn stratified_k_fold(
    y: &[u32],
    k: usize,
    seed: u64,
    repetition: u32,
    units: Option<&[u32]>,
) -> Result<Vec<Fold>> {
    let own: Vec<u32>;
    let units = match units {
        Some(units) => units,
        None => {
            own = (0..y.len() as u32).collect();
            &own
        }
    };
    refuse(y, units, "units", k)?;
    let mut units = gather(y, units);
    let mut per_class: BTreeMap<u32, usize> = BTreeMap::new();
    for label in units.iter().flat_map(|unit| unit.labels.keys()) {
        *per_class.entry(*label).or_default() += 1;
    }
    if let Some((class, units)) = per_class.into_iter().find(|(_, units)| *units < k) {
        return Err(Error::ClassTooSmall { class, units, k });
    }
    let mut rng = taxel_seed::rng(seed, &format!("split/stratified/{repetition}"));
    units.shuffle(&mut rng);
    // Large units first, as they fit only while folds are empty; then class by class.
    units.sort_by_key(|unit| {
        let size = unit.samples.len();
        let single = size == 1;
        let class = unit.labels.keys().next().copied();
        (single, std::cmp::Reverse(size), class.filter(|_| single))
    });
    let mut order: Vec<usize> = (0..k).collect();
    order.shuffle(&mut rng);
    let mut test_of = vec![0; y.len()];
    let mut of_class: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut totals = vec![0; k];
    for unit in &units {
        let load = |fold: usize| -> usize {
            let held = |label| of_class.get(label).map_or(0, |counts| counts[fold]);
            unit.labels.keys().map(held).sum()
        };
        let best = order.iter().copied().min_by_key(|fold| (load(*fold), totals[*fold]));
        let fold = best.unwrap_or(0);
        for (label, count) in &unit.labels {
            of_class.entry(*label).or_insert_with(|| vec![0; k])[fold] += count;
        }
        totals[fold] += unit.samples.len();
        unit.samples.iter().for_each(|sample| test_of[*sample] = fold);
    }
    Ok(folds(&test_of, k))
}

/// Cuts the samples into `k` folds without cutting any group.
///
/// `groups` and `y` are `[N]`. With as many groups as folds this is leave-one-group-out: fold i
/// tests the i-th group in ascending order, whatever `seed` and `repetition`. With more groups
/// they are dealt, largest first, so that sizes and classes of the folds come out close; `seed`
/// and `repetition` then choose among equals. Every sample is tested exactly once. Exact copies
/// in different groups are not brought together: [`Card::warnings`](crate::Card::warnings) tells.
///
/// # Errors
///
/// If `k` < 2, if `y` is empty, if `groups` has another length, or if there are fewer than `k`
/// groups.
pub fn group_k_fold(groups: &[u32], y: &[u32], k: usize, seed: u64, repetition: u32) -> Result<Vec<Fold>> {
    refuse(y, groups, "groups", k)?;
    let mut units = gather(y, groups);
    if units.len() < k {
        return Err(Error::TooFewGroups { groups: units.len(), k });
    }
    let mut test_of = vec![0; y.len()];
    if units.len() == k {
        for (fold, unit) in units.iter().enumerate() {
            unit.samples.iter().for_each(|sample| test_of[*sample] = fold);
        }
        return Ok(folds(&test_of, k));
    }
    let mut sizes: BTreeMap<u32, f64> = BTreeMap::new();
    y.iter().for_each(|label| *sizes.entry(*label).or_default() += 1.0);
    let mut rng = taxel_seed::rng(seed, &format!("split/group/{repetition}"));
    units.shuffle(&mut rng);
    units.sort_by_key(|unit| std::cmp::Reverse(unit.samples.len()));
    let mut order: Vec<usize> = (0..k).collect();
    order.shuffle(&mut rng);
    let mut held: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); k];
    let mut totals = vec![0usize; k];
    for unit in &units {
        // Growth of the sum of squared shares, of each class and of the whole: an empty fold
        // costs nothing, so every fold gets a group.
        let cost = |fold: usize| {
            let share = |(label, count): (&u32, &usize)| {
                let size = sizes.get(label).copied().unwrap_or(1.0);
                held[fold].get(label).copied().unwrap_or(0.0) * *count as f64 / (size * size)
            };
            let whole = (totals[fold] * unit.samples.len()) as f64 / (y.len() as f64).powi(2);
            unit.labels.iter().map(share).sum::<f64>() + whole
        };
        let best = order.iter().copied().min_by(|a, b| cost(*a).total_cmp(&cost(*b)));
        let fold = best.unwrap_or(0);
        for (label, count) in &unit.labels {
            *held[fold].entry(*label).or_default() += *count as f64;
        }
        totals[fold] += unit.samples.len();
        unit.samples.iter().for_each(|sample| test_of[*sample] = fold);
    }
    Ok(folds(&test_of, k))
}

fn refuse(y: &[u32], other: &[u32], what: &'static str, k: usize) -> Result<()> {
    if k < 2 {
        return Err(Error::TooFewFolds { k });
    }
    if y.is_empty() {
        return Err(Error::NothingToSplit);
    }
    if other.len() != y.len() {
        return Err(Error::SplitLength { what, len: other.len(), samples: y.len() });
    }
    Ok(())
}

/// The samples of each unit, units ascending.
fn gather(y: &[u32], units: &[u32]) -> Vec<Unit> {
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (sample, unit) in units.iter().enumerate() {
        members.entry(*unit).or_default().push(sample);
    }
    let unit = |samples: Vec<usize>| {
        let mut labels = BTreeMap::new();
        samples.iter().for_each(|sample| *labels.entry(y[*sample]).or_default() += 1);
        Unit { samples, labels }
    };
    members.into_values().map(unit).collect()
}

/// From the fold that tests each sample to the folds.
fn folds(test_of: &[usize], k: usize) -> Vec<Fold> {
    let fold = |fold: usize| {
        let (test, train) = (0..test_of.len()).partition(|sample| test_of[*sample] == fold);
        Fold { train, test }
    };
    (0..k).map(fold).collect()
}
