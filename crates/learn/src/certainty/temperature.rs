//! The temperature of a softmax.

use taxel_base::exponential::{exp, ln, shares};

use crate::metrics::each_attribute;

/// Bounds of 1/T. A nearest neighbour that is always sure needs a T of hundreds, a ridge one of a hundredth.
const INVERSE: [f64; 2] = [1e-4, 1e4];
/// Halvings of these bounds on a logarithmic scale: the last is below the precision of f64.
const HALVINGS: usize = 64;

/// Divides the logits of probabilities by a temperature, attribute by attribute. `probabilities` are rows of the outputs of all
/// attributes, whose `sizes` are their numbers of classes. Nothing is allocated.
///
/// A probability of 0 counts as the smallest positive f32.
///
/// ```
/// let mut row = [0.8, 0.2];
/// taxel_learn::certainty::tempered(&mut row, &[2], 2.0);
/// assert!((row[0] - 2.0 / 3.0).abs() < 1e-6, "4 to 1 becomes 2 to 1");
/// ```
pub fn tempered(probabilities: &mut [f32], sizes: &[usize], temperature: f64) {
    let inverse = (1.0 / temperature) as f32;
    each_attribute(probabilities, sizes, |row| {
        let highest = ln(row.iter().copied().fold(f32::MIN_POSITIVE, f32::max));
        row.iter_mut().for_each(|p| *p = exp((ln(p.max(f32::MIN_POSITIVE)) - highest) * inverse));
        shares(row);
    });
}

/// Fits the temperature at which `probabilities` `[n, outputs]` have the least log loss for the labels `truth`
/// `[n, attributes]`; `sizes` are the numbers of classes of the attributes. None without a sample.
///
/// The targets are smoothed to 1 − 1/(n + 2), as Platt (1999) does: of predictions that are all right, T would become 0.
/// The loss is convex in 1/T, so that its slope has one zero.
pub fn fitted_temperature(probabilities: &[f32], truth: &[u32], sizes: &[usize]) -> Option<f64> {
    let outputs: usize = sizes.iter().sum();
    let samples = probabilities.len().checked_div(outputs).filter(|samples| *samples > 0)?;
    fit(&logits(probabilities), truth, sizes, 1.0 / (samples as f64 + 2.0))
}

/// Fits the temperature at which `probabilities` `[n, outputs]` are nearest to `wanted` ones of the same samples, by
/// cross-entropy. None without a sample.
pub fn matched_temperature(probabilities: &[f32], wanted: &[f32], sizes: &[usize]) -> Option<f64> {
    let outputs: usize = sizes.iter().sum();
    let is_usable = outputs > 0 && !probabilities.is_empty() && probabilities.len() == wanted.len();
    if !is_usable {
        return None;
    }
    let logits = logits(probabilities);
    solve(&logits, |inverse| {
        let (mut row, mut targets, mut sum) = (logits.as_slice(), wanted, 0.0);
        for size in sizes.iter().cycle() {
            if row.is_empty() {
                return sum;
            }
            let ((own, others), (of_own, of_others)) = (row.split_at(*size), targets.split_at(*size));
            sum += slope_of(own, inverse, |class| f64::from(of_own[class]));
            (row, targets) = (others, of_others);
        }
        sum
    })
}

fn fit(logits: &[f64], truth: &[u32], sizes: &[usize], smoothing: f64) -> Option<f64> {
    solve(logits, |inverse| {
        let mut sum = 0.0;
        let (mut row, mut labels) = (logits, truth.iter());
        for (size, label) in sizes.iter().cycle().zip(&mut labels) {
            let (own, others) = row.split_at(*size);
            let rest = smoothing / (own.len() as f64 - 1.0).max(1.0);
            sum +=
                slope_of(own, inverse, |class| if class == *label as usize { 1.0 - smoothing } else { rest });
            row = others;
        }
        sum
    })
}

/// Finds the T where the slope of the loss by 1/T is 0.
fn solve(logits: &[f64], slope: impl Fn(f64) -> f64) -> Option<f64> {
    let [mut low, mut high] = INVERSE.map(f64::ln);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if slope(middle.exp()) < 0.0 { low = middle } else { high = middle }
    }
    // Where all classes are equally likely in every row, every T is as good.
    let is_flat = logits.iter().all(|z| *z == logits[0]);
    if is_flat { Some(1.0) } else { Some((-0.5 * (low + high)).exp()) }
}

