//! Measures whether values drift over the order in which samples were recorded.

use crate::dataset::dataset::Dataset;
use std::collections::BTreeMap;

/// The mean value of each sample, in the order of the samples, and its correlation with that order.
#[derive(Debug, Clone, PartialEq)]
pub struct Drift {
    /// Mean of each sample's finite values, in their unit; NaN where there is none.
    pub means: Vec<f64>,
    /// Correlation of the mean with the place of a sample among those of its own class, -1 to 1: classes that were
    /// recorded one after the other do not count as drift. None where either does not vary.
    pub correlation: Option<f64>,
}

impl Drift {
    /// Measures the samples of `data`, whose order is taken for that of the recording.
    pub fn of(data: &Dataset) -> Self {
        let mean = |sample: ndarray::ArrayViewD<f32>| {
            let finite = sample.iter().filter(|v| v.is_finite());
            let (sum, count) = finite.fold((0.0, 0usize), |(sum, n), v| (sum + f64::from(*v), n + 1));
            sum / count as f64
        };
        let means: Vec<f64> = data.x.outer_iter().map(mean).collect();
        let mut classes: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        for (class, mean) in data.strata().iter().zip(&means).filter(|(_, mean)| mean.is_finite()) {
            classes.entry(*class).or_default().push(*mean);
        }
        Self { correlation: correlation(classes.into_values()), means }
    }
}

/// Returns Pearson's correlation of the values of each class with their places, both from the mean of the class.
fn correlation(classes: impl Iterator<Item = Vec<f64>>) -> Option<f64> {
    let (mut both, mut of_place, mut of_value) = (0.0, 0.0, 0.0);
    for values in classes {
        let middle = (values.len() - 1) as f64 / 2.0;
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        for (place, value) in values.iter().enumerate() {
            // The first and the last of a class are as far apart in every class.
            let place = (place as f64 - middle) / middle.max(1.0);
            both += place * (value - mean);
            of_place += place * place;
            of_value += (value - mean) * (value - mean);
        }
    }
    (of_place > 0.0 && of_value > 0.0).then(|| both / (of_place * of_value).sqrt())
}

#[cfg(test)]
mod tests {
    use super::correlation;

    #[test]
    fn order_within_classes_counts_and_order_of_classes_does_not() {
        let of = |classes: &[&[f64]]| correlation(classes.iter().map(|class| class.to_vec()));
        assert_eq!(of(&[&[1.0, 1.0, 1.0], &[9.0, 9.0, 9.0]]), None, "only the classes differ");
        assert!((of(&[&[1.0, 2.0, 3.0], &[7.0, 8.0, 9.0]]).unwrap_or(0.0) - 1.0).abs() < 1e-12);
        assert!((of(&[&[3.0, 2.0, 1.0]]).unwrap_or(0.0) + 1.0).abs() < 1e-12);
        // numpy.corrcoef([0, 1, 2, 3], [1, 4, 2, 6])[0, 1]
        assert!((of(&[&[1.0, 4.0, 2.0, 6.0]]).unwrap_or(0.0) - 0.7568892626614565).abs() < 1e-12);
        assert_eq!(of(&[&[1.0], &[5.0]]), None);
    }
}
