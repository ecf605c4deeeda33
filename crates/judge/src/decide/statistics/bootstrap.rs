//! Intervals of any statistic over samples that come in clusters.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, Normal};
use taxel_learn::metrics::{bootstrap, central, mean_sd, t_quantile};

use super::check::{check_share, refuse};
use crate::error::Result;

/// Share of resamples that a statistic may leave undefined before its interval is refused.
const UNDEFINED: f64 = 0.05;

/// Returns an interval of `statistic` that covers `confidence`, from `draws` resamples of whole clusters (Cameron,
/// Gelbach & Miller 2008, section III). `clusters[i]` is the cluster of sample `i`; `statistic` gets positions of
/// samples, those of a cluster as often as it was drawn. Networks that are scored on the same positions stay paired.
/// `seed` and `purpose` choose the draws.
///
/// Percentiles alone are too narrow where clusters are few: resamples vary by (k − 1)/k of what they should, and their
/// quantiles are those of the normal distribution. So both are corrected, with k clusters of equal size (Kish 1965) and
/// Student's t of k − 1 degrees of freedom: the distance of each percentile from the value of all samples (after
/// Hesterberg 2015), and the standard deviation of the resamples. The wider of the two holds.
///
/// `None` with fewer than two clusters (one says nothing about others), where the statistic of all samples or of more
/// than one resample in twenty is undefined, and where resamples do not vary, unless the value is 0.
///
/// # Errors
/// A confidence outside (0, 1), no draws, or a statistic that is not finite.
pub fn cluster_bootstrap(
    clusters: &[u32],
    statistic: impl Fn(&[usize]) -> Option<f64>,
    confidence: f64,
    draws: usize,
    (seed, purpose): (u64, &str),
) -> Result<Option<[f64; 2]>> {
    check_share("confidence", confidence)?;
    if draws == 0 {
        return refuse("bootstrap", "no draws");
    }
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (position, cluster) in clusters.iter().enumerate() {
        members.entry(*cluster).or_default().push(position);
    }
    let members: Vec<Vec<usize>> = members.into_values().collect();
    if members.len() < 2 {
        return Ok(None);
    }
    let mut positions = vec![];
    let values = bootstrap(members.len(), draws, seed, purpose, |drawn| {
        positions.clear();
        drawn.iter().for_each(|&cluster| positions.extend_from_slice(&members[cluster]));
        statistic(&positions)
    });
    if let Some(value) = values.iter().find(|v| !v.is_finite()) {
        return refuse("bootstrap", format!("the statistic of a resample is {value}"));
    }
    if ((draws - values.len()) as f64) > UNDEFINED * draws as f64 {
        return Ok(None);
    }
    let everything: Vec<usize> = (0..clusters.len()).collect();
    let Some(whole) = statistic(&everything).filter(|value| value.is_finite()) else { return Ok(None) };
    let (_, sd) = mean_sd(&values);
    let sd = sd.unwrap_or(0.0);
    if sd <= 1e-12 * whole.abs().max(1.0) {
        return Ok((whole == 0.0).then_some([0.0, 0.0]));
    }
    let sizes = members.iter().map(|rows| (rows.len() as f64).powi(2)).sum::<f64>();
    let alike = (clusters.len() as f64).powi(2) / sizes;
    let quantile = (1.0 + confidence) / 2.0;
    let t = t_quantile((alike - 1.0).max(1.0), quantile) * (alike / (alike - 1.0)).sqrt();
    let wider = t / Normal::standard().inverse_cdf(quantile);
    let (low, high) = central(&values, confidence);
    let low = (whole - t * sd).min(whole - wider * (whole - low));
    Ok(Some([low, (whole + t * sd).max(whole + wider * (high - whole))]))
}
