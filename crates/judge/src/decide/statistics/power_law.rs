//! A power law through the errors of several numbers of training samples.

use taxel_learn::metrics::mean_sd;

use super::check::check;
use crate::error::Result;
use crate::values::{CurveGain, CurveLaw, CurvePoint};

/// Rates that are tried: from hardly falling to 1 / count.
const RATES: usize = 60;
const SLOWEST: f64 = 0.05;
const FASTEST: f64 = 1.5;
/// Squares above the least ones, in units of the variance of a mean, of laws that fit nearly as well.
const NEAR: f64 = 2.0;
/// Standard errors to each side of a law, of gains and levels.
const ERRORS: f64 = 1.0;
/// The same of an error beyond the largest count, which one leaves in 6 of 100 simulated curves.
const ERRORS_BEYOND: f64 = 1.3;
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

/// Returns the rates that are tried, evenly on a logarithmic scale.
fn rates() -> impl Iterator<Item = f64> {
    (0..RATES).map(|step| SLOWEST * (FASTEST / SLOWEST).powf(step as f64 / (RATES - 1) as f64))
}

fn squares(points: &[(f64, f64)], law: &Law) -> f64 {
    points.iter().map(|(count, error)| (law.at(*count) - error).powi(2)).sum()
}

/// Fits `floor + scale · count^-rate` to errors by least squares, floor and scale at least 0. None where no error falls.
fn fit(points: &[(f64, f64)]) -> Option<Law> {
    let laws = rates().map(|rate| with_rate(points, rate));
    let best = laws.min_by(|a, b| squares(points, a).total_cmp(&squares(points, b)));
    best.filter(|law| law.scale > 0.0)
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

/// Fits a power law to the errors at several counts, and says what `more` recordings than `from` bring. `error` makes an error of a
/// score; `test_to_train` is the ratio of test to training samples of a fold.
///
/// An interval holds what every law says that fits nearly as well: of each rate whose squares, in units of the variance of a mean, lie at
/// most 2 above the least ones, the estimate with one standard error to each side, of the forecast 1.3. The variance is that of the
/// folds, with the correction of Nadeau and Bengio (2003), since folds share training samples. The tests count how often it holds
/// the truth. A law never rises, so nothing is lost by more recordings. None with fewer than three counts or folds, and where the
/// errors do not fall.
///
/// # Errors
/// Scores that are not finite.
pub fn power_law(
    points: &[CurvePoint],
    error: impl Fn(f64) -> f64,
    test_to_train: f64,
    (from, more): (f64, &[f64]),
) -> Result<Option<CurveLaw>> {
    let scores: Vec<f64> = points.iter().flat_map(|point| point.scores.iter().copied()).collect();
    check("power law", &scores, 1)?;
    let folds = points.iter().map(|point| point.scores.len()).min().unwrap_or(0);
    if points.len() < 3 || folds < 3 {
        return Ok(None);
    }
    let errors =
        |point: &CurvePoint| mean_sd(&point.scores.iter().map(|score| error(*score)).collect::<Vec<_>>());
    let means: Vec<(f64, f64)> = points.iter().map(|point| (point.count, errors(point).0)).collect();
    let spread: f64 = points.iter().filter_map(|point| errors(point).1).map(|sd| sd * sd).sum();
    let variance = spread / points.len() as f64 * (1.0 / folds as f64 + test_to_train);
    let Some(whole) = fit(&means) else { return Ok(None) };
    let near: Vec<Law> = rates()
        .map(|rate| with_rate(&means, rate))
        .filter(|law| squares(&means, law) - squares(&means, &whole) <= NEAR * variance)
        .collect();
    // What is estimated is a weighted sum of floor and scale.
    let ends = |sides: f64, floor: f64, of_scale: &dyn Fn(&Law) -> f64| -> [f64; 2] {
        let of = |law: &Law| {
            let (size, slope) = (floor * law.floor + of_scale(law) * law.scale, of_scale(law));
            let error = sides * (variance * unit_variance(&means, law, floor, slope)).sqrt();
            [size - error, size + error]
        };
        let all = near.iter().chain([&whole]).map(of);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)])
    };
    let left = whole.at(from);
    let gain = |more: &f64| {
        let fall = |law: &Law| from.powf(-law.rate) - (from + more).powf(-law.rate);
        let (gain, [low, high]) = (fall(&whole) * whole.scale, ends(ERRORS, 0.0, &fall));
        // No more can be won than there is.
        CurveGain { more: *more, gain, interval: [low.max(0.0), high.min(left.max(gain))] }
    };
    let [low, high] = ends(ERRORS, 1.0, &|_| 0.0);
    let level = [low.max(0.0), high.min(left).max(whole.floor)];
    let [below, above] = ends(ERRORS_BEYOND, 1.0, &|law| from.powf(-law.rate));
    let is_known = level[1] - level[0] < VAGUE * left;
    Ok(Some(CurveLaw {
        floor: whole.floor,
        scale: whole.scale,
        rate: whole.rate,
        forecast: Some((left, [below.max(0.0), above])),
        level: is_known.then_some((whole.floor, level)),
        gains: more.iter().map(gain).collect(),
    }))
}

