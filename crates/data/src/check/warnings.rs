//! Warns of properties of a data set that distort a score.

use crate::check::card::{Card, ClassCount};
use crate::check::counting::counting;
use crate::check::value_confounds::confounds;
use crate::dataset::dataset::Dataset;
use crate::dataset::labels::differ_in_case;
use crate::dataset::targets::Targets;
use crate::error::plural;

/// A class of fewer samples cannot fill the usual five folds.
const FEW: usize = 5;
/// A largest class this many times the smallest is worth a warning.
const UNEVEN: usize = 3;

/// More classes that are whole numbers may be values.
const MANY: usize = 50;
/// So may this many, where there are less than three samples for each.
const SOME: usize = 5;

/// Returns the warnings about `data`, whose card is complete but for them; `sets` are its exact copies.
pub(crate) fn warnings(card: &Card, data: &Dataset, sets: &[Vec<usize>]) -> Vec<String> {
    let mut warnings = data.warnings.clone();
    of_copies(card, data, sets, &mut warnings);
    if !card.constant_taxels.is_empty() {
        warnings.push(format!(
            "{} of {} taxels never change, the first is {:?}: dead, or always saturated",
            card.constant_taxels.len(),
            card.taxels,
            card.constant_taxels[0]
        ));
    }
    if let Some(first) = card.constant_samples.first() {
        warnings.push(format!(
            "{} with one value throughout, the first is {}: no contact?",
            plural(card.constant_samples.len(), "sample"),
            data.origins[*first]
        ));
    }
    for channel in counting(data) {
        let name = data.spec.channel_names.get(channel).map_or(String::new(), |name| format!(" {name:?}"));
        warnings.push(format!(
            "channel {channel}{name} only counts up: an index or a clock tells recordings apart without touch; leave it out"
        ));
    }
    of_classes(card, &mut warnings);
    if let Targets::Classes { .. } = data.targets {
        of_numbers(card, &mut warnings);
    }
    if let Some(shortcut) = card.shortcut.as_ref().filter(|shortcut| shortcut.is_suspicious()) {
        warnings.push(format!("{shortcut}: confounded? Part of every score may be the recording, not touch"));
    }
    of_groups(card, &mut warnings);
    warnings.extend(confounds(data));
    warnings
}

/// Checks whether two samples have other targets.
fn differs(data: &Dataset, a: usize, b: usize) -> bool {
    match data.targets.values() {
        Some(values) => values.of(&[a]) != values.of(&[b]),
        None => data.strata()[a] != data.strata()[b],
    }
}

/// Warns of whole numbers that are more likely values than classes.
fn of_numbers(card: &Card, warnings: &mut Vec<String>) {
    let (classes, samples) = (card.classes.len(), card.shape[0]);
    let is_much = classes > MANY || classes >= SOME && classes * 3 > samples;
    if is_much && card.classes.iter().all(|class| class.name.parse::<f64>().is_ok()) {
        warnings.push(format!(
            "{classes} classes of {samples} samples are whole numbers: if they are measured values, say task = \"values\" \
             (--task values)"
        ));
    }
}

fn of_copies(card: &Card, data: &Dataset, sets: &[Vec<usize>], warnings: &mut Vec<String>) {
    if let Some(first) = card.contradictions.first() {
        let rows: usize = card.contradictions.iter().map(|c| c.rows.len()).sum();
        let other =
            (1..first.rows.len()).find(|at| differs(data, first.rows[0], first.rows[*at])).unwrap_or(1);
        let label = if data.targets.values().is_some() { "value" } else { "label" };
        warnings.push(format!(
            "{rows} rows are copies of a row with another {label}, such as {} ({}) = {} ({}): \
             set drop = [\"contradictory\"]",
            first.sources[0], first.labels[0], first.sources[other], first.labels[other]
        ));
    }
    if let Some(first) = card.duplicates.first() {
        warnings.push(format!(
            "{} of exact copies {}, such as {} = {}: keep each set in one \
             fold, or set drop = [\"duplicates\"]",
            plural(card.duplicates.len(), "set"),
            if data.targets.values().is_some() { "of equal value" } else { "within a class" },
            data.origins[first[0]],
            data.origins[first[1]]
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
}

fn of_groups(card: &Card, warnings: &mut Vec<String>) {
    let Some(groups) = &card.groups else { return };
    if groups.classes == [1, 1] && card.classes.len() > 1 {
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
            card.classes.len()
        ));
    }
}

fn of_classes(card: &Card, warnings: &mut Vec<String>) {
    let by_size = |class: &&ClassCount| class.samples;
    let smallest = card.classes.iter().min_by_key(by_size);
    let largest = card.classes.iter().max_by_key(by_size);
    let (Some(smallest), Some(largest)) = (smallest, largest) else {
        return;
    };
    let names: Vec<String> = card.classes.iter().map(|class| class.name.clone()).collect();
    if let Some((first, second)) = differ_in_case(&names) {
        warnings.push(format!(
            "classes {first:?} and {second:?} differ only in capital letters: one class of two spellings?"
        ));
    }
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
