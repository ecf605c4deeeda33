//! Networks over several data sets: ranks.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, FisherSnedecor, Normal};

use super::check::{check, check_share, refuse};
use crate::error::Result;
use crate::values::Friedman;

/// Tests whether methods differ over data sets (Friedman 1937; Demsar 2006, section 3.2.2). `scores[set][method]`:
/// higher is better. Where all methods tie on every set the statistic is 0 and p is 1; where all sets rank
/// them alike, Iman and Davenport's p is 0.
///
/// # Errors
/// Fewer than two data sets or three methods (two are [`wilcoxon`]'s), rows of unequal length, values
/// that are not finite.
pub fn friedman(scores: &[Vec<f64>]) -> Result<Friedman> {
    let what = "Friedman test";
    let (sets, methods) = (scores.len(), scores.first().map_or(0, Vec::len));
    if sets < 2 || methods < 3 {
        return refuse(what, format!("{sets} data sets and {methods} methods; at least 2 and 3 are needed"));
    }
    let (mut sums, mut ties) = (vec![0.0; methods], 0.0);
    for row in scores {
        check(what, row, 1)?;
        if row.len() != methods {
            return refuse(what, format!("{} scores on one data set, {methods} on another", row.len()));
        }
        let turned: Vec<f64> = row.iter().map(|v| -v).collect();
        let (ranks, tied) = ranks(&turned);
        sums.iter_mut().zip(ranks).for_each(|(sum, rank)| *sum += rank);
        ties += tied;
    }
    let (n, k) = (sets as f64, methods as f64);
    let ranks: Vec<f64> = sums.iter().map(|sum| sum / n).collect();
    let squares: f64 = sums.iter().map(|sum| sum * sum).sum();
    let correction = 1.0 - ties / (k * (k * k - 1.0) * n);
    if correction <= 1e-12 {
        return Ok(Friedman { ranks, statistic: 0.0, p: 1.0, p_iman_davenport: 1.0 });
    }
    let plain = 12.0 / (n * k * (k + 1.0)) * squares - 3.0 * n * (k + 1.0);
    let statistic = (plain / correction).max(0.0);
    #[expect(clippy::expect_used, reason = "there are three methods at least")]
    let chi_squared = ChiSquared::new(k - 1.0).expect("degrees of freedom above 0");
    let p = chi_squared.sf(statistic);
    let rest = n * (k - 1.0) - statistic;
    let p_iman_davenport = if rest <= 1e-9 * n * k {
        0.0
    } else {
        #[expect(clippy::expect_used, reason = "there are two sets and three methods at least")]
        let f = FisherSnedecor::new(k - 1.0, (k - 1.0) * (n - 1.0)).expect("degrees of freedom above 0");
        f.sf((n - 1.0) * statistic / rest)
    };
    Ok(Friedman { ranks, statistic, p, p_iman_davenport })
}

/// Ranks from 1 for the smallest, ties share their mean; and Σ (t³ − t) over groups of t ties.
pub fn ranks(values: &[f64]) -> (Vec<f64>, f64) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let (mut ranks, mut ties, mut first) = (vec![0.0; values.len()], 0.0, 0);
    while first < order.len() {
        let alike = order[first..].iter().take_while(|&&at| values[at] == values[order[first]]).count();
        // First + 1 to first + alike.
        let shared = first as f64 + (alike as f64 + 1.0) / 2.0;
        order[first..first + alike].iter().for_each(|&at| ranks[at] = shared);
        ties += (alike as f64).powi(3) - alike as f64;
        first += alike;
    }
    (ranks, ties)
}

/// Returns the critical difference of mean ranks (Nemenyi 1963; Demsar 2006, equation 6): two of `methods` ranked on
/// `sets` data sets differ where their mean ranks do by at least as much.
///
/// # Errors
/// Fewer than two methods, no data set, or an `alpha` outside (0, 1).
pub fn nemenyi(methods: usize, sets: usize, alpha: f64) -> Result<f64> {
    check_share("alpha", alpha)?;
    if methods < 2 || sets == 0 {
        let reason = format!("{methods} methods on {sets} data sets; at least 2 on 1 are needed");
        return refuse("critical difference", reason);
    }
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if studentized_range(middle, methods) < 1.0 - alpha { low = middle } else { high = middle }
    }
    let k = methods as f64;
    Ok(0.5 * (low + high) / 2f64.sqrt() * (k * (k + 1.0) / (6.0 * sets as f64)).sqrt())
}

