//! A power law through the errors of several numbers of training samples.

use super::pairs::corrected_t;
use crate::error::Result;
use crate::values::{CurveGain, CurveLaw, CurvePoint};

/// Rates that are tried: from hardly falling to 1 / count.
const RATES: usize = 60;
const SLOWEST: f64 = 0.05;
const FASTEST: f64 = 1.5;
/// Widest interval of a level, as a share of the last error, that says anything.
const VAGUE: f64 = 1.0;

/// A law without what follows from it.
#[derive(Clone, Copy)]
struct Law {
    floor: f64,
    scale: f64,
    rate: f64,
}

impl Law {
    fn at(&self, count: f64) -> f64 {
        self.floor + self.scale * count.powf(-self.rate)
    }
}

/// Fits `floor + scale · count^-rate` to errors by least squares, floor and scale at least 0. None where no error falls.
fn fit(points: &[(f64, f64)]) -> Option<Law> {
    let mut best: Option<(f64, Law)> = None;
    for step in 0..RATES {
        let rate = SLOWEST * (FASTEST / SLOWEST).powf(step as f64 / (RATES - 1) as f64);
        let law = with_rate(points, rate);
        let loss: f64 = points.iter().map(|(count, error)| (law.at(*count) - error).powi(2)).sum();
        if best.is_none_or(|(least, _)| loss < least) {
            best = Some((loss, law));
        }
    }
    best.map(|(_, law)| law).filter(|law| law.scale > 0.0)
}

/// Fits floor and scale for one rate.
fn with_rate(points: &[(f64, f64)], rate: f64) -> Law {
    let n = points.len() as f64;
    let falls: Vec<(f64, f64)> = points.iter().map(|(count, error)| (count.powf(-rate), *error)).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| falls.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let product: f64 = falls.iter().map(|(a, b)| (a - x) * (b - y)).sum();
    let square: f64 = falls.iter().map(|(a, _)| (a - x).powi(2)).sum();
    let scale = if square > 0.0 { product / square } else { 0.0 };
    let floor = y - scale * x;
    if scale <= 0.0 {
        return Law { floor: y.max(0.0), scale: 0.0, rate };
    }
    if floor >= 0.0 {
        return Law { floor, scale, rate };
    }
    // Through the origin.
    let scale = falls.iter().map(|(a, b)| a * b).sum::<f64>() / falls.iter().map(|(a, _)| a * a).sum::<f64>();
    Law { floor: 0.0, scale: scale.max(0.0), rate }
}

/// Fits a power law to the errors at several counts, and says what `more` recordings bring. `error` makes an error of a score;
/// `test_to_train` is the ratio of test to training samples of a fold.
///
/// Intervals are those of the jackknife over folds: what each fold changes about the estimate, by the [`corrected_t`] test, since
/// folds share training samples. A law never rises, so nothing is lost by more recordings. None with fewer than three counts or
/// folds, and where the errors do not fall.
///
/// # Errors
/// Scores that are not finite.
pub fn power_law(
    points: &[CurvePoint],
    error: impl Fn(f64) -> f64,
    test_to_train: f64,
    more: &[f64],
) -> Result<Option<CurveLaw>> {
    let folds = points.iter().map(|point| point.scores.len()).min().unwrap_or(0);
    if points.len() < 3 || folds < 3 {
        return Ok(None);
    }
    let without = |left_out: Option<usize>| -> Option<Law> {
        let mean = |point: &CurvePoint| {
            let kept =
                point.scores.iter().take(folds).enumerate().filter(|(fold, _)| Some(*fold) != left_out);
            let (sum, count) =
                kept.fold((0.0, 0), |(sum, count), (_, score)| (sum + error(*score), count + 1));
            (point.count, sum / count as f64)
        };
        fit(&points.iter().map(mean).collect::<Vec<_>>())
    };
    let Some(whole) = without(None) else { return Ok(None) };
    // A fold without which nothing falls says that nothing is known of the fall.
    let parts: Vec<Law> =
        (0..folds).map(|fold| without(Some(fold)).unwrap_or(Law { scale: 0.0, ..whole })).collect();
    let last = points[points.len() - 1].count;
    let estimate = |of: &dyn Fn(&Law) -> f64| -> Result<(f64, [f64; 2])> {
        let (all, n) = (of(&whole), folds as f64);
        let pseudo: Vec<f64> = parts.iter().map(|law| n * all - (n - 1.0) * of(law)).collect();
        let test = corrected_t(&pseudo, test_to_train, 0.95)?;
        let half = test.interval.map_or(0.0, |[low, high]| (high - low) / 2.0);
        Ok((all, [all - half, all + half]))
    };
    let mut gains = vec![];
    for &more in more {
        let (gain, [low, high]) = estimate(&|law| law.at(last) - law.at(last + more))?;
        // What is left of the error is the most that can be won.
        let most = whole.at(last).max(gain);
        gains.push(CurveGain { more, gain, interval: [low.max(0.0), high.min(most)] });
    }
    let (floor, [low, high]) = estimate(&|law| law.floor)?;
    let ends = [low.max(0.0), high.min(whole.at(last)).max(floor)];
    let is_known = ends[1] - ends[0] < VAGUE * whole.at(last);
    let level = is_known.then_some((floor, ends));
    Ok(Some(CurveLaw { floor, scale: whole.scale, rate: whole.rate, level, gains }))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use rand::RngExt;

    const COUNTS: [f64; 4] = [5.0, 10.0, 20.0, 40.0];

    fn law_of(errors: impl Fn(usize, usize) -> f64, more: &[f64]) -> Option<CurveLaw> {
        let point = |(at, count): (usize, &f64)| {
            let scores: Vec<f64> = (0..5).map(|fold| 100.0 - errors(at, fold)).collect();
            CurvePoint { count: *count, score: scores.iter().sum::<f64>() / 5.0, scores }
        };
        let points: Vec<CurvePoint> = COUNTS.iter().enumerate().map(point).collect();
        power_law(&points, |score| 100.0 - score, 0.25, more).unwrap()
    }

    #[test]
    fn an_exact_law_is_found() {
        let law = law_of(|at, _| 8.0 + 40.0 / COUNTS[at].sqrt(), &[40.0]).unwrap();
        assert!((law.floor - 8.0).abs() < 0.5 && (law.rate - 0.5).abs() < 0.05, "{law:?}");
        let gain = 40.0 / 40f64.sqrt() - 40.0 / 80f64.sqrt();
        assert!((law.gains[0].gain - gain).abs() < 0.05, "{law:?}");
    }

    #[test]
    fn errors_that_do_not_fall_have_no_law() {
        assert_eq!(law_of(|at, _| 10.0 + at as f64, &[40.0]), None);
    }

    /// Checks that of 200 noisy curves the interval of the gain holds the true one in nine of ten at least.
    #[test]
    fn intervals_hold_the_true_gain() {
        let truth = 40.0 / 40f64.sqrt() - 40.0 / 80f64.sqrt();
        let mut held = 0;
        for draw in 0..200 {
            let mut rng = taxel_base::seed::rng(draw, "power law");
            let noise: Vec<f64> =
                (0..20).map(|_| (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0).collect();
            let law = law_of(|at, fold| 8.0 + 40.0 / COUNTS[at].sqrt() + 1.5 * noise[5 * at + fold], &[40.0]);
            let Some(law) = law else { continue };
            let [low, high] = law.gains[0].interval;
            held += usize::from(low <= truth && truth <= high);
        }
        assert!(held >= 180, "{held} of 200");
    }
}
