//! Effects of several runs together, and p-values of a whole page.

use statrs::distribution::{ContinuousCDF, Normal};

use super::check::{check, check_share, refuse};
use super::pairs::student;
use crate::error::Result;

/// An effect over several runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PooledEffect {
    /// In the unit of the effects.
    pub mean: f64,
    /// Interval of the mean over such runs.
    pub interval: [f64; 2],
    /// Two-sided.
    pub p: f64,
    /// Variance of the true effects between runs.
    pub between: f64,
}

/// Pools effects by random effects: weights from the variance between runs (Paule and Mandel 1982), the interval by
/// Hartung and Knapp (2001) with Student's t of runs less one degrees of freedom. The variance of the mean is never below
/// that of the weights (Röver et al. 2015): two runs that happen to agree prove nothing. Each effect comes with its
/// standard error.
///
/// # Errors
/// Fewer than two effects, values that are not finite, a standard error that is not above 0, a confidence outside (0, 1).
pub fn random_effects(effects: &[(f64, f64)], confidence: f64) -> Result<PooledEffect> {
    let what = "pooled effect";
    let sizes: Vec<f64> = effects.iter().map(|effect| effect.0).collect();
    check(what, &sizes, 2)?;
    check_share("confidence", confidence)?;
    if let Some((_, error)) = effects.iter().find(|(_, error)| !(error.is_finite() && *error > 0.0)) {
        return refuse(what, format!("a standard error of {error}"));
    }
    let between = paule_mandel(effects);
    let weights: Vec<f64> = weights(effects, between);
    let (mean, total) = (weighted_mean(&sizes, &weights), weights.iter().sum::<f64>());
    let freedom = effects.len() as f64 - 1.0;
    let error = ((heterogeneity(effects, between) / freedom).max(1.0) / total).sqrt();
    let (interval, p) = student(mean, error, freedom, confidence);
    Ok(PooledEffect { mean, interval, p, between })
}

fn weights(effects: &[(f64, f64)], between: f64) -> Vec<f64> {
    effects.iter().map(|(_, error)| 1.0 / (error * error + between)).collect()
}

fn weighted_mean(sizes: &[f64], weights: &[f64]) -> f64 {
    sizes.iter().zip(weights).map(|(size, weight)| size * weight).sum::<f64>() / weights.iter().sum::<f64>()
}

/// Returns Cochran's Q with weights for this variance between runs.
fn heterogeneity(effects: &[(f64, f64)], between: f64) -> f64 {
    let weights = weights(effects, between);
    let sizes: Vec<f64> = effects.iter().map(|effect| effect.0).collect();
    let mean = weighted_mean(&sizes, &weights);
    sizes.iter().zip(&weights).map(|(size, weight)| weight * (size - mean).powi(2)).sum()
}

/// Finds the variance between runs for which Cochran's Q is its expected value, by bisection; 0 where there is none.
fn paule_mandel(effects: &[(f64, f64)]) -> f64 {
    let expected = effects.len() as f64 - 1.0;
    if heterogeneity(effects, 0.0) <= expected {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1e-12);
    while heterogeneity(effects, high) > expected {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if heterogeneity(effects, middle) > expected { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Returns q-values in the order given (Benjamini and Hochberg 1995): the share of false ones to expect among all
/// claims whose q is no larger.
///
/// ```
/// use taxel_judge::statistics::false_discovery;
///
/// assert_eq!(false_discovery(&[0.01, 0.5]), [0.02, 0.5]);
/// ```
pub fn false_discovery(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[b].total_cmp(&p[a]));
    let (mut q, mut least) = (vec![0.0; p.len()], 1.0f64);
    for (step, at) in order.into_iter().enumerate() {
        least = least.min(p.len() as f64 / (p.len() - step) as f64 * p[at]);
        q[at] = least;
    }
    q
}

/// A look at a run that is still going on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Repetitions to look at.
    pub repetitions: usize,
    /// Confidence of the intervals at this look.
    pub confidence: f64,
}

/// Plans looks at a quarter, half and all of the repetitions, so that all of them together are wrong in at most 5 % of
/// cases. A look spends what O'Brien and Fleming's boundary has spent by then (Lan and DeMets 1983) less what earlier
/// looks did; shares add up by the union bound, so that Student's t is exact at each. Fewer than eight repetitions are
/// looked at once.
pub fn looks(repetitions: usize) -> Vec<Look> {
    if repetitions < 8 {
        return vec![Look { repetitions, confidence: 0.95 }];
    }
    let normal = Normal::standard();
    let spent = |share: f64| 2.0 * normal.sf(normal.inverse_cdf(0.975) / share.sqrt());
    let mut before = 0.0;
    let look = |part: usize| {
        let count = repetitions / part;
        let by_now = spent(count as f64 / repetitions as f64);
        let confidence = 1.0 - (by_now - before);
        before = by_now;
        Look { repetitions: count, confidence }
    };
    [4, 2, 1].map(look).into()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::corrected_t;
    use super::*;
    use rand::RngExt;
    use taxel_base::seed;

    #[test]
    fn looks_spend_five_percent_in_all() {
        let spent = |n| looks(n).iter().map(|look| 1.0 - look.confidence).sum::<f64>();
        for planned in [2, 7, 8, 10, 20, 40, 1000] {
            assert!((spent(planned) - 0.05).abs() < 1e-9, "{planned}");
        }
        let counts: Vec<usize> = looks(20).iter().map(|look| look.repetitions).collect();
        assert_eq!((counts, looks(5)[0].repetitions), (vec![5, 10, 20], 5));
        let last = looks(20)[2].confidence;
        assert!((0.955..0.957).contains(&last), "{last}");
    }

    /// Counts in how many of 4000 runs some look finds a difference, where the true one is `effect` standard deviations.
    fn decided(effect: f64, planned: usize) -> f64 {
        let mut random = seed::rng(1, &format!("looks {effect}"));
        let normal = Normal::standard();
        let mut draw = || effect + normal.inverse_cdf(random.random_range(1e-12..1.0));
        let run = |_: &usize| {
            let worlds: Vec<f64> = (0..planned).map(|_| draw()).collect();
            looks(planned).iter().any(|look| {
                let test = corrected_t(&worlds[..look.repetitions], 0.0, look.confidence).unwrap();
                test.interval.is_some_and(|[low, high]| low > 0.0 || high < 0.0)
            })
        };
        (0..4000).filter(run).count() as f64 / 4000.0
    }

    #[test]
    fn looking_three_times_is_wrong_in_one_case_of_twenty() {
        // Standard error of a share of 4000: 0.35 points.
        let wrong = decided(0.0, 20);
        assert!((0.035..0.06).contains(&wrong), "{wrong}");
        // Power of a plain t-test of 20 on 0.66 standard deviations is 0.80 (statsmodels TTestPower).
        let power = decided(0.66, 20);
        assert!((0.74..0.81).contains(&power), "{power}");
    }
}
