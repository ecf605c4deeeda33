//! The score of a method that knows nothing of the sample.

use taxel_data::{Dataset, Targets, Values};
use taxel_learn::metrics::{Metric, Outcome};

use crate::case::Case;
use crate::error::Result;

impl Case {
    /// Returns what a method scores by the primary metric that knows nothing of the sample: always naming the commonest
    /// class, or always giving the mean.
    ///
    /// # Errors
    /// A data set without samples.
    pub fn chance(&self) -> Result<f64> {
        chance(&self.dataset)
    }
}

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
            let outcome = Outcome::new(&dataset.targets, &rows, means(values).repeat(rows.len()));
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

/// Returns the mean of each quantity over all samples.
pub(super) fn means(values: &Values) -> Vec<f32> {
    let width = values.quantities().len();
    let mean = |column: usize| {
        let column = values.values().iter().skip(column).step_by(width);
        let (sum, count) = column.fold((0.0, 0usize), |(sum, count), v| (sum + f64::from(*v), count + 1));
        (sum / count.max(1) as f64) as f32
    };
    (0..width).map(mean).collect()
}
