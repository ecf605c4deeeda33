//! What a data set holds, and what to mind before training on it.

use crate::dataset::{Axes, Dataset};
use crate::duplicates::{contradictory, duplicate_sets};
use crate::error::plural;
use crate::shortcut::Shortcut;
use crate::values::Values;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Below this many samples a class cannot fill the usual five folds.
const FEW: usize = 5;
/// A largest class this many times the smallest is worth a warning.
const UNEVEN: usize = 3;

/// One class and its size.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClassCount {
    /// Label in `y`.
    pub label: u32,
    /// Class name.
    pub name: String,
    /// Number of samples.
    pub samples: usize,
}

/// The groups of a data set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupSummary {
    /// What they are, such as `session` or `trial/12`.
    pub name: String,
    /// How many there are.
    pub groups: usize,
    /// Fewest and most samples in a group.
    pub samples: [usize; 2],
    /// Fewest and most classes in a group.
    pub classes: [usize; 2],
    /// Classes that occur in one group only: left out, they are never trained.
    pub classes_in_one_group: Vec<String>,
}

/// Range of one channel over all samples and times.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelRange {
    /// Index along the channel axis.
    pub channel: usize,
    /// Lowest finite value; none if there is no finite value.
    pub min: Option<f32>,
    /// Highest finite value.
    pub max: Option<f32>,
    /// Share of finite values equal to the lowest, 0..1.
    pub at_min: f64,
    /// Share of finite values equal to the highest, 0..1: near 0 unless the sensor saturates.
    pub at_max: f64,
}

/// Copies of one recording that carry different labels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contradiction {
    /// Indices of the samples, ascending.
    pub rows: Vec<usize>,
    /// Where they come from.
    pub sources: Vec<String>,
    /// Class name of each.
    pub labels: Vec<String>,
}

/// The description of a data set that `taxel data check` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Card {
    /// Name of the data set.
    pub name: String,
    /// BLAKE3 of the content, in hexadecimal.
    pub digest: String,
    /// Shape of `x`, samples first.
    pub shape: Vec<usize>,
    /// What the axes are; for a `.npz` a guess from rank and type.
    pub axes: Axes,
    /// Type of the stored values.
    pub dtype: String,
    /// Classes by label.
    pub classes: Vec<ClassCount>,
    /// Share of the largest class, 0..1: the score of always answering it.
    pub majority_share: f64,
    /// Groups, where the data set has them.
    pub groups: Option<GroupSummary>,
    /// Further arrays of the `.npz`; any of whole numbers `[N]` can serve as groups.
    pub other_arrays: Vec<String>,
    /// Lowest and highest finite value.
    pub range: Option<[f32; 2]>,
    /// Shares of finite values equal to the lowest and to the highest one, 0..1.
    pub saturation: [f64; 2],
    /// Number of NaN values.
    pub nan: usize,
    /// Number of infinite values.
    pub infinite: usize,
    /// Ranges per channel (or feature, or colour); empty for pressure images.
    pub channels: Vec<ChannelRange>,
    /// Number of taxels (channels, features or pixels).
    pub taxels: usize,
    /// Indices of taxels with one value in all samples: `[c]` or `[row, column]`.
    pub constant_taxels: Vec<Vec<usize>>,
    /// Indices of samples in which all values are equal.
    pub constant_samples: Vec<usize>,
    /// Sets of exact copies with one label, by index.
    pub duplicates: Vec<Vec<usize>>,
    /// Sets of exact copies with different labels.
    pub contradictions: Vec<Contradiction>,
    /// How many samples a few global statistics alone tell apart; none for under 40 samples or one class.
    pub shortcut: Option<Shortcut>,
    /// Sources of rows left out on request.
    pub dropped: Vec<String>,
    /// What keeps the data set from being loaded; empty if it loads.
    pub problems: Vec<String>,
    /// What does not keep it from being loaded, but distorts a score.
    pub warnings: Vec<String>,
}

impl Card {
    /// Describes `data`.
    pub fn new(data: &Dataset) -> Self {
        let counts = data.class_counts();
        let classes: Vec<ClassCount> = data
            .classes
            .iter()
            .zip(&counts)
            .enumerate()
            .map(|(label, (name, samples))| ClassCount {
                label: label as u32,
                name: name.clone(),
                samples: *samples,
            })
            .collect();
        let sets = duplicate_sets(&data.row_hash);
        let torn = contradictory(&sets, &data.y);
        let name = |row: usize| {
            let label = data.y[row];
            let name = data.classes.get(label as usize).cloned();
            name.unwrap_or_else(|| "no class".into())
        };
        let contradiction = |rows: &Vec<usize>| Contradiction {
            rows: rows.clone(),
            sources: rows.iter().map(|row| data.sources[*row].clone()).collect(),
            labels: rows.iter().map(|row| name(*row)).collect(),
        };
        let values = Values::of(data);
        let largest = counts.iter().max().copied().unwrap_or(0);
        let mut card = Self {
            name: data.name.clone(),
            digest: data.digest.clone(),
            shape: data.x.shape().to_vec(),
            axes: data.axes,
            dtype: data.dtype.clone(),
            classes,
            majority_share: largest as f64 / data.len().max(1) as f64,
            groups: groups(data),
            other_arrays: Vec::new(),
            range: values.all.range(),
            saturation: values.all.shares(),
            nan: values.nan,
            infinite: values.infinite,
            channels: values.channels(),
            taxels: values.taxels.len(),
            constant_taxels: values.constant_taxels(data),
            constant_samples: values.constant_samples,
            duplicates: sets.iter().filter(|set| !torn.contains(set)).cloned().collect(),
            contradictions: torn.iter().map(contradiction).collect(),
            shortcut: Shortcut::of(&data.x, &data.y, data.groups.as_deref(), Some(&data.units())),
            dropped: data.dropped.clone(),
            problems: Vec::new(),
            warnings: Vec::new(),
        };
        card.warnings = card.warn(data, &sets);
        card
    }

