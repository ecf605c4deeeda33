//! Finds exact copies of recordings.

use crate::dataset::digest::RowHash;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;

/// Lists the sets of two or more samples with equal hash: indices ascending, sets by first index.
pub fn duplicate_sets(row_hash: &[RowHash]) -> Vec<Vec<usize>> {
    let mut rows: HashMap<&RowHash, Vec<usize>> = HashMap::new();
    for (i, hash) in row_hash.iter().enumerate() {
        rows.entry(hash).or_default().push(i);
    }
    let mut sets: Vec<_> = rows.into_values().filter(|set| set.len() > 1).collect();
    sets.sort_unstable();
    sets
}

/// Lists the sets of copies that carry more than one of `labels` (one per sample).
pub(crate) fn contradictory<L: Eq>(sets: &[Vec<usize>], labels: &[L]) -> Vec<Vec<usize>> {
    let differs = |set: &&Vec<usize>| set.windows(2).any(|pair| labels[pair[0]] != labels[pair[1]]);
    sets.iter().filter(differs).cloned().collect()
}

/// Lists the rows that repeat an earlier row with the same one of `labels` (one per sample).
pub(crate) fn later_copies<L: Eq + Hash>(sets: &[Vec<usize>], labels: &[L]) -> Vec<usize> {
    let mut later = Vec::new();
    for set in sets {
        let mut seen = HashSet::new();
        later.extend(set.iter().filter(|row| !seen.insert(&labels[**row])));
    }
    later
}

/// Returns for each sample the index of the first sample that is an exact copy of it.
pub(crate) fn units(row_hash: &[RowHash]) -> Vec<u32> {
    let mut first = HashMap::new();
    row_hash.iter().enumerate().map(|(i, hash)| *first.entry(hash).or_insert(i as u32)).collect()
}
