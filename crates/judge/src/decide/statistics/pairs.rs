//! Two networks on the same test parts.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, StudentsT};
use taxel_learn::metrics::{MeanEstimate, Terms, mean_sd, t_quantile};

use super::check::{check, check_share, refuse};
use crate::error::Result;

/// A paired difference and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PairedTest {
    /// Mean difference.
    pub mean: f64,
    /// Interval of the mean; none where differences do not vary, unless they are all 0.
    pub interval: Option<[f64; 2]>,
    /// Two-sided.
    pub p: f64,
}

/// Checks whether values vary by more than rounding.
fn does_not_vary(mean: f64, sd: f64) -> bool {
    sd <= 1e-12 * mean.abs().max(1.0)
}

/// Returns the corrected resampled t-test (Nadeau & Bengio 2003, equation 9): training sets of folds and repetitions
/// overlap, so the variance of the mean of n differences is taken as (1/n + `test_to_train`) s² and not as
/// s²/n; n − 1 degrees of freedom. `test_to_train` is the number of test samples over that of training
/// samples in a fold; 0 is the ordinary paired t-test.
///
/// Differences that are all 0 have p = 1 and the interval \[0, 0\]. Differences that are all the same but
/// not 0 have no t statistic: p is the exact sign test's, 2^(1 − n), and there is no interval.
///
/// # Errors
/// Fewer than two differences, values that are not finite, a negative ratio, a confidence outside (0, 1).
pub fn corrected_t(differences: &[f64], test_to_train: f64, confidence: f64) -> Result<PairedTest> {
    let what = "corrected t-test";
    check(what, differences, 2)?;
    check_share("confidence", confidence)?;
    if !(test_to_train.is_finite() && test_to_train >= 0.0) {
        return refuse(what, format!("{test_to_train} test samples for each training sample"));
    }
    let n = differences.len() as f64;
    let (mean, sd) = mean_sd(differences);
    let sd = sd.unwrap_or(0.0);
    if does_not_vary(mean, sd) {
        let none = differences.iter().all(|d| *d == 0.0);
        let p = if none { 1.0 } else { 2f64.powf(1.0 - n) };
        return Ok(PairedTest { mean, interval: none.then_some([0.0, 0.0]), p });
    }
    let error = sd * (1.0 / n + test_to_train).sqrt();
    let (interval, p) = student(mean, error, n - 1.0, confidence);
    Ok(PairedTest { mean, interval: Some(interval), p })
}

/// Returns a difference of two independent estimates from the interval of each (Zou & Donner 2008; for shares
/// Newcombe 1998, method 10): `a` less `b`, both with their lower and upper bound. Intervals need not be
/// even around their estimates.
///
/// # Errors
/// Values that are not finite, or an estimate outside its interval.
pub fn independent(a: (f64, [f64; 2]), b: (f64, [f64; 2])) -> Result<(f64, [f64; 2])> {
    let what = "difference of independent estimates";
    for (size, [low, high]) in [a, b] {
        check(what, &[size, low, high], 3)?;
        if !(low <= size && size <= high) {
            return refuse(what, format!("{size} is outside its interval {low} to {high}"));
        }
    }
    let ((a, [low_a, high_a]), (b, [low_b, high_b])) = (a, b);
    let (down, up) = ((a - low_a).hypot(high_b - b), (high_a - a).hypot(b - low_b));
    Ok((a - b, [a - b - down, a - b + up]))
}

/// Returns the t interval of a mean with this standard error, and the two-sided p of no mean at all.
pub(super) fn student(mean: f64, error: f64, freedom: f64, confidence: f64) -> ([f64; 2], f64) {
    let p = (2.0 * students_t(freedom).sf((mean / error).abs())).min(1.0);
    let half = t_quantile(freedom, (1.0 + confidence) / 2.0) * error;
    ([mean - half, mean + half], p)
}

#[expect(clippy::expect_used, reason = "callers have more values than they estimate")]
fn students_t(freedom: f64) -> StudentsT {
    StudentsT::new(0.0, 1.0, freedom).expect("degrees of freedom above 0")
}

