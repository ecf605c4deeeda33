//! Where one of two is right and the other is not: class by class, of values by parts of their range.

use std::collections::BTreeMap;

use taxel_data::{Quantity, Task};
use taxel_learn::FoldRecord;

use crate::values::{Place, Primary, Right};

/// Parts of the range of a quantity, with equally many samples each.
const PARTS: usize = 3;

/// The records of both for the same part.
type Pair = (FoldRecord, FoldRecord);

/// Lists the truth and both predictions of each sample, once however often it was tested.
fn each<T: Copy>(pairs: &[Pair], width: usize, of: fn(&FoldRecord) -> (&[T], &[T])) -> Vec<[Vec<T>; 3]> {
    let mut found: BTreeMap<usize, [Vec<T>; 3]> = BTreeMap::new();
    for (a, b) in pairs {
        let ((truth, first), (_, second)) = (of(a), of(b));
        for (row, sample) in a.index.iter().enumerate() {
            let place = row * width..(row + 1) * width;
            let cut = |all: &[T]| all.get(place.clone()).map(<[T]>::to_vec);
            if let (Some(truth), Some(first), Some(second)) = (cut(truth), cut(first), cut(second)) {
                found.entry(*sample).or_insert([truth, first, second]);
            }
        }
    }
    found.into_values().collect()
}

fn labels(task: &Task, pairs: &[Pair]) -> Vec<[Vec<u32>; 3]> {
    each(pairs, task.attributes().len(), |record| record.outcome.labels())
}

/// Counts samples by who is right, of several attributes in all of them; none of values.
pub(super) fn right(task: &Task, pairs: &[Pair]) -> Option<Right> {
    let samples = labels(task, pairs);
    if !task.quantities().is_empty() || samples.is_empty() {
        return None;
    }
    let mut right = Right::default();
    for [truth, a, b] in samples {
        match (a == truth, b == truth) {
            (true, true) => right.both += 1,
            (true, false) => right.only[0] += 1,
            (false, true) => right.only[1] += 1,
            (false, false) => right.neither += 1,
        }
    }
    Some(right)
}

/// Lists the classes of each attribute, or the parts of the range of each quantity, that have samples.
pub(super) fn places(task: &Task, pairs: &[Pair]) -> Vec<Place> {
    if task.quantities().is_empty() { classes(task, pairs) } else { ranges(task, pairs) }
}

fn classes(task: &Task, pairs: &[Pair]) -> Vec<Place> {
    let samples = labels(task, pairs);
    let attributes = task.attributes();
    let mut found = vec![];
    for (at, attribute) in attributes.iter().enumerate() {
        for (class, name) in attribute.classes.iter().enumerate() {
            let of_class: Vec<[bool; 2]> = samples
                .iter()
                .filter(|[truth, ..]| truth[at] as usize == class)
                .map(|[truth, a, b]| [a[at] == truth[at], b[at] == truth[at]])
                .collect();
            if of_class.is_empty() {
                continue;
            }
            let count = |is: &dyn Fn(&[bool; 2]) -> bool| of_class.iter().filter(|right| is(right)).count();
            let share = |side: usize| 100.0 * count(&|right| right[side]) as f64 / of_class.len() as f64;
            let only = [count(&|right| right[0] && !right[1]), count(&|right| !right[0] && right[1])];
            let of = if attributes.len() > 1 { attribute.name.clone() } else { String::new() };
            let (samples, scores) = (of_class.len(), [share(0), share(1)]);
            found.push(Place { of, name: name.clone(), samples, scores, only });
        }
    }
    found
}

fn ranges(task: &Task, pairs: &[Pair]) -> Vec<Place> {
    let quantities = task.quantities();
    let samples = each(pairs, quantities.len(), |record| record.outcome.values());
    let show = Primary::of(task).show_longer();
    let mut found = vec![];
    for (at, Quantity { name, unit }) in quantities.iter().enumerate() {
        let mut rows: Vec<[f64; 3]> =
            samples.iter().map(|[truth, a, b]| [truth, a, b].map(|all| f64::from(all[at]))).collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let size = rows.len().div_ceil(PARTS).max(1);
        for part in rows.chunks(size) {
            let errors = part.iter().map(|[truth, a, b]| [(a - truth).abs(), (b - truth).abs()]);
            let errors: Vec<[f64; 2]> = errors.collect();
            let mean = |side: usize| errors.iter().map(|both| both[side]).sum::<f64>() / errors.len() as f64;
            let closer = |side: usize| errors.iter().filter(|both| both[side] < both[1 - side]).count();
            let ends = (show(part[0][0]), show(part[part.len() - 1][0]));
            let unit = unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
            found.push(Place {
                of: name.clone(),
                name: format!("{} to {}{unit}", ends.0, ends.1),
                samples: part.len(),
                scores: [mean(0), mean(1)],
                only: [closer(0), closer(1)],
            });
        }
    }
    found
}
