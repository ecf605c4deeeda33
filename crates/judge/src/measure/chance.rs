//! What guessing gets right.

use taxel_data::Dataset;

/// The share of samples in % that is right by always naming the commonest class; with several attributes
/// the mean over them.
pub(super) fn chance(dataset: &Dataset) -> f64 {
    let (sizes, truth) = (dataset.labels()?.sizes(), dataset.labels()?.values());
    let share = |attribute: usize, size: usize| {
        let mut counts = vec![0usize; size];
        let labels = truth.iter().skip(attribute).step_by(sizes.len());
        labels.for_each(|&label| counts[label as usize] += 1);
        counts.into_iter().max().unwrap_or(0) as f64 / dataset.len().max(1) as f64
    };
    let sum: f64 = sizes.iter().enumerate().map(|(i, &size)| share(i, size)).sum();
    100.0 * sum / sizes.len().max(1) as f64
}
