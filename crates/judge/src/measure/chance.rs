//! What a method gets that knows nothing of the sample.

use taxel_data::{Dataset, Targets};
use taxel_learn::metrics::{Metric, Outcome};

use crate::error::Result;

/// Returns the primary metric of always naming the commonest class, with several attributes the mean over them, or of
/// always giving the mean of each value.
///
/// # Errors
/// A data set without samples.
pub(super) fn chance(dataset: &Dataset) -> Result<f64> {
    let (task, rows) = (dataset.task(), (0..dataset.len()).collect::<Vec<_>>());
    let labels = match &dataset.targets {
        Targets::Classes { labels, .. } | Targets::Levels(labels) => labels,
        Targets::Values(values) => {
            let width = values.quantities().len();
            let mean = |column: usize| {
                let sum: f64 =
                    values.values().iter().skip(column).step_by(width).map(|v| f64::from(*v)).sum();
                (sum / rows.len() as f64) as f32
            };
            let means: Vec<f32> = (0..width).map(mean).collect();
            let outcome = Outcome::new(&dataset.targets, &rows, means.repeat(rows.len()));
            return Ok(Metric::primary(&task).of(&task, &outcome)?);
        }
    };
    let (sizes, truth) = (labels.sizes(), labels.values());
    let share = |attribute: usize, size: usize| {
        let mut counts = vec![0usize; size];
        let labels = truth.iter().skip(attribute).step_by(sizes.len());
        labels.for_each(|&label| counts[label as usize] += 1);
        counts.into_iter().max().unwrap_or(0) as f64 / dataset.len().max(1) as f64
    };
    let sum: f64 = sizes.iter().enumerate().map(|(i, &size)| share(i, size)).sum();
    Ok(100.0 * sum / sizes.len().max(1) as f64)
}
