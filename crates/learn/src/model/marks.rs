//! Marks of training samples, by which recordings are known again that a model has learned from.

use std::collections::HashSet;

use ndarray::{ArrayRef, IxDyn};
use taxel_data::hash_row;

/// Marks that a model keeps.
const KEPT: usize = 64;
/// Known ones from which on recordings count as learned: one alone may be a sample without contact, which is equal everywhere.
const KNOWN: usize = 2;

/// Returns the smallest marks of the samples `rows` of `x` `[n, ..]`, ascending. Whatever else stands in their data set, the same
/// samples have the same marks.
pub fn marks(x: &ArrayRef<f32, IxDyn>, rows: impl Iterator<Item = usize>) -> Vec<u32> {
    let mut marks: Vec<u32> = all(x, rows).into_iter().collect();
    marks.sort_unstable();
    marks.truncate(KEPT);
    marks
}

/// Counts the `marks` that samples of `x` `[n, ..]` have; 0 where it may be chance.
pub fn known(marks: &[u32], x: &ArrayRef<f32, IxDyn>) -> usize {
    let here = all(x, 0..x.shape().first().copied().unwrap_or(0));
    let known = marks.iter().filter(|mark| here.contains(mark)).count();
    if known < KNOWN { 0 } else { known }
}

/// Returns the marks of the samples `rows`: the first four bytes of their hashes.
fn all(x: &ArrayRef<f32, IxDyn>, rows: impl Iterator<Item = usize>) -> HashSet<u32> {
    let x = x.as_standard_layout();
    let each = x.shape().iter().skip(1).product::<usize>();
    let values = x.as_slice().unwrap_or(&[]);
    let mark = |row: usize| {
        let [a, b, c, d, ..] = hash_row(&values[row * each..(row + 1) * each]);
        u32::from_le_bytes([a, b, c, d])
    };
    rows.map(mark).collect()
}

#[cfg(test)]
mod tests {
    use ndarray::{Array, Axis};

    use super::*;

    #[test]
    fn samples_are_known_in_whatever_set_they_stand() {
        let x = Array::from_shape_fn(vec![200, 2, 3], |at| (at[0] * 100 + at[1] * 10 + at[2]) as f32);
        let kept = marks(&x, 0..100);
        assert_eq!((kept.len(), known(&kept, &x)), (KEPT, KEPT));
        let mut some = x.select(Axis(0), &(50..150).collect::<Vec<_>>());
        assert!((10..KEPT).contains(&known(&kept, &some)));
        some.fill(1.0);
        assert_eq!(known(&kept, &some), 0);
        assert_eq!(known(&kept, &x.select(Axis(0), &(100..200).collect::<Vec<_>>())), 0);
        // One equal sample may be chance.
        let first = marks(&x, 0..1);
        assert_eq!((first.len(), known(&first, &x)), (1, 0));
    }
}