/// Returns the p-value of the exact McNemar test (1947): of the samples that only one of two networks gets right, `only_a` by one and
/// `only_b` by the other, either is as likely to be which under the null hypothesis. Two-sided; 1 where
/// the two are never unlike.
pub fn mcnemar(only_a: u64, only_b: u64) -> f64 {
    #[expect(clippy::expect_used, reason = "one half is a probability")]
    let fair = Binomial::new(0.5, only_a + only_b).expect("a fair coin");
    (2.0 * fair.cdf(only_a.min(only_b))).min(1.0)
}

/// Returns the mean of paired differences of samples that come in groups, and how sure it is: a t-test on the variance
/// of the group sums, as [`MeanEstimate`] has it. It is McNemar's question of grouped samples (Durkalski et al. 2003),
/// whose exact test takes samples of one group for independent. `samples` and `groups` name the sample and the group of
/// each difference, which lies in -1..=1. None for a single group.
///
/// # Errors
/// No differences, values that are not finite, a confidence outside (0, 1).
pub fn grouped_pairs(
    differences: &[f64],
    samples: &[u32],
    groups: &[u32],
    confidence: f64,
) -> Result<Option<PairedTest>> {
    check("test of grouped pairs", differences, 1)?;
    check_share("confidence", confidence)?;
    let Some(found) = MeanEstimate::of(differences, samples, Some(groups), Terms::Differences) else {
        return Ok(None);
    };
    let t = (found.mean / found.variance.sqrt()).abs();
    let p = (2.0 * students_t(found.freedom).sf(t)).min(1.0);
    Ok(Some(PairedTest { mean: found.mean, interval: found.interval(confidence), p }))
}

/// Applies Holm's step-down correction (1979): p-values as they would be for one test alone, in the order given;
/// none is below that of a smaller p, none above 1.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let (mut adjusted, mut most) = (vec![0.0; p.len()], 0.0f64);
    for (step, at) in order.into_iter().enumerate() {
        most = most.max(((p.len() - step) as f64 * p[at]).min(1.0));
        adjusted[at] = most;
    }
    adjusted
}

/// How much more one network varies than another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpreadRatio {
    /// Standard deviation of the first over that of the second.
    pub ratio: f64,
    /// Interval of the ratio.
    pub interval: [f64; 2],
}

/// Returns the ratio of two standard deviations over the same folds (Pitman 1939; Morgan 1939): the interval holds the
/// ratios r for which a + r b and a − r b are not significantly correlated. Folds share training samples,
/// so the interval is rather too narrow than too wide.
///
/// `None` where either does not vary, or both vary exactly alike.
///
/// # Errors
/// Fewer than three or unequally many values, values that are not finite, a confidence outside (0, 1).
pub fn spread_ratio(a: &[f64], b: &[f64], confidence: f64) -> Result<Option<SpreadRatio>> {
    let what = "ratio of spreads";
    check(what, a, 3)?;
    check(what, b, 3)?;
    check_share("confidence", confidence)?;
    if a.len() != b.len() {
        return refuse(what, format!("{} values and {}; one each is needed", a.len(), b.len()));
    }
    let ((mean_a, sd_a), (mean_b, sd_b)) = (mean_sd(a), mean_sd(b));
    let (sd_a, sd_b) = (sd_a.unwrap_or(0.0), sd_b.unwrap_or(0.0));
    if does_not_vary(mean_a, sd_a) || does_not_vary(mean_b, sd_b) {
        return Ok(None);
    }
    let n = a.len() as f64;
    let products: f64 = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum();
    let correlation = products / ((n - 1.0) * sd_a * sd_b);
    let unlike = 1.0 - correlation.powi(2);
    if unlike <= 1e-12 {
        return Ok(None);
    }
    let t = t_quantile(n - 2.0, (1.0 + confidence) / 2.0);
    let k = 1.0 + 2.0 * unlike * t.powi(2) / (n - 2.0);
    let (ratio, root) = (sd_a / sd_b, (k * k - 1.0).sqrt());
    Ok(Some(SpreadRatio { ratio, interval: [ratio * (k - root).sqrt(), ratio * (k + root).sqrt()] }))
}