/// Returns the probability that the range of `count` standard normal values is at most `range`: count ∫ φ(z) (Φ(z) −
/// Φ(z − range))^(count − 1) dz by the trapezoidal rule, which is exact to rounding for such integrands.
fn studentized_range(range: f64, count: usize) -> f64 {
    const STEP: f64 = 1.0 / 32.0;
    let normal = Normal::standard();
    let sum: f64 = (-288..=288)
        .map(|i| {
            let z = f64::from(i) * STEP;
            normal.pdf(z) * (normal.cdf(z) - normal.cdf(z - range)).powi(count as i32 - 1)
        })
        .sum();
    count as f64 * sum * STEP
}

/// Differences that the exact test of [`wilcoxon`] takes.
const MOST: usize = 500;

/// Returns the p-value of the exact signed-rank test (Wilcoxon 1945), two-sided: every pattern of signs is equally likely. Zeros are
/// left out, ties share their mean rank; 1 where nothing is left.
///
/// # Errors
/// No or more than 500 differences, or values that are not finite.
pub fn wilcoxon(differences: &[f64]) -> Result<f64> {
    let what = "signed-rank test";
    check(what, differences, 1)?;
    if differences.len() > MOST {
        return refuse(what, format!("{} differences; at most {MOST}", differences.len()));
    }
    let kept: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
    let sizes: Vec<f64> = kept.iter().map(|d| d.abs()).collect();
    // Twice the ranks are whole numbers.
    let twice: Vec<usize> = ranks(&sizes).0.iter().map(|rank| (2.0 * rank).round() as usize).collect();
    let positive: usize = twice.iter().zip(&kept).filter(|(_, d)| **d > 0.0).map(|(rank, _)| rank).sum();
    let mut share = vec![0.0; twice.iter().sum::<usize>() + 1];
    share[0] = 1.0;
    for rank in twice {
        for sum in (0..share.len()).rev() {
            let with = if sum >= rank { share[sum - rank] } else { 0.0 };
            share[sum] = 0.5 * (share[sum] + with);
        }
    }
    let (below, above): (f64, f64) = (share[..=positive].iter().sum(), share[positive..].iter().sum());
    Ok((2.0 * below.min(above)).min(1.0))
}

/// Returns the two-sided p of the signed-rank test: [`wilcoxon`] up to 500 differences, beyond by the normal
/// approximation with its correction for ties, which is then as good.
///
/// # Errors
/// No differences, or values that are not finite.
pub(crate) fn signed_rank(differences: &[f64]) -> Result<f64> {
    if differences.len() <= MOST {
        return wilcoxon(differences);
    }
    check("signed-rank test", differences, 1)?;
    let kept: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
    let (ranks, ties) = ranks(&kept.iter().map(|d| d.abs()).collect::<Vec<_>>());
    let n = kept.len() as f64;
    let positive: f64 = ranks.iter().zip(&kept).filter(|(_, d)| **d > 0.0).map(|(rank, _)| rank).sum();
    let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - ties / 48.0;
    if variance <= 0.0 {
        return Ok(1.0);
    }
    let z = (positive - n * (n + 1.0) / 4.0) / variance.sqrt();
    Ok((2.0 * Normal::standard().sf(z.abs())).min(1.0))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Compares with `scipy.stats.wilcoxon(d, zero_method="wilcox", correction=False, mode="approx")`.
    #[test]
    fn many_differences_are_scipys_normal_approximation() {
        for (count, period, offset, want) in [
            (600, 101, 48.0, 0.10813652183450376),
            (600, 7, 3.2, 0.0020705509694158167),
            (501, 97, 44.0, 0.002227500876570399),
            (700, 5, 2.0, 1.0),
        ] {
            let differences: Vec<f64> = (0..count).map(|i| f64::from(i * 37 % period) - offset).collect();
            let turned: Vec<f64> = differences.iter().map(|d| -d).collect();
            for each in [&differences, &turned] {
                let p = signed_rank(each).unwrap();
                assert!((p - want).abs() <= 1e-9, "{count} of {period}: got {p}, want {want}");
            }
        }
        // Up to 500 differences the test is exact; without one that is not 0 there is nothing to test.
        let few = [1.0, -2.0, 3.0];
        assert_eq!(signed_rank(&few).unwrap(), wilcoxon(&few).unwrap());
        assert_eq!(signed_rank(&[0.0; 501]).unwrap(), 1.0);
        assert!(signed_rank(&[]).is_err() && signed_rank(&[f64::NAN; 501]).is_err());
    }
}
