//! Describes targets that are values: where they lie, what stands out, what always answering the mean scores.

use crate::dataset::dataset::Dataset;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// Bins of the histogram.
const BINS: usize = 10;
/// Heights of its bars.
const BARS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// A value farther outside the middle half than this many times its width is an outlier.
const FAR: f64 = 3.0;
/// Most outliers that are named.
const WORST: usize = 3;

/// The values of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QuantitySummary {
    /// `force`.
    pub name: String,
    /// `N`, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Samples with a finite value; all others are left out of the figures.
    pub samples: usize,
    /// Lowest and highest value.
    pub range: [f64; 2],
    /// Mean.
    pub mean: f64,
    /// Standard deviation (of samples: n - 1).
    pub sd: f64,
    /// First quartile, median and third quartile, between values where they lie there.
    pub quartiles: [f64; 3],
    /// Number of values in each tenth of the range.
    pub bins: Vec<usize>,
    /// Number of values farther outside the middle half than three times its width.
    pub outliers: usize,
    /// Where the farthest of them are.
    pub worst: Vec<String>,
    /// Mean absolute error and root of the mean squared error of always answering the mean of the other samples or, where
    /// there are several groups, of the other groups.
    pub mean_errors: [f64; 2],
    /// The mean is that of other groups.
    pub by_group: bool,
}

impl QuantitySummary {
    /// Describes each quantity of a data set; none of classes.
    pub(crate) fn all(data: &Dataset) -> Vec<Self> {
        let Some(values) = data.targets.values() else { return vec![] };
        let width = values.quantities().len();
        let of = |(at, quantity): (usize, &crate::Quantity)| {
            let column: Vec<f64> =
                values.values().iter().skip(at).step_by(width).map(|value| f64::from(*value)).collect();
            let rows: Vec<usize> = (0..column.len()).filter(|row| column[*row].is_finite()).collect();
            let finite: Vec<f64> = rows.iter().map(|row| column[*row]).collect();
            let groups = data.groups.as_ref().map(|groups| rows.iter().map(|row| groups[*row]).collect());
            let origin = |row: usize| data.origins[rows[row]].clone();
            let mut one = Self::of(&finite, groups, origin)?;
            (one.name, one.unit) = (quantity.name.clone(), quantity.unit.clone());
            Some(one)
        };
        values.quantities().iter().enumerate().filter_map(of).collect()
    }

    fn of(values: &[f64], groups: Option<Vec<u32>>, origin: impl Fn(usize) -> String) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (low, high) = (*sorted.first()?, *sorted.last()?);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let quartiles = [0.25, 0.5, 0.75].map(|share| quantile(&sorted, share));
        let mut bins = vec![0; BINS];
        for value in values {
            let place = (value - low) / (high - low) * BINS as f64;
            bins[(place as usize).min(BINS - 1)] += 1;
        }
        let reach = FAR * (quartiles[2] - quartiles[0]);
        let outside = |value: f64| (quartiles[0] - value).max(value - quartiles[2]);
        let mut far: Vec<usize> = (0..values.len()).filter(|row| outside(values[*row]) > reach).collect();
        far.sort_by(|a, b| outside(values[*b]).total_cmp(&outside(values[*a])));
        // Half of the values are one where the middle half has no width: then all others would stand out.
        let far = if reach > 0.0 { far } else { vec![] };
        let (mean_errors, by_group) = mean_errors(values, groups.as_deref());
        Some(Self {
            name: String::new(),
            unit: None,
            samples: values.len(),
            range: [low, high],
            mean,
            sd: (squares / (n - 1.0).max(1.0)).sqrt(),
            quartiles,
            bins,
            outliers: far.len(),
            worst: far
                .iter()
                .take(WORST)
                .map(|row| format!("{} {}", origin(*row), short(values[*row])))
                .collect(),
            mean_errors,
            by_group,
        })
    }

    /// Draws the histogram as a line of bars.
    fn histogram(&self) -> String {
        let most = self.bins.iter().max().copied().unwrap_or(0).max(1);
        let last = BARS.len() - 1;
        // A bin that is not empty shows.
        let bar = |count: &usize| BARS[(count * last).div_ceil(most).min(last)];
        self.bins.iter().map(bar).collect()
    }

    /// Writes the figures as texts, a line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        let unit = self.unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
        let [first, median, third] = self.quartiles.map(short);
        let [mae, rmse] = self.mean_errors.map(short);
        let others = if self.by_group { "other groups" } else { "the others" };
        let outliers = (self.outliers > 0).then(|| {
            let (count, worst) = (self.outliers, self.worst.join(", "));
            format!("{count} beyond three times the middle half, farthest {worst}")
        });
        let lines = [
            format!(
                "{} |{}| mean {} ± {}{unit}, quartiles {first}, {median}, {third}",
                self.name,
                self.histogram(),
                short(self.mean),
                short(self.sd)
            ),
            format!("the mean of {others} scores MAE {mae}, RMSE {rmse}{unit}"),
        ];
        lines.into_iter().chain(outliers).collect()
    }
}

