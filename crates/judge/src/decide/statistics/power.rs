//! How many samples would show a difference.

use taxel_learn::metrics::t_quantile;

/// Returns how many units, samples or groups, show a difference of `size` at the level `alpha`, two-sided, in the share `power` of
/// cases. `interval` is the 95 % interval that `units` of them gave: its width goes with the root of their number. None for a
/// difference of 0, and for an interval without width.
///
/// The size is itself an estimate, so this is the number for a difference as large as the one that was seen.
pub fn samples_to_decide(units: u64, size: f64, interval: [f64; 2], alpha: f64, power: f64) -> Option<u64> {
    let normal = |share: f64| t_quantile(f64::INFINITY, share);
    let error = (interval[1] - interval[0]) / (2.0 * normal(0.975));
    let needed = units as f64 * (error * (normal(1.0 - alpha / 2.0) + normal(power)) / size).powi(2);
    (needed.is_finite() && needed > 0.0).then(|| needed.ceil().min(1e15) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_is_that_of_the_normal_test() {
        // 100 pairs with SD 10: error 1, interval 1.96 to each side. For a mean of 2: (1.959964 + 0.841621)^2 * 100 / 4.
        let half = 1.959_963_985;
        let needed = samples_to_decide(100, 2.0, [2.0 - half, 2.0 + half], 0.05, 0.8);
        assert_eq!(needed, Some(197));
        assert_eq!(samples_to_decide(100, 0.0, [-1.0, 1.0], 0.05, 0.8), None);
        assert_eq!(samples_to_decide(100, 1.0, [1.0, 1.0], 0.05, 0.8), None);
    }
}
