//! Losses with their gradients.

use crate::lengths::{exactly, whole_rows};

/// Returns the mean softmax cross-entropy over rows of `logits` (rows × classes) and writes its gradient.
pub fn softmax_cross_entropy(logits: &[f32], classes: usize, labels: &[u32], gradient: &mut [f32]) -> f32 {
    exactly("logits of a row per label", logits.len(), labels.len() * classes);
    exactly("gradient of the logits", gradient.len(), logits.len());
    let share = 1.0 / labels.len() as f64;
    let mut total = 0.0f64;
    let rows = logits.chunks_exact(classes).zip(gradient.chunks_exact_mut(classes));
    for ((row, gradient), &label) in rows.zip(labels) {
        softmax(row, gradient);
        let largest = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let sum: f64 = row.iter().map(|&v| f64::from(v - largest).exp()).sum();
        total += sum.ln() - f64::from(row[label as usize] - largest);
        gradient[label as usize] -= 1.0;
        for value in gradient {
            *value *= share as f32;
        }
    }
    (total * share) as f32
}

/// Returns the mean softmax cross-entropy against target weights (rows × classes), −Σ t·log softmax, and writes its
/// gradient. Rows of `targets` need not add up to 1: class weights are in them.
pub fn softmax_cross_entropy_soft(
    logits: &[f32],
    classes: usize,
    targets: &[f32],
    gradient: &mut [f32],
) -> f32 {
    whole_rows("logits", logits.len(), classes);
    exactly("targets of the logits", targets.len(), logits.len());
    exactly("gradient of the logits", gradient.len(), logits.len());
    let share = classes as f64 / logits.len() as f64;
    let mut total = 0.0f64;
    let rows = logits.chunks_exact(classes).zip(targets.chunks_exact(classes));
    for ((row, targets), gradient) in rows.zip(gradient.chunks_exact_mut(classes)) {
        softmax(row, gradient);
        let largest = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let log_sum = row.iter().map(|&v| f64::from(v - largest).exp()).sum::<f64>().ln();
        let whole: f64 = targets.iter().map(|&t| f64::from(t)).sum();
        for ((gradient, &logit), &target) in gradient.iter_mut().zip(row).zip(targets) {
            total += f64::from(target) * (log_sum - f64::from(logit - largest));
            *gradient = ((whole * f64::from(*gradient) - f64::from(target)) * share) as f32;
        }
    }
    (total * share) as f32
}

/// Writes the probabilities of one row of logits. A row with NaN gives NaN.
pub fn softmax(logits: &[f32], probabilities: &mut [f32]) {
    exactly("probabilities of the logits", probabilities.len(), logits.len());
    let largest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut sum = 0.0f64;
    for (p, &logit) in probabilities.iter_mut().zip(logits) {
        let value = f64::from(logit - largest).exp();
        sum += value;
        *p = value as f32;
    }
    for p in probabilities {
        *p = (f64::from(*p) / sum) as f32;
    }
}

/// Returns the mean multi-label soft margin over all `logits` and writes its gradient; `targets` are 0 to 1.
///
/// −(t·log σ(x) + (1−t)·log σ(−x)), written so that no exponential overflows.
pub fn multi_label_soft_margin(logits: &[f32], targets: &[f32], gradient: &mut [f32]) -> f32 {
    mean(logits, targets, gradient, |x, t| {
        // Not `max`, which would hide NaN.
        let positive = if x < 0.0 { 0.0 } else { x };
        let tail = (-x.abs()).exp();
        let sigmoid = if x < 0.0 { tail / (1.0 + tail) } else { 1.0 / (1.0 + tail) };
        (positive - x * t + tail.ln_1p(), sigmoid - t)
    })
}

/// Returns the mean of max(0, 1 − s·output) over all `outputs` and writes its gradient, with s = 2·target − 1;
/// `targets` are 0 to 1.
pub fn hinge(outputs: &[f32], targets: &[f32], gradient: &mut [f32]) -> f32 {
    mean(outputs, targets, gradient, |x, t| {
        let side = 2.0 * t - 1.0;
        let missing = 1.0 - side * x;
        // NaN stays NaN.
        if missing <= 0.0 { (0.0, 0.0) } else { (missing, -side) }
    })
}