/// Returns the slope of the log loss of one row by 1/T: the mean logit under the softmax less that under the target.
fn slope_of(logits: &[f64], inverse: f64, target: impl Fn(usize) -> f64) -> f64 {
    let highest = logits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (mut sum, mut mean) = (0.0, 0.0);
    for z in logits {
        let weight = ((z - highest) * inverse).exp();
        sum += weight;
        mean += weight * z;
    }
    mean / sum - logits.iter().enumerate().map(|(class, z)| target(class) * z).sum::<f64>()
}

fn logits(probabilities: &[f32]) -> Vec<f64> {
    probabilities.iter().map(|p| f64::from(p.max(f32::MIN_POSITIVE)).ln()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// `scripts/fixtures/temperature.py` writes it with scikit-learn and scipy.
    const TWIN: &str = include_str!("../../tests/data/temperature.json");

    #[test]
    fn temperatures_are_those_of_scikit_learn_and_scipy() {
        let twin: serde_json::Value = serde_json::from_str(TWIN).unwrap();
        let cases = twin["cases"].as_array().unwrap();
        assert!(cases.len() > 3);
        for case in cases {
            let list = |key: &str| -> Vec<f64> { serde_json::from_value(case[key].clone()).unwrap() };
            let probabilities: Vec<f32> = list("probabilities").iter().map(|p| *p as f32).collect();
            let truth: Vec<u32> = list("truth").iter().map(|label| *label as u32).collect();
            let sizes = [probabilities.len() / truth.len()];
            let is_near = |temperature: f64, wanted: f64| (temperature / wanted - 1.0).abs() < 2e-3;
            let smoothed = fitted_temperature(&probabilities, &truth, &sizes).unwrap();
            let plain = fit(&logits(&probabilities), &truth, &sizes, 0.0).unwrap();
            let [scipy, sklearn] = ["scipy", "sklearn"].map(|key| case[key].as_f64().unwrap());
            assert!(is_near(smoothed, scipy), "{}: {smoothed} and {scipy}", case["name"]);
            assert!(is_near(plain, sklearn), "{}: {plain} and {sklearn}", case["name"]);
            let mut warm = probabilities;
            tempered(&mut warm, &sizes, smoothed);
            for (p, wanted) in warm.iter().zip(list("tempered")) {
                assert!((f64::from(*p) - wanted).abs() < 1e-3, "{}: {p} and {wanted}", case["name"]);
            }
        }
    }

    #[test]
    fn a_twin_that_is_surer_is_brought_to_the_same_probabilities() {
        let wanted = [0.7, 0.2, 0.1, 0.05, 0.9, 0.05, 0.4, 0.35, 0.25];
        let mut surer = wanted;
        tempered(&mut surer, &[3], 0.4);
        let temperature = matched_temperature(&surer, &wanted, &[3]).unwrap();
        assert!((temperature - 2.5).abs() < 1e-4, "{temperature}");
        assert_eq!(matched_temperature(&[], &[], &[3]), None);
    }

    #[test]
    fn predictions_that_are_all_right_do_not_become_certain() {
        let right: Vec<f32> = [0.6, 0.4].repeat(30);
        let temperature = fitted_temperature(&right, &[0; 30], &[2]).unwrap();
        let mut row = [0.6, 0.4];
        tempered(&mut row, &[2], temperature);
        assert!((row[0] - (1.0 - 1.0 / 32.0)).abs() < 1e-4, "{row:?}");
    }

    #[test]
    fn certain_answers_become_as_sure_as_they_are_right() {
        let sure: Vec<f32> = [1.0, 0.0, 0.0].repeat(100);
        let truth: Vec<u32> = (0..100).map(|at| u32::from(at % 2 == 0)).collect();
        let temperature = fitted_temperature(&sure, &truth, &[3]).unwrap();
        let mut row = [0.0, 1.0, 0.0];
        tempered(&mut row, &[3], temperature);
        assert!((row[1] - 0.5).abs() < 0.01 && (row.iter().sum::<f32>() - 1.0).abs() < 1e-6, "{row:?}");
    }

    #[test]
    fn attributes_are_softmaxes_of_their_own_and_flat_rows_stay() {
        let mut two = [0.8, 0.2, 0.1, 0.1, 0.8];
        tempered(&mut two, &[2, 3], 2.0);
        let (mut first, mut second) = ([0.8, 0.2], [0.1, 0.1, 0.8]);
        tempered(&mut first, &[2], 2.0);
        tempered(&mut second, &[3], 2.0);
        assert_eq!((&two[..2], &two[2..]), (&first[..], &second[..]));
        assert_eq!(fitted_temperature(&[0.5; 8], &[0, 1, 1, 1], &[2]), Some(1.0));
        assert_eq!(fitted_temperature(&[], &[], &[2]), None);
    }
}
