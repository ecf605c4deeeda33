//! Samples that vote on the class of each other by a few numbers.

use std::collections::BTreeMap;

/// Neighbours that vote.
pub(crate) const NEIGHBOURS: usize = 5;
/// With fewer samples luck looks like knowledge.
const LEAST: usize = 40;
/// Most samples that are measured, spread evenly over all.
const MOST: usize = 4000;

/// The samples that are measured, by their numbers.
pub(crate) struct Voters {
    /// Names of the numbers.
    pub names: Vec<String>,
    /// `[sample][number]`.
    pub as_measured: Vec<Vec<f64>>,
    /// The same with mean 0 and SD 1 in each number.
    pub table: Vec<Vec<f64>>,
    pub classes: Vec<u32>,
    /// Group and copies of each sample: who shares one of them does not vote.
    units: Vec<[u32; 2]>,
    /// Share of the largest class, 0..1.
    pub chance: f64,
    /// Whether units are groups.
    pub by_group: bool,
}

/// Picks the samples of labels `[N]` that are measured; none of fewer than 40, and of a single class.
pub(crate) fn measured(y: &[u32]) -> Option<Vec<usize>> {
    let step = y.len().div_ceil(MOST).max(1);
    let rows: Vec<usize> = (0..y.len()).step_by(step).collect();
    let first = y.first()?;
    (rows.len() >= LEAST && rows.iter().any(|row| y[*row] != *first)).then_some(rows)
}

impl Voters {
    /// Takes the numbers of `rows`, by name; labels, groups and copies are of all samples. None where a number is not finite.
    pub fn of(
        (names, as_measured): (Vec<String>, Vec<Vec<f64>>),
        rows: &[usize],
        y: &[u32],
        groups: Option<&[u32]>,
        copies: Option<&[u32]>,
    ) -> Option<Self> {
        if as_measured.iter().flatten().any(|value| !value.is_finite()) {
            return None;
        }
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        rows.iter().for_each(|&row| *counts.entry(y[row]).or_default() += 1);
        let largest = counts.values().max().copied().unwrap_or(0);
        let mut table = as_measured.clone();
        standardise(&mut table);
        let several = |groups: &&[u32]| groups.windows(2).any(|pair| pair[0] != pair[1]);
        let groups = groups.filter(|groups| groups.len() == y.len()).filter(several);
        let copies = copies.filter(|copies| copies.len() == y.len());
        let of = |units: Option<&[u32]>, row: usize| units.map_or(row as u32, |units| units[row]);
        Some(Self {
            names,
            as_measured,
            table,
            classes: rows.iter().map(|row| y[*row]).collect(),
            units: rows.iter().map(|row| [of(groups, *row), of(copies, *row)]).collect(),
            chance: largest as f64 / rows.len() as f64,
            by_group: groups.is_some(),
        })
    }

    /// Returns the share of samples that the nearest of other units by `table` put into the right class.
    pub fn accuracy(&self, table: &[Vec<f64>]) -> f64 {
        let all = 0..table.len();
        let right = all.clone().filter(|&at| {
            let is_other =
                |other: &usize| (0..2).all(|unit| self.units[*other][unit] != self.units[at][unit]);
            let others = all.clone().filter(is_other);
            vote(table, at, others.map(|other| (other, self.classes[other]))) == Some(self.classes[at])
        });
        right.count() as f64 / table.len() as f64
    }

    /// Returns the same for one number alone.
    pub fn accuracy_by(&self, number: usize) -> f64 {
        let column: Vec<Vec<f64>> = self.table.iter().map(|line| vec![line[number]]).collect();
        self.accuracy(&column)
    }
}

/// Brings every column to mean 0 and SD 1; a constant one to 0.
fn standardise(table: &mut [Vec<f64>]) {
    let n = table.len().max(1) as f64;
    for column in 0..table.first().map_or(0, Vec::len) {
        let mean = table.iter().map(|line| line[column]).sum::<f64>() / n;
        let sd = (table.iter().map(|line| (line[column] - mean).powi(2)).sum::<f64>() / n).sqrt();
        let sd = if sd > 1e-12 * mean.abs() { sd } else { f64::INFINITY };
        table.iter_mut().for_each(|line| line[column] = (line[column] - mean) / sd);
    }
}

/// Returns the class of most of the nearest; of equals the one with the nearer neighbours.
fn vote(table: &[Vec<f64>], at: usize, others: impl Iterator<Item = (usize, u32)>) -> Option<u32> {
    let mut nearest: Vec<(f64, u32)> = Vec::with_capacity(NEIGHBOURS + 1);
    for (other, class) in others {
        let distance: f64 = table[at].iter().zip(&table[other]).map(|(a, b)| (a - b) * (a - b)).sum();
        if nearest.len() == NEIGHBOURS && nearest.last().is_some_and(|(far, _)| *far <= distance) {
            continue;
        }
        let place = nearest.partition_point(|(near, _)| *near <= distance);
        nearest.insert(place, (distance, class));
        nearest.truncate(NEIGHBOURS);
    }
    let votes = |class: u32| nearest.iter().filter(|(_, vote)| *vote == class).count();
    // `max_by_key` returns the last of equals: in reversed order the nearest.
    nearest.iter().rev().map(|(_, class)| *class).max_by_key(|class| votes(*class))
}

#[cfg(test)]
mod tests {
    use super::vote;

    /// Votes of others at these distances.
    fn of(others: &[(f64, u32)]) -> Option<u32> {
        let places = [0.0].into_iter().chain(others.iter().map(|(far, _)| *far));
        let table: Vec<Vec<f64>> = places.map(|place| vec![place]).collect();
        vote(&table, 0, others.iter().enumerate().map(|(at, (_, class))| (at + 1, *class)))
    }

    #[test]
    fn the_five_nearest_vote_and_of_equals_the_nearer_ones_win() {
        assert_eq!(of(&[(1.0, 0), (2.0, 1), (3.0, 1), (4.0, 1), (5.0, 1)]), Some(1));
        let mut seven = [(1.0, 0), (2.0, 0), (3.0, 1), (4.0, 1), (5.0, 0), (6.0, 1), (7.0, 1)];
        assert_eq!(of(&seven), Some(0), "the sixth and the seventh do not vote");
        seven.reverse();
        assert_eq!(of(&seven), Some(0), "in any order");
        assert_eq!(of(&[(1.0, 2), (2.0, 1), (3.0, 1), (4.0, 0), (5.0, 0)]), Some(1));
        assert_eq!(of(&[]), None);
    }
}
