//! Losses with their gradients.

/// Mean softmax cross-entropy over rows of `logits` (rows × classes) and its gradient.
pub fn softmax_cross_entropy(logits: &[f32], classes: usize, labels: &[u32], gradient: &mut [f32]) -> f32 {
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

/// Probabilities of one row of logits. A row with NaN gives NaN.
pub fn softmax(logits: &[f32], probabilities: &mut [f32]) {
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
