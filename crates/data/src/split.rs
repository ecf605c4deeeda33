//! Cuts samples into folds: a pure function of labels, groups, copies, seed and repetition.

use crate::{Error, Result};
use rand::seq::SliceRandom;
use std::collections::{BTreeMap, BTreeSet};

/// One cut of the samples; no sample is in two parts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Fold {
    /// Indices of the training samples, ascending.
    pub train: Vec<usize>,
    /// Indices of the samples that choose (when to stop, which settings) and are never trained on,
    /// ascending; empty where the protocol has none.
    pub validation: Vec<usize>,
    /// Indices of the test samples, ascending.
    pub test: Vec<usize>,
}

/// Shares of all samples, each in (0, 1) and below 1 together; the rest is trained on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Share that is tested.
    pub test: f64,
    /// Share that chooses; 0 for none.
    pub validation: f64,
}

/// Samples that stay together, and the number of samples of each label.
struct SplitUnit {
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
    let singles = singles(y.len());
    let units = units.unwrap_or(&singles);
    refuse(y, units, "units", k)?;
    let mut units = gather(y, units);
    let mut per_class: BTreeMap<u32, usize> = BTreeMap::new();
    for label in units.iter().flat_map(|unit| unit.labels.keys()) {
        *per_class.entry(*label).or_default() += 1;
    }
    if let Some((class, units)) = per_class.into_iter().find(|(_, units)| *units < k) {
        return Err(Error::ClassTooSmall { class: class.into(), units, k });
    }
    let mut rng = taxel_base::seed::rng(seed, &format!("split/stratified/{repetition}"));
    units.shuffle(&mut rng);
    // Large units fit only while folds are empty, so they come first; then class by class.
    units.sort_by_key(|unit| {
        let size = unit.samples.len();
        let single = size == 1;
        let class = unit.labels.keys().next().copied();
        (single, std::cmp::Reverse(size), class.filter(|_| single))
    });
    let mut order: Vec<usize> = (0..k).collect();
    order.shuffle(&mut rng);
    let mut filling = Filling::new(y.len(), k);
    for unit in &units {
        let load =
            |fold: usize| -> usize { unit.labels.keys().map(|label| filling.held(*label, fold)).sum() };
        let best = order.iter().copied().min_by_key(|fold| (load(*fold), filling.totals[*fold]));
        #[expect(clippy::expect_used, reason = "fewer than two folds are refused")]
        filling.put(unit, best.expect("a fold at least"));
    }
    Ok(filling.folds())
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
    let mut filling = Filling::new(y.len(), k);
    if units.len() == k {
        units.iter().enumerate().for_each(|(fold, unit)| filling.put(unit, fold));
        return Ok(filling.folds());
    }
    let mut sizes: BTreeMap<u32, f64> = BTreeMap::new();
    y.iter().for_each(|label| *sizes.entry(*label).or_default() += 1.0);
    let mut rng = taxel_base::seed::rng(seed, &format!("split/group/{repetition}"));
    units.shuffle(&mut rng);
    units.sort_by_key(|unit| std::cmp::Reverse(unit.samples.len()));
    let mut order: Vec<usize> = (0..k).collect();
    order.shuffle(&mut rng);
    for unit in &units {
        // The growth of the sum of squared shares, of each class and of the whole. An empty fold costs nothing, so every
        // fold gets a group.
        let cost = |fold: usize| {
            let share = |(label, count): (&u32, &usize)| {
                let size = sizes[label];
                filling.held(*label, fold) as f64 * *count as f64 / (size * size)
            };
            let whole = (filling.totals[fold] * unit.samples.len()) as f64 / (y.len() as f64).powi(2);
            unit.labels.iter().map(share).sum::<f64>() + whole
        };
        let best = order.iter().copied().min_by(|a, b| cost(*a).total_cmp(&cost(*b)));
        #[expect(clippy::expect_used, reason = "fewer than two folds are refused")]
        filling.put(unit, best.expect("a fold at least"));
    }
    Ok(filling.folds())
}

/// Cuts the samples at random into training, validation and test parts that hold the same share of
/// every class, to within one sample; `units` as in [`stratified_k_fold`].
///
/// # Errors
///
/// If `y` is empty, if `units` has another length, or if a class is too small to be in every part.
pub fn random_split(
    y: &[u32],
    shares: Shares,
    seed: u64,
    repetition: u32,
    units: Option<&[u32]>,
) -> Result<Fold> {
    let singles = singles(y.len());
    let units = units.unwrap_or(&singles);
    let fold = three_parts(y, units, "units", shares, seed, &format!("split/random/{repetition}"))?;
    for (part, rows) in fold.parts(shares) {
        let absent = y.iter().find(|label| !rows.iter().any(|&row| y[row] == **label));
        if let Some(&class) = absent {
            return Err(Error::ClassNotInPart { class: class.into(), part });
        }
    }
    Ok(fold)
}

