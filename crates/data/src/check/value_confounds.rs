//! Measures how far the group of a sample, or its place in the file, alone tells its value.

use crate::check::quantities::short;
use crate::dataset::dataset::Dataset;
use std::collections::BTreeMap;

/// With fewer samples luck looks like knowledge.
const LEAST: usize = 40;
/// Share of the variance that a group tells and that is worth a warning.
const BY_GROUP: f64 = 0.5;
/// Share of the variance that neighbours tell and that is worth a warning.
const BY_PLACE: f64 = 0.9;

/// Warns of groups and places that tell a value, each with the figure.
pub(crate) fn confounds(data: &Dataset) -> Vec<String> {
    let Some(values) = data.targets.values() else { return vec![] };
    let width = values.quantities().len();
    let mut warnings = vec![];
    for (at, quantity) in values.quantities().iter().enumerate() {
        let y: Vec<f64> =
            values.values().iter().skip(at).step_by(width).map(|value| f64::from(*value)).collect();
        if y.len() < LEAST || y.iter().any(|value| !value.is_finite()) {
            continue;
        }
        let name = &quantity.name;
        let group = data.group_name.as_deref().unwrap_or("group");
        if let Some(share) = data.groups.as_ref().and_then(|groups| by_group(&y, groups))
            && share >= BY_GROUP
        {
            warnings.push(format!(
                "the {group} alone tells {name}: its mean reaches R² {}; split by {group} and compare with the mean of \
                 other groups",
                short(share)
            ));
        }
        if let Some((share, lag)) = by_place(&y, data.units.as_deref())
            && share >= BY_PLACE
        {
            warnings.push(format!(
                "neighbours in the file alone tell {name}: their mean reaches R² {} (lag-1 correlation {}), so a random split \
                 trains on near copies of what it tests; split by group or in time",
                short(share),
                short(lag)
            ));
        }
    }
    warnings
}

/// Returns the share of the variance that the mean of the others of its group tells; none where groups are single samples or
/// one. Samples without another in their group count with the mean of all.
fn by_group(y: &[f64], groups: &[u32]) -> Option<f64> {
    let mut sums: BTreeMap<u32, (f64, usize)> = BTreeMap::new();
    for (group, value) in groups.iter().zip(y) {
        let (sum, count) = sums.entry(*group).or_default();
        (*sum, *count) = (*sum + value, *count + 1);
    }
    if sums.len() < 2 || sums.len() * 2 > y.len() {
        return None;
    }
    let mean = mean(y);
    let told = y.iter().zip(groups).map(|(value, group)| match sums[group] {
        (_, 1) => mean,
        (sum, count) => (sum - value) / (count - 1) as f64,
    });
    explained(y, &told.collect::<Vec<_>>())
}

/// Returns the share of the variance that the mean of the samples before and after tells, and the correlation with the one
/// before. Of windows and copies, which a random split keeps together, only neighbours of other recordings count.
fn by_place(y: &[f64], units: Option<&[u32]>) -> Option<(f64, f64)> {
    let is_other = |a: usize, b: usize| units.is_none_or(|units| units[a] != units[b]);
    let (mut seen, mut told, mut pairs) = (vec![], vec![], vec![]);
    for at in 0..y.len() {
        let before = at.checked_sub(1).filter(|other| is_other(at, *other));
        let after = Some(at + 1).filter(|other| *other < y.len() && is_other(at, *other));
        let near: Vec<f64> = before.into_iter().chain(after).map(|other| y[other]).collect();
        if !near.is_empty() {
            seen.push(y[at]);
            told.push(mean(&near));
        }
        pairs.extend(before.map(|other| (y[other], y[at])));
    }
    // Of few recordings only the ends have neighbours.
    if seen.len() * 2 < y.len() {
        return None;
    }
    Some((explained(&seen, &told)?, correlation(&pairs)?))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Returns 1 less the squared errors as a share of those of the mean; none where nothing varies.
fn explained(y: &[f64], told: &[f64]) -> Option<f64> {
    let mean = mean(y);
    let all: f64 = y.iter().map(|value| (value - mean).powi(2)).sum();
    let left: f64 = y.iter().zip(told).map(|(value, told)| (value - told).powi(2)).sum();
    (all > 0.0).then(|| 1.0 - left / all)
}

fn correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    let (a, b): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
    let (of_a, of_b) = (mean(&a), mean(&b));
    let both: f64 = pairs.iter().map(|(a, b)| (a - of_a) * (b - of_b)).sum();
    let square = |values: &[f64], mean: f64| values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    let all = (square(&a, of_a) * square(&b, of_b)).sqrt();
    (all > 0.0).then(|| both / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_that_tells_the_value_is_found() {
        let groups: Vec<u32> = (0..60).map(|i| i / 20).collect();
        let by_session: Vec<f64> = (0..60).map(|i| f64::from(i / 20) * 10.0 + f64::from(i % 3)).collect();
        let free: Vec<f64> = (0..60).map(|i| f64::from(i * 37 % 61)).collect();
        assert!(by_group(&by_session, &groups).is_some_and(|share| share > 0.98));
        assert!(by_group(&free, &groups).is_some_and(|share| share < 0.1));
        assert_eq!(by_group(&free, &[0; 60]), None);
    }

    #[test]
    fn neighbours_of_one_recording_do_not_count() {
        let slow: Vec<f64> = (0..60).map(|i| (f64::from(i) / 10.0).sin()).collect();
        let (share, lag) = by_place(&slow, None).unwrap_or_default();
        assert!(share > 0.99 && lag > 0.98, "{share} {lag}");
        let one: Vec<u32> = (0..60).map(|i| i / 30).collect();
        assert_eq!(by_place(&slow, Some(&one)), None);
    }

    #[test]
    fn few_values_and_values_that_are_not_finite_say_nothing() {
        let data = |values: Vec<f32>| {
            let rows = values.len();
            let x = ndarray::ArrayD::from_shape_fn(vec![rows, 1, 2], |at| at[0] as f32);
            let data = Dataset::new("presses", taxel_base::Layout::Series, x, &vec!["a"; rows]).unwrap();
            data.with_values(crate::Quantity::named(&["force"]), values).unwrap()
        };
        let slow = |rows: usize| (0..rows).map(|row| row as f32).collect::<Vec<_>>();
        assert!(!confounds(&data(slow(60))).is_empty());
        assert!(confounds(&data(slow(LEAST - 1))).is_empty());
    }
}
