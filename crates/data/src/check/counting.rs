//! Finds channels whose values only count: row numbers and clocks, whatever they are called.

use crate::dataset::dataset::Dataset;
use ndarray::Axis;
use taxel_base::Layout;

/// Fewest values that show that a channel counts.
const COUNTED: usize = 5;
/// Largest distance of a step from the first one, as a share of it: clocks jitter.
const JITTER: f64 = 1e-3;

/// Returns the channels that rise by one step from time step to time step in every sample, or as features from sample to
/// sample.
pub(crate) fn counting(data: &Dataset) -> Vec<usize> {
    match data.spec.layout {
        Layout::Features => {
            let counts = |at: &usize| rises(data.x.index_axis(Axis(1), *at).iter());
            (0..data.x.shape()[1]).filter(counts).collect()
        }
        Layout::Series => {
            let of_all = |at: &usize| {
                data.x.axis_iter(Axis(0)).all(|sample| rises(sample.index_axis(Axis(0), *at).iter()))
            };
            (0..data.x.shape()[1]).filter(of_all).collect()
        }
        _ => vec![],
    }
}

/// Checks whether numbers rise by one step.
fn rises<'v>(values: impl Iterator<Item = &'v f32>) -> bool {
    let (mut count, mut last, mut step) = (0, 0.0, None);
    for value in values.map(|value| f64::from(*value)) {
        if count > 0 {
            let first: f64 = *step.get_or_insert(value - last);
            // f32 rounds what it holds.
            let rounding = f64::from(f32::EPSILON) * value.abs();
            if first.is_nan() || first <= 0.0 || (value - last - first).abs() > JITTER * first + rounding {
                return false;
            }
        }
        (last, count) = (value, count + 1);
    }
    count >= COUNTED
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_still_does_not_count() {
        assert!(!rises([7.0; 8].iter()));
        assert!(rises([0.0, 1.0, 2.0, 3.0, 4.0, 5.0].iter()));
    }
}