/// Cuts the samples at random into training, validation and test parts without cutting any group; sizes
/// and classes come as close to `shares` as whole groups allow.
///
/// # Errors
///
/// If `y` is empty, if `groups` has another length, or if a part gets no group.
pub fn random_group_split(
    groups: &[u32],
    y: &[u32],
    shares: Shares,
    seed: u64,
    repetition: u32,
) -> Result<Fold> {
    let fold = three_parts(y, groups, "groups", shares, seed, &format!("split/groups/{repetition}"))?;
    match fold.parts(shares).into_iter().find(|(_, rows)| rows.is_empty()) {
        Some((part, _)) => Err(Error::NoGroupForPart { part }),
        None => Ok(fold),
    }
}

/// Cuts each group in time: its first samples are trained on, its last ones, `share` of them, are tested. `groups` `[N]` names the
/// group of each sample, samples of a group in the order of time. The last `gap` samples before the cut are in neither part, such as
/// windows that reach across it.
///
/// # Errors
///
/// If a part would be empty.
pub fn chronological_split(groups: &[u32], share: f64, gap: usize) -> Result<Fold> {
    let mut fold = Fold::default();
    for unit in gather(&vec![0; groups.len()], groups) {
        let tested = (share * unit.samples.len() as f64).round() as usize;
        let (before, test) = unit.samples.split_at(unit.samples.len() - tested.min(unit.samples.len()));
        fold.train.extend(&before[..before.len().saturating_sub(gap)]);
        fold.test.extend(test);
    }
    if fold.train.is_empty() || fold.test.is_empty() {
        return Err(Error::NothingToSplit);
    }
    fold.train.sort_unstable();
    fold.test.sort_unstable();
    Ok(fold)
}

/// Takes about `share` of `rows` away, evenly over the classes and without cutting a unit (exact copies, or groups).
/// Returns the rows that are left, and those taken, both ascending. `purpose` chooses them.
///
/// # Errors
///
/// If one of the two would be empty.
///
/// # Panics
///
/// For a row that `y` or `units` has not.
pub fn hold_back(
    rows: &[usize],
    y: &[u32],
    units: Option<&[u32]>,
    share: f64,
    seed: u64,
    purpose: &str,
) -> Result<(Vec<usize>, Vec<usize>)> {
    let of = |table: &[u32]| rows.iter().map(|&row| table[row]).collect::<Vec<u32>>();
    let units = units.map_or_else(|| singles(rows.len()), of);
    let [left, taken, _] = deal(&of(y), &units, [1.0 - share, share, 0.0], seed, purpose);
    if left.is_empty() || taken.is_empty() {
        return Err(Error::NothingToHoldBack { samples: rows.len() });
    }
    let back = |part: Vec<usize>| part.into_iter().map(|i| rows[i]).collect();
    Ok((back(left), back(taken)))
}

/// Chooses `count` rows of every class among `pool`, ascending; of `units` whole ones, such as the frames of `count`
/// recordings. The rows for a smaller count are among those for a larger one, so that a learning curve only adds
/// samples.
///
/// # Errors
///
/// If a class has fewer rows, or units, in `pool`.
pub fn few_per_class(
    pool: &[usize],
    y: &[u32],
    count: usize,
    seed: u64,
    repetition: u32,
    units: Option<&[u32]>,
) -> Result<Vec<usize>> {
    let mut rng = taxel_base::seed::rng(seed, &format!("split/few/{repetition}"));
    let mut order = pool.to_vec();
    order.shuffle(&mut rng);
    let unit = |row: usize| units.map_or(row as u32, |units| units[row]);
    let mut taken: BTreeMap<u32, BTreeSet<u32>> = y.iter().map(|label| (*label, BTreeSet::new())).collect();
    for row in order {
        let of_class = taken.entry(y[row]).or_default();
        if of_class.len() < count {
            of_class.insert(unit(row));
        }
    }
    if let Some((&class, chosen)) = taken.iter().find(|(_, chosen)| chosen.len() < count) {
        return Err(Error::TooFewOfClass { class: class.into(), samples: chosen.len(), count });
    }
    let mut rows: Vec<usize> =
        pool.iter().copied().filter(|&row| taken[&y[row]].contains(&unit(row))).collect();
    rows.sort_unstable();
    Ok(rows)
}

