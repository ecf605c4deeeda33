//! Predictions for samples that no training saw.

use std::collections::{BTreeMap, BTreeSet};

use taxel_data::Dataset;

use crate::certainty::place::Place;
use crate::metrics::Outcome;
use crate::run::records::FoldRecord;

/// Fewest samples that something is fitted to.
pub(super) const LEAST: usize = 30;
/// Fewest samples of a group that is looked at.
const OF_GROUP: usize = 5;

/// Probabilities for labelled samples that the predicting model has not seen.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeldOut {
    /// `[n, outputs]`, row-major.
    pub probabilities: Vec<f32>,
    /// The logits behind them, `[n, outputs]`; empty where they are not known.
    pub logits: Vec<f32>,
    /// True labels `[n, attributes]`.
    pub truth: Vec<u32>,
    /// The part of the split that each sample was tested in, `[n]`.
    pub parts: Vec<u32>,
    /// The position of each sample in the data set, `[n]`; empty where that is not known.
    pub rows: Vec<usize>,
    /// The group of each sample, `[n]`; none without groups.
    pub groups: Option<Vec<u32>>,
    /// Where the model of each part has the samples that it has learned, if that is known: logits of two networks do not lie in
    /// the same place.
    pub places: BTreeMap<u32, Vec<Place>>,
}

impl HeldOut {
    /// Gathers the test parts of the folds of one row of a run. None of values.
    pub fn of_folds<'r>(
        records: impl IntoIterator<Item = &'r FoldRecord>,
        dataset: &Dataset,
    ) -> Option<Self> {
        let mut held = Self::of_dataset(dataset)?;
        for (part, record) in records.into_iter().filter(|record| !record.diverged).enumerate() {
            held.add(part as u32, &record.index, &record.outcome, &[], dataset, &[]);
        }
        Some(held)
    }

    /// Begins with nothing; none of values.
    pub fn of_dataset(dataset: &Dataset) -> Option<Self> {
        dataset.targets.labels()?;
        Some(HeldOut { groups: dataset.groups.as_ref().map(|_| vec![]), ..HeldOut::default() })
    }

    /// Adds the outcome of the samples `rows` of a data set with its logits, if they are known, but for the `refused` positions
    /// in it. Samples of a class that was not trained are left out too: no answer to them could be right.
    pub fn add(
        &mut self,
        part: u32,
        rows: &[usize],
        outcome: &Outcome,
        logits: &[f32],
        dataset: &Dataset,
        refused: &[usize],
    ) {
        let Outcome::Labels { truth, probabilities, .. } = outcome else { return };
        let (outputs, width) = (probabilities.len() / rows.len().max(1), truth.len() / rows.len().max(1));
        let each = rows.iter().zip(truth.chunks(width.max(1))).zip(probabilities.chunks(outputs.max(1)));
        for (at, ((sample, labels), row)) in each.enumerate() {
            let is_untrained = |(at, label): (usize, &u32)| outcome.untrained(at).contains(label);
            if refused.contains(&at) || labels.iter().enumerate().any(is_untrained) {
                continue;
            }
            self.probabilities.extend(row);
            self.logits.extend(logits.get(at * outputs..(at + 1) * outputs).unwrap_or_default());
            self.truth.extend(labels);
            self.parts.push(part);
            self.rows.push(*sample);
            if let (Some(held), Some(groups)) = (&mut self.groups, &dataset.groups) {
                held.push(groups[*sample]);
            }
        }
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Checks whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Divides predictions of one part alone, by groups if there are some, so that what is fitted on one part can be tried on
    /// another. All are of one model.
    pub(super) fn divided(&self) -> Self {
        /// Parts of samples without groups.
        const PARTS: u32 = 5;
        let whole = self.each_part();
        let Some(part) = whole.first().filter(|_| whole.len() == 1) else { return self.clone() };
        let by_group = self.groups.clone().filter(|groups| groups.iter().any(|group| *group != groups[0]));
        let parts = by_group.unwrap_or_else(|| (0..self.len() as u32).map(|row| row % PARTS).collect());
        let places = self
            .places
            .get(part)
            .map_or(BTreeMap::new(), |places| parts.iter().map(|part| (*part, places.clone())).collect());
        HeldOut { parts, places, ..self.clone() }
    }

    /// Lists the parts.
    pub(super) fn each_part(&self) -> BTreeSet<u32> {
        self.parts.iter().copied().collect()
    }

    /// Selects the samples for which `keep` says yes by their position.
    pub(super) fn select(&self, keep: impl Fn(usize) -> bool) -> Self {
        let rows: Vec<usize> = (0..self.len()).filter(|row| keep(*row)).collect();
        HeldOut {
            probabilities: of_rows(&self.probabilities, &rows, self.len()),
            logits: of_rows(&self.logits, &rows, self.len()),
            truth: of_rows(&self.truth, &rows, self.len()),
            parts: of_rows(&self.parts, &rows, self.len()),
            rows: of_rows(&self.rows, &rows, self.len()),
            groups: self.groups.as_ref().map(|groups| of_rows(groups, &rows, self.len())),
            places: self.places.clone(),
        }
    }
}

/// Lists the positions of the samples of each group that has enough of them; none without groups.
pub(super) fn large_groups(groups: Option<&[u32]>) -> Vec<Vec<usize>> {
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (row, group) in groups.unwrap_or_default().iter().enumerate() {
        members.entry(*group).or_default().push(row);
    }
    members.into_values().filter(|members| members.len() >= OF_GROUP).collect()
}

/// Returns the position, from 0, of the value that the share of n + 1 sorted ones does not pass (Lei et al. 2018); n or more
/// where n are too few.
pub(super) fn conformal_rank(n: usize, share: f64) -> usize {
    // Without the rounding error of a product such as 0.9 × 30.
    let rank = (share * (n + 1) as f64 - 1e-9).ceil() as usize;
    rank.max(1) - 1
}

/// Returns the values of some of `count` rows.
fn of_rows<T: Copy>(values: &[T], rows: &[usize], count: usize) -> Vec<T> {
    let each = values.len() / count.max(1);
    rows.iter().flat_map(|row| &values[row * each..(row + 1) * each]).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_one_model_have_its_places() {
        let held =
            HeldOut { truth: vec![0; 6], parts: vec![3; 6], rows: (0..6).collect(), ..HeldOut::default() };
        let place = Place { center: vec![1.0], within: vec![1.0], around: vec![1.0], means: vec![0.0] };
        let of_network = HeldOut { places: [(3, vec![place.clone()])].into(), ..held.clone() };
        let grouped = HeldOut { groups: Some(vec![7, 7, 8, 8, 8, 9]), ..of_network.clone() };
        assert_eq!((held.divided().parts, held.divided().places.len()), (vec![0, 1, 2, 3, 4, 0], 0));
        assert_eq!(grouped.divided().parts, [7, 7, 8, 8, 8, 9]);
        for divided in [of_network.divided(), grouped.divided()] {
            let places: BTreeSet<u32> = divided.places.keys().copied().collect();
            assert_eq!(places, divided.each_part());
            assert!(divided.places.values().all(|places| *places == [place.clone()]));
        }
        let two = HeldOut { parts: vec![0, 0, 0, 1, 1, 1], ..held };
        assert_eq!(two.divided(), two);
    }
}