    fn warn(&self, data: &Dataset, sets: &[Vec<usize>]) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Some(first) = self.contradictions.first() {
            let rows: usize = self.contradictions.iter().map(|c| c.rows.len()).sum();
            let other = first.labels.iter().position(|label| *label != first.labels[0]);
            let other = other.unwrap_or(0);
            warnings.push(format!(
                "{rows} rows are copies of a row with another label, such as {} ({}) = {} ({}): \
                 set drop = [\"contradictory\"]",
                first.sources[0], first.labels[0], first.sources[other], first.labels[other]
            ));
        }
        if let Some(first) = self.duplicates.first() {
            warnings.push(format!(
                "{} of exact copies within a class, such as {} = {}: keep each set in one \
                 fold, or set drop = [\"duplicates\"]",
                plural(self.duplicates.len(), "set"),
                data.sources[first[0]],
                data.sources[first[1]]
            ));
        }
        if let Some(groups) = &data.groups {
            let torn = |set: &&Vec<usize>| set.iter().any(|row| groups[*row] != groups[set[0]]);
            let torn = sets.iter().filter(torn).count();
            if torn > 0 {
                warnings.push(format!(
                    "{} of exact copies across groups: a test group may hold what was trained on",
                    plural(torn, "set")
                ));
            }
        }
        if !self.constant_taxels.is_empty() {
            warnings.push(format!(
                "{} of {} taxels never change, the first is {:?}: dead, or always saturated",
                self.constant_taxels.len(),
                self.taxels,
                self.constant_taxels[0]
            ));
        }
        if let Some(first) = self.constant_samples.first() {
            warnings.push(format!(
                "{} with one value throughout, the first is {}: no contact?",
                plural(self.constant_samples.len(), "sample"),
                data.sources[*first]
            ));
        }
        self.warn_of_classes(&mut warnings);
        if let Some(shortcut) = self.shortcut.as_ref().filter(|shortcut| shortcut.is_suspicious()) {
            warnings
                .push(format!("{shortcut}: confounded? Part of every score may be the recording, not touch"));
        }
        if let Some(groups) = &self.groups {
            if groups.classes == [1, 1] && self.classes.len() > 1 {
                warnings.push(format!(
                    "every {} holds one class only: leaving one out tests on a single class",
                    groups.name
                ));
            }
            if let Some(first) = groups.classes_in_one_group.first() {
                warnings.push(format!(
                    "classes in one {} only: {} of {}, such as {first}: left out, they \
                     are never trained, so leave-group-out is impossible",
                    groups.name,
                    groups.classes_in_one_group.len(),
                    self.classes.len()
                ));
            }
        }
        warnings
    }

    fn warn_of_classes(&self, warnings: &mut Vec<String>) {
        if self.classes.len() == 1 {
            warnings.push("there is one class only: nothing to tell apart".into());
        }
        let by_size = |class: &&ClassCount| class.samples;
        let smallest = self.classes.iter().min_by_key(by_size);
        let largest = self.classes.iter().max_by_key(by_size);
        let (Some(smallest), Some(largest)) = (smallest, largest) else {
            return;
        };
        if smallest.samples < FEW {
            warnings.push(format!(
                "class {} has {}: too few for {FEW} folds",
                smallest.name,
                plural(smallest.samples, "sample")
            ));
        }
        if largest.samples > UNEVEN * smallest.samples {
            warnings.push(format!(
                "classes are uneven: {} has {} samples, {} has {}; read balanced accuracy",
                largest.name, largest.samples, smallest.name, smallest.samples
            ));
        }
    }
}

fn groups(data: &Dataset) -> Option<GroupSummary> {
    let groups = data.groups.as_ref()?;
    let mut of_group: BTreeMap<u32, (usize, BTreeSet<u32>)> = BTreeMap::new();
    let mut of_class: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for (group, label) in groups.iter().zip(&data.y) {
        let (samples, classes) = of_group.entry(*group).or_default();
        *samples += 1;
        classes.insert(*label);
        of_class.entry(*label).or_default().insert(*group);
    }
    let span = |sizes: Vec<usize>| {
        [sizes.iter().min().copied().unwrap_or(0), sizes.iter().max().copied().unwrap_or(0)]
    };
    let one = of_class.iter().filter(|(_, groups)| groups.len() == 1);
    Some(GroupSummary {
        name: data.group_name.clone().unwrap_or_else(|| "group".into()),
        groups: of_group.len(),
        samples: span(of_group.values().map(|(samples, _)| *samples).collect()),
        classes: span(of_group.values().map(|(_, classes)| classes.len()).collect()),
        classes_in_one_group: one
            .filter_map(|(label, _)| data.classes.get(*label as usize).cloned())
            .collect(),
    })
}