impl Fold {
    /// Returns the parts that `shares` ask for, by name.
    fn parts(&self, shares: Shares) -> Vec<(&'static str, &[usize])> {
        let mut parts = vec![("training", self.train.as_slice()), ("test", self.test.as_slice())];
        if shares.validation > 0.0 {
            parts.push(("validation", self.validation.as_slice()));
        }
        parts
    }
}

fn three_parts(
    y: &[u32],
    units: &[u32],
    what: &'static str,
    shares: Shares,
    seed: u64,
    purpose: &str,
) -> Result<Fold> {
    refuse(y, units, what, 2)?;
    let Shares { test, validation } = shares;
    let [train, validation, test] =
        deal(y, units, [1.0 - validation - test, validation, test], seed, purpose);
    Ok(Fold { train, validation, test })
}

/// Deals whole units to three parts: each goes where most of its classes is still missing.
fn deal(y: &[u32], units: &[u32], shares: [f64; 3], seed: u64, purpose: &str) -> [Vec<usize>; 3] {
    let mut totals: BTreeMap<u32, f64> = BTreeMap::new();
    y.iter().for_each(|label| *totals.entry(*label).or_default() += 1.0);
    let mut units = gather(y, units);
    units.shuffle(&mut taxel_base::seed::rng(seed, purpose));
    units.sort_by_key(|unit| std::cmp::Reverse(unit.samples.len()));
    let mut held: [BTreeMap<u32, f64>; 3] = Default::default();
    let mut parts: [Vec<usize>; 3] = Default::default();
    for unit in units {
        let missing = |part: usize| -> f64 {
            let of = |(label, count): (&u32, &usize)| {
                let held = held[part].get(label).copied().unwrap_or(0.0);
                *count as f64 * (shares[part] - held / totals[label])
            };
            unit.labels.iter().map(of).sum()
        };
        let open = (0..3).filter(|part| shares[*part] > 0.0);
        // Of equals the first. NaN as share leaves the other parts empty, which callers refuse.
        let best = open.rev().max_by(|a, b| missing(*a).total_cmp(&missing(*b))).unwrap_or(0);
        for (label, count) in &unit.labels {
            *held[best].entry(*label).or_default() += *count as f64;
        }
        parts[best].extend(unit.samples);
    }
    parts.iter_mut().for_each(|part| part.sort_unstable());
    parts
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

/// Makes each sample a unit of its own.
fn singles(samples: usize) -> Vec<u32> {
    (0..samples as u32).collect()
}

/// Gathers the samples of each unit, units ascending.
fn gather(y: &[u32], units: &[u32]) -> Vec<SplitUnit> {
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (sample, unit) in units.iter().enumerate() {
        members.entry(*unit).or_default().push(sample);
    }
    let unit = |samples: Vec<usize>| {
        let mut labels = BTreeMap::new();
        samples.iter().for_each(|sample| *labels.entry(y[*sample]).or_default() += 1);
        SplitUnit { samples, labels }
    };
    members.into_values().map(unit).collect()
}

/// Folds that are filled unit by unit.
struct Filling {
    /// Number of samples of each label in each fold.
    counts: BTreeMap<u32, Vec<usize>>,
    /// Number of samples in each fold.
    totals: Vec<usize>,
    /// The fold that tests each sample.
    test_of: Vec<usize>,
}

impl Filling {
    fn new(samples: usize, k: usize) -> Self {
        Self { counts: BTreeMap::new(), totals: vec![0; k], test_of: vec![0; samples] }
    }

    /// Returns the number of samples of a label in a fold.
    fn held(&self, label: u32, fold: usize) -> usize {
        self.counts.get(&label).map_or(0, |counts| counts[fold])
    }

    fn put(&mut self, unit: &SplitUnit, fold: usize) {
        for (label, count) in &unit.labels {
            self.counts.entry(*label).or_insert_with(|| vec![0; self.totals.len()])[fold] += count;
        }
        self.totals[fold] += unit.samples.len();
        unit.samples.iter().for_each(|sample| self.test_of[*sample] = fold);
    }

    fn folds(&self) -> Vec<Fold> {
        let fold = |fold: usize| {
            let (test, train) = (0..self.test_of.len()).partition(|sample| self.test_of[*sample] == fold);
            Fold { train, test, validation: vec![] }
        };
        (0..self.totals.len()).map(fold).collect()
    }
}
