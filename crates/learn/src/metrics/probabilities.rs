//! Whether probabilities mean what they say.

use crate::error::{Error, Result};
use crate::metrics::argmax;

/// Bins of [`calibration_error`] where nothing else is said.
pub const BINS: usize = 15;

/// Checks that there is one label per row of `classes` probabilities, and that it is one of the classes.
fn check(probabilities: &[f32], truth: &[u32], classes: usize) -> Result<()> {
    let refuse = |reason| Err(Error::Metrics { what: "probabilities", reason });
    if truth.is_empty() || probabilities.len() != truth.len() * classes {
        let (values, samples) = (probabilities.len(), truth.len());
        return refuse(format!("{values} for {samples} samples of {classes} classes"));
    }
    match truth.iter().find(|&&label| label as usize >= classes) {
        Some(label) => refuse(format!("label {label} of {classes} classes")),
        None => Ok(()),
    }
}

/// Computes the expected calibration error (Guo et al., ICML 2017): samples fall into `bins` equal bins of (0, 1] by
/// the probability of the predicted class. The error is the mean distance, weighted by samples, between that
/// probability and the share that is right. 0 is calibrated, 1 the worst.
///
/// `probabilities` are `[n, classes]`, row-major; [`BINS`] is the usual number of bins.
///
/// # Errors
/// No samples, or labels that do not fit the probabilities.
pub fn calibration_error(probabilities: &[f32], truth: &[u32], classes: usize, bins: usize) -> Result<f64> {
    check(probabilities, truth, classes)?;
    let mut sums = vec![(0.0, 0.0); bins.max(1)];
    let rows = probabilities.chunks_exact(classes).zip(argmax(probabilities, classes)).zip(truth);
    for ((row, predicted), &label) in rows {
        let confidence = f64::from(row[predicted as usize]);
        let bin = (confidence * sums.len() as f64).ceil() as usize;
        let last = sums.len();
        let (confident, right) = &mut sums[bin.clamp(1, last) - 1];
        *confident += confidence;
        *right += f64::from(u8::from(predicted == label));
    }
    Ok(sums.iter().map(|(confident, right)| (confident - right).abs()).sum::<f64>() / truth.len() as f64)
}

/// Computes the Brier score of several classes: the mean over samples of Σ (p − 1\[true class\])², 0 to 2
/// (scikit-learn: `brier_score_loss(scale_by_half=False)`).
///
/// # Errors
/// As [`calibration_error`].
pub fn brier(probabilities: &[f32], truth: &[u32], classes: usize) -> Result<f64> {
    check(probabilities, truth, classes)?;
    let mut sum = 0.0;
    for (row, &label) in probabilities.chunks_exact(classes).zip(truth) {
        for (class, &p) in row.iter().enumerate() {
            let target = f64::from(u8::from(class == label as usize));
            sum += (f64::from(p) - target).powi(2);
        }
    }
    Ok(sum / truth.len() as f64)
}

/// Computes the mean of −log p of the true class; a probability of 0 counts as the smallest positive f32, since JSON
/// holds no infinity.
///
/// # Errors
/// As [`calibration_error`].
pub fn log_loss(probabilities: &[f32], truth: &[u32], classes: usize) -> Result<f64> {
    check(probabilities, truth, classes)?;
    let rows = probabilities.chunks_exact(classes).zip(truth);
    let sum: f64 = rows.map(|(row, &t)| -f64::from(row[t as usize].max(f32::MIN_POSITIVE)).ln()).sum();
    Ok(sum / truth.len() as f64)
}