/// Returns the mean of (output − target)² over all `outputs` and writes its gradient.
pub fn mean_squared_error(outputs: &[f32], targets: &[f32], gradient: &mut [f32]) -> f32 {
    mean(outputs, targets, gradient, |x, t| ((x - t) * (x - t), 2.0 * (x - t)))
}

/// Returns the mean over all `outputs` of (output − target)² / 2 where they differ by at most 1, of |output − target| − 1/2
/// elsewhere, and writes its gradient.
pub fn huber(outputs: &[f32], targets: &[f32], gradient: &mut [f32]) -> f32 {
    mean(outputs, targets, gradient, |x, t| {
        let error = x - t;
        // NaN stays NaN.
        if error.abs() > 1.0 { (error.abs() - 0.5, error.signum()) } else { (0.5 * error * error, error) }
    })
}

/// Returns the mean of (s + (m − t)² · e^−s) / 2 over all `targets` (rows × width), and writes its gradient; a row of
/// `outputs` is its means m, then its log variances s, which count as at least ln of `least_variance`, because below that
/// a single error outweighs all else; no sample pulls them lower.
pub fn gaussian_likelihood(
    outputs: &[f32],
    targets: &[f32],
    width: usize,
    least_variance: f64,
    gradient: &mut [f32],
) -> f32 {
    whole_rows("targets", targets.len(), width);
    exactly("outputs of the targets", outputs.len(), 2 * targets.len());
    exactly("gradient of the outputs", gradient.len(), outputs.len());
    let (share, least) = (1.0 / targets.len() as f64, least_variance.ln());
    let mut total = 0.0;
    let rows = outputs.chunks_exact(2 * width).zip(gradient.chunks_exact_mut(2 * width));
    for ((row, gradient), targets) in rows.zip(targets.chunks_exact(width)) {
        for (at, &target) in targets.iter().enumerate() {
            let (error, said) = (f64::from(row[at]) - f64::from(target), f64::from(row[width + at]));
            // Not `max`, which would hide NaN.
            let log = if said < least { least } else { said };
            let precision = (-log).exp();
            total += 0.5 * (log + error * error * precision);
            gradient[at] = (error * precision * share) as f32;
            let slope = 0.5 * (1.0 - error * error * precision);
            gradient[width + at] = if said < least && slope > 0.0 { 0.0 } else { (slope * share) as f32 };
        }
    }
    (total * share) as f32
}

/// Returns the mean pinball loss over all `targets` (rows × width) and `quantiles`, and writes its gradient; a row of
/// `outputs` is the first quantile of each target, then the second of each, and so on.
pub fn pinball(
    outputs: &[f32],
    targets: &[f32],
    width: usize,
    quantiles: &[f64],
    gradient: &mut [f32],
) -> f32 {
    let each = width * quantiles.len();
    whole_rows("targets", targets.len(), width);
    exactly("outputs of the targets", outputs.len(), quantiles.len() * targets.len());
    exactly("gradient of the outputs", gradient.len(), outputs.len());
    let share = 1.0 / outputs.len() as f64;
    let mut total = 0.0;
    let rows = outputs.chunks_exact(each).zip(gradient.chunks_exact_mut(each));
    for ((row, gradient), targets) in rows.zip(targets.chunks_exact(width)) {
        for (at, (&output, gradient)) in row.iter().zip(gradient).enumerate() {
            let (quantile, missing) =
                (quantiles[at / width], f64::from(targets[at % width]) - f64::from(output));
            let slope = match missing {
                ..0.0 => quantile - 1.0,
                0.0.. => quantile,
                // NaN stays NaN.
                _ => missing,
            };
            total += slope * missing;
            *gradient = (-slope * share) as f32;
        }
    }
    (total * share) as f32
}

/// Returns the mean of a loss value by value and writes its gradient; `term` gives the loss and its derivative.
fn mean(
    outputs: &[f32],
    targets: &[f32],
    gradient: &mut [f32],
    term: impl Fn(f64, f64) -> (f64, f64),
) -> f32 {
    exactly("targets of the outputs", targets.len(), outputs.len());
    exactly("gradient of the outputs", gradient.len(), outputs.len());
    let share = 1.0 / outputs.len() as f64;
    let mut total = 0.0;
    for ((&output, &target), gradient) in outputs.iter().zip(targets).zip(gradient) {
        let (loss, slope) = term(f64::from(output), f64::from(target));
        total += loss;
        *gradient = (slope * share) as f32;
    }
    (total * share) as f32
}
