//! Fills the card of a data set: its classes, groups, values and copies.

use crate::check::card::{Card, ClassCount, Contradiction, GroupSummary};
use crate::check::duplicates::{contradictory, duplicate_sets};
use crate::check::quantities::{QuantitySummary, short};
use crate::check::shortcut::Shortcut;
use crate::check::values::ValueStatistics;
use crate::check::warnings::warnings;
use crate::dataset::dataset::Dataset;
use crate::dataset::targets::{Quantity, Values};
use std::collections::{BTreeMap, BTreeSet};

impl Card {
    /// Describes `data`.
    pub fn new(data: &Dataset) -> Self {
        let (names, counts) = (data.output_names(), data.class_counts());
        let sets = duplicate_sets(&data.row_hash);
        let has_labels = data.targets.labels().is_some();
        let strata = data.strata();
        let torn = contradictory(&sets, &compared(data));
        let name = |row: usize| match data.outputs(row).as_slice() {
            [] => data.targets.values().map_or_else(|| "no class".into(), |values| value(values, row)),
            outputs => outputs.iter().map(|&at| names[at].as_str()).collect::<Vec<_>>().join(", "),
        };
        let contradiction = |rows: &Vec<usize>| Contradiction {
            rows: rows.clone(),
            sources: rows.iter().map(|row| data.origins[*row].clone()).collect(),
            labels: rows.iter().map(|row| name(*row)).collect(),
        };
        let values = ValueStatistics::of(data);
        let largest = counts.iter().max().map_or(0, |count| *count);
        let mut card = Self {
            name: data.name.clone(),
            digest: data.digest.clone(),
            shape: data.x.shape().to_vec(),
            layout: data.spec.layout,
            lengths: None,
            read_as: Vec::new(),
            dtype: data.dtype.clone(),
            classes: classes(&names, &counts),
            labels: data.targets.values().map(ranges),
            quantities: QuantitySummary::all(data),
            majority_share: largest as f64 / data.len().max(1) as f64,
            groups: groups(data),
            other_arrays: Vec::new(),
            ignored: Vec::new(),
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
            shortcut: Shortcut::of(&data.x, &strata, data.groups.as_deref(), data.units.as_deref())
                .filter(|_| has_labels),
            dropped: data.dropped.clone(),
            without_target: 0,
            problems: data.refuse_one_class().err().iter().map(ToString::to_string).collect(),
            warnings: Vec::new(),
        };
        card.warnings = warnings(&card, data, &sets);
        card
    }
}

/// Lists the classes by label, with their sizes; none of values.
fn classes(names: &[String], counts: &[usize]) -> Vec<ClassCount> {
    let one = |(label, (name, samples)): (usize, (&String, &usize))| ClassCount {
        label: label as u32,
        name: name.clone(),
        samples: *samples,
    };
    names.iter().zip(counts).enumerate().map(one).collect()
}

/// Returns by sample what copies are compared by: the stratum of its classes, or its values.
fn compared(data: &Dataset) -> Vec<Vec<u32>> {
    let bits = |values: &Values, row: usize| values.of(&[row]).into_iter().map(f32::to_bits).collect();
    match data.targets.values() {
        Some(values) => (0..data.len()).map(|row| bits(values, row)).collect(),
        None => data.strata().iter().map(|stratum| vec![*stratum]).collect(),
    }
}

/// Writes the values of a sample.
fn value(values: &Values, row: usize) -> String {
    let one = |(value, quantity): (f32, &Quantity)| match &quantity.unit {
        Some(unit) => format!("{} {unit}", short(f64::from(value))),
        None => short(f64::from(value)),
    };
    let all: Vec<String> = values.of(&[row]).into_iter().zip(values.quantities()).map(one).collect();
    all.join(", ")
}

/// Describes targets that are values: `values: force 0.1 to 9.8 N`.
fn ranges(values: &Values) -> String {
    let count = values.quantities().len();
    let of_one = |(column, quantity): (usize, &Quantity)| {
        let measured = values.values().iter().skip(column).step_by(count.max(1));
        let (low, high) = measured.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| {
            (low.min(*value), high.max(*value))
        });
        let unit = quantity.unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
        format!("{} {low} to {high}{unit}", quantity.name)
    };
    let each: Vec<String> = values.quantities().iter().enumerate().map(of_one).collect();
    format!("values: {}", each.join(", "))
}

fn groups(data: &Dataset) -> Option<GroupSummary> {
    let groups = data.groups.as_ref()?;
    let mut of_group: BTreeMap<u32, (usize, BTreeSet<usize>)> = BTreeMap::new();
    let mut of_class: BTreeMap<usize, BTreeSet<u32>> = BTreeMap::new();
    for (row, group) in groups.iter().enumerate() {
        let (samples, classes) = of_group.entry(*group).or_default();
        *samples += 1;
        for class in data.outputs(row) {
            classes.insert(class);
            of_class.entry(class).or_default().insert(*group);
        }
    }
    let span = |sizes: Vec<usize>| {
        let least = sizes.iter().min().map_or(0, |size| *size);
        let most = sizes.iter().max().map_or(0, |size| *size);
        [least, most]
    };
    let names = data.output_names();
    let one = of_class.iter().filter(|(_, groups)| groups.len() == 1);
    Some(GroupSummary {
        name: data.group_name.clone().unwrap_or_else(|| "group".into()),
        groups: of_group.len(),
        samples: span(of_group.values().map(|(samples, _)| *samples).collect()),
        classes: span(of_group.values().map(|(_, classes)| classes.len()).collect()),
        classes_in_one_group: one.map(|(class, _)| names[*class].clone()).collect(),
    })
}
