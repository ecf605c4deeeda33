//! The bootstrap over clusters.

use std::collections::BTreeMap;

use rand::RngExt;

/// Sums and counts per cluster: grasps of one session or object are not independent, so whole clusters
/// are drawn (Cameron, Gelbach & Miller 2008, section III).
///
/// ```
/// use taxel_learn::metrics::Clusters;
///
/// // Four samples in two sessions, three of them right.
/// let clusters = Clusters::new(&[1.0, 1.0, 0.0, 1.0], &[7, 7, 9, 9]);
/// assert_eq!(clusters.mean(), 0.75);
/// // The second session alone, drawn twice.
/// assert_eq!(clusters.mean_of(&[1, 1]), 0.5);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Clusters {
    /// Sum and number of values, clusters in ascending order.
    sums: Vec<(f64, usize)>,
}

impl Clusters {
    /// Makes clusters of one value per sample (1 where a prediction is right) and the cluster it belongs to.
    pub fn new(values: &[f64], clusters: &[u32]) -> Self {
        let mut sums: BTreeMap<u32, (f64, usize)> = BTreeMap::new();
        for (value, cluster) in values.iter().zip(clusters) {
            let (sum, count) = sums.entry(*cluster).or_default();
            *sum += value;
            *count += 1;
        }
        Clusters { sums: sums.into_values().collect() }
    }

    /// Returns the number of clusters.
    pub fn len(&self) -> usize {
        self.sums.len()
    }

    /// Checks whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sums.is_empty()
    }

    /// Computes the mean over all samples; NaN without any.
    pub fn mean(&self) -> f64 {
        self.mean_of(&(0..self.len()).collect::<Vec<_>>())
    }

    /// Computes the mean over the samples of the clusters in `drawn`, each as often as it is there.
    pub fn mean_of(&self, drawn: &[usize]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (cluster_sum, n) in drawn.iter().filter_map(|&cluster| self.sums.get(cluster)) {
            sum += cluster_sum;
            count += n;
        }
        sum / count as f64
    }
}

/// Computes `statistic` on `draws` resamples of `clusters` clusters with replacement, in ascending order; what it
/// leaves undefined is left out. It is given the numbers of the drawn clusters, from 0. `seed` and `purpose` choose
/// the draws.
pub fn bootstrap(
    clusters: usize,
    draws: usize,
    seed: u64,
    purpose: &str,
    mut statistic: impl FnMut(&[usize]) -> Option<f64>,
) -> Vec<f64> {
    let mut rng = taxel_base::seed::rng(seed, &format!("bootstrap/{purpose}"));
    let mut drawn = vec![0; clusters];
    let mut values = vec![];
    for _ in 0..draws {
        drawn.iter_mut().for_each(|cluster| *cluster = rng.random_range(0..clusters));
        values.extend(statistic(&drawn));
    }
    values.sort_by(f64::total_cmp);
    values
}

/// Returns the bounds between which the middle `share` of the ascending `sorted` lies.
pub fn central(sorted: &[f64], share: f64) -> (f64, f64) {
    let tail = (1.0 - share) / 2.0;
    (quantile(sorted, tail), quantile(sorted, 1.0 - tail))
}

/// Returns the value below which the share `q` of the ascending `sorted` lies, interpolated linearly
/// (`numpy.quantile`); NaN of nothing.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = q.clamp(0.0, 1.0) * last as f64;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    low + (high - low) * at.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes the bootstrap out: draw after draw, whole clusters from one generator.
    #[test]
    fn whole_clusters_are_drawn_from_one_generator() {
        let (values, groups) = ([1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0], [5, 5, 2, 2, 2, 9, 11]);
        let members = [vec![2, 3, 4], vec![0, 1], vec![5], vec![6]];
        let mut rng = taxel_base::seed::rng(7, "bootstrap/small-1d");
        let mut means = vec![];
        for _ in 0..500 {
            let drawn: Vec<usize> = (0..4).flat_map(|_| members[rng.random_range(0..4)].clone()).collect();
            means.push(drawn.iter().map(|&at| values[at]).sum::<f64>() / drawn.len() as f64);
        }
        means.sort_by(f64::total_cmp);
        assert_eq!(
            means,
            bootstrap(4, 500, 7, "small-1d", |drawn| {
                let rows: Vec<usize> = drawn.iter().flat_map(|&cluster| members[cluster].clone()).collect();
                Some(rows.iter().map(|&at| values[at]).sum::<f64>() / rows.len() as f64)
            })
        );
        let clusters = Clusters::new(&values, &groups);
        let by_cluster = bootstrap(4, 500, 7, "small-1d", |drawn| Some(clusters.mean_of(drawn)));
        assert!(by_cluster.iter().zip(&means).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn what_is_undefined_is_left_out() {
        let first = |drawn: &[usize]| (drawn[0] == 0).then_some(1.0);
        let values = bootstrap(2, 100, 0, "half", first);
        assert!((30..70).contains(&values.len()) && values.iter().all(|v| *v == 1.0));
    }
}