impl Display for QuantitySummary {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.lines().join("; "))
    }
}

/// Returns the value below which a share of the sorted values lies, linear between two.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + (above - below) * place.fract()
}

/// Measures the answer that is the mean of the others: of other groups where there are several, else of other samples.
fn mean_errors(values: &[f64], groups: Option<&[u32]>) -> ([f64; 2], bool) {
    let mut sums: BTreeMap<u32, (f64, usize)> = BTreeMap::new();
    for (group, value) in groups.into_iter().flatten().zip(values) {
        let (sum, count) = sums.entry(*group).or_default();
        (*sum, *count) = (*sum + value, *count + 1);
    }
    let (all, n) = (values.iter().sum::<f64>(), values.len());
    let by_group = sums.len() > 1;
    let error = |(row, value): (usize, &f64)| {
        let (sum, count) = match groups.filter(|_| by_group) {
            Some(groups) => sums[&groups[row]],
            None => (*value, 1),
        };
        value - (all - sum) / n.saturating_sub(count).max(1) as f64
    };
    let errors: Vec<f64> = values.iter().enumerate().map(error).collect();
    let mae = errors.iter().map(|error| error.abs()).sum::<f64>() / n as f64;
    let rmse = (errors.iter().map(|error| error * error).sum::<f64>() / n as f64).sqrt();
    ([mae, rmse], by_group)
}

/// Writes a number in four significant digits.
pub(crate) fn short(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if !(-4..7).contains(&digits) {
        return format!("{value:.3e}");
    }
    let text = format!("{value:.*}", (3 - digits).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_numpy() {
        let values = [1.0, 2.0, 4.0, 8.0, 100.0, 3.0, 2.5, 2.0];
        let summary = QuantitySummary::of(&values, None, |row| format!("x[{row}]"));
        let summary = summary.unwrap_or_else(|| panic!("values"));
        // numpy.percentile(values, [25, 50, 75]), numpy.mean, numpy.std(ddof=1)
        assert_eq!(summary.quartiles, [2.0, 2.75, 5.0]);
        assert!(
            (summary.mean - 15.3125).abs() < 1e-12 && (summary.sd - 34.2855).abs() < 1e-4,
            "{}",
            summary.sd
        );
        assert_eq!((summary.outliers, summary.worst), (1, vec!["x[4] 100".to_string()]));
        assert_eq!((summary.bins[0], summary.bins[9]), (7, 1));
    }

    #[test]
    fn the_mean_is_that_of_other_groups() {
        let values = [0.0, 2.0, 10.0, 12.0];
        assert_eq!(mean_errors(&values, Some(&[0, 0, 1, 1])), ([10.0, 101f64.sqrt()], true));
        let (errors, by_group) = mean_errors(&values, Some(&[0, 0, 0, 0]));
        assert!(!by_group && (errors[0] - 20.0 / 3.0).abs() < 1e-12, "{errors:?}");
    }
}
