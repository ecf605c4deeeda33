//! Intervals of means over samples, which may come in groups: sessions, objects, subjects.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Groups below which an interval rests on an assumption more than on the data.
pub const FEW_GROUPS: usize = 5;

/// Degrees of freedom that the assumed correlation within groups weighs as much as.
const PRIOR: f64 = 3.0;

/// Mistakes at which the correlation that is measured weighs half of what its degrees of freedom say: a handful of
/// mistakes cannot show whether they come together.
const MISTAKES: f64 = 5.0;

/// The kind of numbers that are averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terms {
    /// Shares from 0 to 1, such as 1 for a right prediction.
    Shares,
    /// Amounts of 0 and more, such as absolute errors.
    Amounts,
    /// Differences of two shares of the same sample, from -1 to 1.
    Differences,
}

impl Terms {
    /// Returns the correlation of samples of one group that is assumed before any is seen.
    fn correlation(self) -> f64 {
        match self {
            Terms::Shares | Terms::Differences => 0.1,
            Terms::Amounts => 0.2,
        }
    }
}

/// A mean over samples, and how well they determine it.
///
/// Tests of one sample, and of exact copies of it, are averaged first and count as one sample. Without groups samples
/// are independent. With groups the variance is that of the group sums about the mean (a ratio estimate, Cochran 1977,
/// section 11.11), with as many groups as would be left of equal size (Kish 1965: the square of the sizes' sum over the
/// sum of their squares). Few groups say little about it. So it is averaged with the variance that a correlation within
/// groups of 0.1 would give (0.2 for amounts), weighed as 3 degrees of freedom and counted as such (the moderation of
/// Smyth 2004).
///
/// ```
/// use taxel_learn::metrics::{MeanEstimate, Terms};
///
/// // 30 of 30 right: not 100 % for certain.
/// let samples: Vec<u32> = (0..30).collect();
/// let [low, high] = MeanEstimate::of(&[1.0; 30], &samples, None, Terms::Shares).unwrap().interval(0.95).unwrap();
/// assert!((low - 0.8865).abs() < 1e-4 && high == 1.0);
/// // The same in three sessions: another session may well be worse.
/// let sessions: Vec<u32> = (0..30).map(|sample| sample / 10).collect();
/// let grouped = MeanEstimate::of(&[1.0; 30], &samples, Some(&sessions), Terms::Shares).unwrap();
/// assert!(grouped.interval(0.95).unwrap()[0] < 0.75 && grouped.groups == Some(3));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanEstimate {
    /// The mean over all tests.
    pub mean: f64,
    /// Its variance.
    pub variance: f64,
    /// Degrees of freedom of the variance; infinite where it follows from the mean.
    pub freedom: f64,
    /// Independent samples that would determine a share as well.
    pub samples: f64,
    /// Number of groups; none where samples are not grouped.
    pub groups: Option<usize>,
    /// The kind of numbers.
    pub terms: Terms,
}

/// One sample: the sum over its tests, and their number.
#[derive(Clone, Copy, Default)]
struct Tested {
    sum: f64,
    count: f64,
}

impl MeanEstimate {
    /// Estimates the mean of `terms`; `samples` and `groups` name the sample and the group of each. None of no terms,
    /// of a single sample of amounts or differences, of a single group, and of unequal lengths.
    pub fn of(terms: &[f64], samples: &[u32], groups: Option<&[u32]>, kind: Terms) -> Option<Self> {
        let fits = samples.len() == terms.len() && groups.is_none_or(|groups| groups.len() == terms.len());
        if terms.is_empty() || !fits {
            return None;
        }
        let mut tested: BTreeMap<(u32, u32), Tested> = BTreeMap::new();
        for (at, (term, sample)) in terms.iter().zip(samples).enumerate() {
            let group = groups.map_or(0, |groups| groups[at]);
            let one = tested.entry((group, *sample)).or_default();
            one.sum += term;
            one.count += 1.0;
        }
        let each: Vec<Tested> = tested.values().copied().collect();
        let (tests, sum) = each.iter().fold((0.0, 0.0), |(n, sum), one| (n + one.count, sum + one.sum));
        let mean = sum / tests;
        // Of samples that are tested equally often it is their number.
        let count = tests.powi(2) / each.iter().map(|one| one.count.powi(2)).sum::<f64>();
        let off = |one: &Tested| one.count * (one.sum / one.count - mean).powi(2);
        let spread = each.iter().map(off).sum::<f64>() / tests;
        let plain = Samples { mean, tests, count, spread, squares: squares(&each) };
        match groups {
            None => plain.ungrouped(kind),
            Some(_) => plain.grouped(kind, &tested),
        }
    }

    /// Returns the interval that covers the mean with probability `confidence`, in (0, 1). Shares have that of Wilson
    /// (1927) on as many samples as are independent (Korn & Graubard 1998), with the quantile of Student's t. Amounts
    /// have a t interval of their logarithm, which stays above 0, differences a t interval. None where nothing varies.
    pub fn interval(&self, confidence: f64) -> Option<[f64; 2]> {
        let t = t_quantile(self.freedom, (1.0 + confidence) / 2.0);
        match self.terms {
            Terms::Shares => Some(wilson(self.mean, self.samples, t)),
            Terms::Amounts => {
                let by = t * self.variance.sqrt() / self.mean;
                (self.variance > 0.0).then(|| [self.mean * (-by).exp(), self.mean * by.exp()])
            }
            Terms::Differences => {
                let half = t * self.variance.sqrt();
                Some([(self.mean - half).max(-1.0), (self.mean + half).min(1.0)])
            }
        }
    }

