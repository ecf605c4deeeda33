//! How well a score ranks samples of one class before those of another, whatever the threshold.

/// Returns the area under the ROC curve: the share of pairs, one sample of each kind, that `scores` bring in the right order;
/// equal scores count half (scikit-learn's `roc_auc_score`). None where one kind is missing.
pub fn roc_area(scores: &[f32], is_positive: &[bool]) -> Option<f64> {
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|a, b| scores[*a].total_cmp(&scores[*b]));
    let (mut below, mut right) = (0.0, 0.0);
    for equal in order.chunk_by(|a, b| scores[*a] == scores[*b]) {
        let positives = equal.iter().filter(|row| is_positive[**row]).count() as f64;
        let negatives = equal.len() as f64 - positives;
        right += positives * (below + negatives / 2.0);
        below += negatives;
    }
    let positives = is_positive.iter().filter(|is| **is).count() as f64;
    (positives > 0.0 && below > 0.0).then(|| right / (positives * below))
}

/// Returns the mean precision over the recalls that falling thresholds reach (scikit-learn's `average_precision_score`). None
/// without a positive sample.
pub fn average_precision(scores: &[f32], is_positive: &[bool]) -> Option<f64> {
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|a, b| scores[*b].total_cmp(&scores[*a]));
    let positives = is_positive.iter().filter(|is| **is).count() as f64;
    let (mut found, mut seen, mut area) = (0.0, 0.0, 0.0);
    for equal in order.chunk_by(|a, b| scores[*a] == scores[*b]) {
        let more = equal.iter().filter(|row| is_positive[**row]).count() as f64;
        (found, seen) = (found + more, seen + equal.len() as f64);
        area += more / positives * (found / seen);
    }
    (positives > 0.0).then_some(area)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn areas_are_those_of_scikit_learn() {
        // scikit-learn 1.9.1: roc_auc_score and average_precision_score, with ties.
        let scores = [0.1, 0.4, 0.35, 0.8, 0.4, 0.7, 0.2, 0.4, 0.9, 0.35];
        let is_positive = [false, false, true, true, true, false, false, true, true, false];
        assert!((roc_area(&scores, &is_positive).unwrap() - 0.78).abs() < 1e-12);
        assert!((average_precision(&scores, &is_positive).unwrap() - 0.7916666666666665).abs() < 1e-9);
        assert_eq!(roc_area(&[0.1, 0.9], &[false, true]), Some(1.0));
        assert_eq!(roc_area(&[0.5, 0.5], &[false, true]), Some(0.5));
        assert_eq!(roc_area(&[0.5, 0.5], &[true, true]), None);
        assert_eq!(average_precision(&[0.5, 0.5], &[false, false]), None);
    }
}
