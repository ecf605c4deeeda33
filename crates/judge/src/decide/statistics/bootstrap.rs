//! Intervals of any statistic over samples that come in clusters.

use std::collections::BTreeMap;

use taxel_learn::metrics::{bootstrap, central};

use super::check::{check_share, refuse};
use crate::error::Result;

/// Share of resamples that a statistic may leave undefined before its interval is refused.
const UNDEFINED: f64 = 0.05;

/// Returns the percentile interval of `statistic` that covers `confidence`, from `draws` resamples of whole
/// clusters (Cameron, Gelbach & Miller 2008, section III). `clusters[i]` is the cluster of sample `i`;
/// `statistic` gets positions of samples, those of a cluster as often as it was drawn. Networks that are
/// scored on the same positions stay paired. `seed` and `purpose` choose the draws, as in
/// [`taxel_learn::metrics::Clusters::interval`].
///
/// `None` with fewer than two clusters (one says nothing about others), or where more than one resample in
/// twenty leaves the statistic undefined.
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
    let (low, high) = central(&values, confidence);
    Ok(Some([low, high]))
}