impl CurveLaw {
    /// Returns the law with its gains in proportion to the `error` that the run itself has at its count. Inner folds have fewer
    /// recordings and other test samples, so their law may be off by a factor; and no more can be won than the run still lacks.
    #[must_use]
    pub fn anchored(mut self, error: f64) -> CurveLaw {
        let Some((expected, _)) = self.forecast.filter(|(expected, _)| *expected > 0.0) else { return self };
        let factor = error.max(0.0) / expected;
        for CurveGain { gain, interval, .. } in &mut self.gains {
            *gain *= factor;
            *interval = interval.map(|end| end * factor);
        }
        self
    }
}

/// Returns the variance of `floor` times the floor plus `slope` times the scale of a law with its rate, for errors of variance 1.
fn unit_variance(points: &[(f64, f64)], law: &Law, floor: f64, slope: f64) -> f64 {
    let falls: Vec<f64> = points.iter().map(|(count, _)| count.powf(-law.rate)).collect();
    let n = falls.len() as f64;
    if law.floor == 0.0 {
        // The floor is where it may not go lower.
        return slope * slope / falls.iter().map(|fall| fall * fall).sum::<f64>();
    }
    let mean = falls.iter().sum::<f64>() / n;
    let square: f64 = falls.iter().map(|fall| (fall - mean).powi(2)).sum();
    floor * floor / n + (slope - floor * mean).powi(2) / square
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use rand::RngExt;

    const COUNTS: [f64; 4] = [5.0, 10.0, 20.0, 40.0];

    /// Returns the law of errors at `COUNTS` and the gains of `more` than `from`.
    fn law_of(errors: impl Fn(usize, usize) -> f64, from: f64, more: &[f64]) -> Option<CurveLaw> {
        let point = |(at, count): (usize, &f64)| {
            let scores: Vec<f64> = (0..5).map(|fold| 100.0 - errors(at, fold)).collect();
            CurvePoint { count: *count, score: scores.iter().sum::<f64>() / 5.0, scores }
        };
        let points: Vec<CurvePoint> = COUNTS.iter().enumerate().map(point).collect();
        power_law(&points, |score| 100.0 - score, 0.25, (from, more)).unwrap()
    }

    #[test]
    fn gains_are_in_proportion_to_the_run_s_own_error() {
        let law = law_of(|at, _| 8.0 + 40.0 / COUNTS[at].sqrt(), 50.0, &[40.0, 4000.0]).unwrap();
        let (expected, _) = law.forecast.unwrap();
        let nearer = law.clone().anchored(expected / 4.0);
        for (before, after) in law.gains.iter().zip(&nearer.gains) {
            assert!((after.gain - before.gain / 4.0).abs() < 1e-9, "{after:?}");
            assert!(after.interval[1] <= expected / 4.0 + 1e-9, "more than is lacking: {after:?}");
        }
        assert_eq!(law.clone().anchored(expected).gains, law.gains);
        assert!(law.anchored(0.0).gains.iter().all(|gain| gain.gain == 0.0));
    }

    #[test]
    fn an_exact_law_is_found() {
        let law = law_of(|at, _| 8.0 + 40.0 / COUNTS[at].sqrt(), 50.0, &[40.0]).unwrap();
        assert!((law.floor - 8.0).abs() < 0.5 && (law.rate - 0.5).abs() < 0.05, "{law:?}");
        let gain = 40.0 / 50f64.sqrt() - 40.0 / 90f64.sqrt();
        assert!((law.gains[0].gain - gain).abs() < 0.05, "{law:?}");
        let (error, [low, high]) = law.forecast.unwrap();
        let truth = 8.0 + 40.0 / 50f64.sqrt();
        assert!((error - truth).abs() < 0.05 && low <= error && error <= high, "{law:?}");
    }

    #[test]
    fn errors_that_do_not_fall_have_no_law() {
        assert_eq!(law_of(|at, _| 10.0 + at as f64, 40.0, &[40.0]), None);
    }

    /// Checks that of 200 noisy curves of each of five laws the intervals of the forecast and of the gain hold the true ones in 93 %
    /// at least, a quarter beyond the largest count.
    #[test]
    fn intervals_hold_the_true_error_and_gain() {
        for (floor, scale, rate, noise) in [
            (8.0, 40.0, 0.5, 1.5),
            (8.0, 40.0, 0.5, 4.0),
            (0.0, 60.0, 0.4, 2.0),
            (10.0, 80.0, 1.0, 2.0),
            (20.0, 30.0, 0.3, 3.0),
        ] {
            let truth = scale * (50f64.powf(-rate) - 90f64.powf(-rate));
            let error_there = floor + scale * 50f64.powf(-rate);
            let mut held = [0; 2];
            for draw in 0..200 {
                let mut rng = taxel_base::seed::rng(draw, "power law");
                let normal: Vec<f64> =
                    (0..20).map(|_| (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0).collect();
                let error = |at: usize, fold: usize| {
                    floor + scale * COUNTS[at].powf(-rate) + noise * normal[5 * at + fold]
                };
                let Some(law) = law_of(error, 50.0, &[40.0]) else { continue };
                let is_in = |[low, high]: [f64; 2], value: f64| usize::from(low <= value && value <= high);
                held[0] += is_in(law.gains[0].interval, truth);
                held[1] += is_in(law.forecast.unwrap().1, error_there);
            }
            assert!(
                held.iter().all(|held| *held >= 186),
                "{floor} + {scale} n^-{rate}, noise {noise}: {held:?} of 200"
            );
        }
    }
}