    /// Checks whether there are fewer than [`FEW_GROUPS`] groups.
    pub fn has_few_groups(&self) -> bool {
        self.groups.is_some_and(|groups| groups < FEW_GROUPS)
    }
}

/// Means of samples, whatever group they are of.
struct Samples {
    mean: f64,
    tests: f64,
    /// Samples, as many as would be left if all were tested equally often.
    count: f64,
    /// Variance of the samples about the mean.
    spread: f64,
    /// Sum of the squares of the samples' means.
    squares: f64,
}

fn squares(each: &[Tested]) -> f64 {
    each.iter().map(|one| (one.sum / one.count).powi(2)).sum()
}

impl Samples {
    /// Returns the variance of a right or wrong prediction.
    fn of_share(&self) -> f64 {
        (self.mean * (1.0 - self.mean)).max(0.0)
    }

    /// Returns the variance of the mean of independent samples.
    fn variance(&self, kind: Terms) -> f64 {
        let plain = self.spread / self.count;
        match kind {
            Terms::Shares if plain == 0.0 => self.of_share() / self.tests,
            // Half a pair more of each kind (Agresti & Min 2005): no difference in 30 samples is not none at all.
            Terms::Differences => {
                let sum = self.mean * self.count;
                let more = self.squares + 1.0 - sum.powi(2) / (self.count + 2.0);
                plain.max(more / (self.count + 2.0).powi(2))
            }
            _ => plain,
        }
    }

    fn ungrouped(&self, kind: Terms) -> Option<MeanEstimate> {
        let Samples { mean, count, .. } = *self;
        let of = |variance, freedom, samples| MeanEstimate {
            mean,
            variance,
            freedom,
            samples,
            groups: None,
            terms: kind,
        };
        let variance = self.variance(kind);
        if kind == Terms::Shares {
            // Right or wrong: the mean says how much that varies.
            if (self.spread - self.of_share()).abs() <= 1e-12 {
                return Some(of(variance, f64::INFINITY, count));
            }
            return Some(of(variance, (count - 1.0).max(1.0), self.of_share() / variance));
        }
        // Of one sample nothing is known about others.
        let more = count / (count - 1.0);
        (count > 1.0 + 1e-9).then(|| of(variance * more, count - 1.0, count))
    }

    fn grouped(&self, kind: Terms, tested: &BTreeMap<(u32, u32), Tested>) -> Option<MeanEstimate> {
        let Samples { mean, tests, count, .. } = *self;
        // Sum, number of tests and number of samples of each group.
        let mut groups: BTreeMap<u32, (f64, f64, f64)> = BTreeMap::new();
        for ((group, _), one) in tested {
            let (sum, number, samples) = groups.entry(*group).or_default();
            *sum += one.sum;
            *number += one.count;
            *samples += 1.0;
        }
        if groups.len() < 2 {
            return None;
        }
        let over = |value: fn(&(f64, f64, f64)) -> f64| groups.values().map(value).sum::<f64>();
        let alike = tests.powi(2) / over(|(_, number, _)| number.powi(2));
        let off: f64 = groups.values().map(|(sum, number, _)| (sum - mean * number).powi(2)).sum();
        let between = alike / (alike - 1.0) * off / tests.powi(2);
        let size = over(|(_, number, samples)| number * samples) / tests;
        let assumed = 1.0 + (size - 1.0) * kind.correlation();
        let seen = match kind {
            Terms::Shares => mean.min(1.0 - mean).max(0.0) * count,
            Terms::Differences => self.squares,
            Terms::Amounts => f64::INFINITY,
        };
        let weight = if seen.is_finite() { seen / (seen + MISTAKES) } else { 1.0 };
        let alone = self.variance(kind);
        let measured = if alone > 0.0 { between / alone } else { assumed };
        let known = (alike - 1.0) * weight;
        let times = ((known * measured + PRIOR * assumed) / (known + PRIOR)).max(1.0);
        let variance = alone * times;
        let samples = if variance > 0.0 { self.of_share() / variance } else { count / times };
        Some(MeanEstimate {
            mean,
            variance,
            freedom: alike - 1.0 + PRIOR,
            samples,
            groups: Some(groups.len()),
            terms: kind,
        })
    }
}

/// Returns the bounds of a share of `samples` by Wilson's score (1927), `z` being the quantile of the confidence.
pub(crate) fn wilson(share: f64, samples: f64, z: f64) -> [f64; 2] {
    let more = z.powi(2) / samples;
    let middle = (share + more / 2.0) / (1.0 + more);
    let half = (more * (share * (1.0 - share) + more / 4.0)).max(0.0).sqrt() / (1.0 + more);
    // Exactly 0 and 1 at the ends, and never beyond.
    let low = if share <= 0.0 { 0.0 } else { (middle - half).clamp(0.0, share) };
    let high = if share >= 1.0 { 1.0 } else { (middle + half).clamp(share, 1.0) };
    [low, high]
}

/// Returns the value that Student's t exceeds with probability 1 − `q`, `q` above a half; of infinite `freedom` that of
/// the normal distribution.
#[expect(clippy::expect_used, reason = "callers have more values than they estimate")]
pub fn t_quantile(freedom: f64, q: f64) -> f64 {
    if freedom.is_infinite() {
        return Normal::standard().inverse_cdf(q);
    }
    let student = StudentsT::new(0.0, 1.0, freedom).expect("degrees of freedom above 0");
    let above = |x: f64| student.sf(x) > 1.0 - q;
    let mut high = 1.0;
    while above(high) && high < f64::MAX / 4.0 {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if above(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
