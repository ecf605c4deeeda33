//! How sure answers are, and whether they are right.

use crate::metrics::Levels;

/// Returns the probability of the answer to each attribute of each sample, 0..1, and whether it is right. `probabilities` are
/// `[n, outputs]`, the labels `truth` `[n, attributes]`.
pub fn answers(probabilities: &[f32], truth: &[u32], levels: &Levels) -> Vec<Vec<(f64, bool)>> {
    let predicted = levels.predicted(probabilities);
    let width = levels.sizes().len().max(1);
    let rows = probabilities.chunks_exact(levels.outputs().max(1));
    let labels = predicted.chunks_exact(width).zip(truth.chunks_exact(width));
    let of_row = |(mut row, (predicted, truth)): (&[f32], (&[u32], &[u32]))| {
        let mut all = vec![];
        for ((size, answer), label) in levels.sizes().iter().zip(predicted).zip(truth) {
            let (of_attribute, rest) = row.split_at(*size);
            all.push((f64::from(of_attribute[*answer as usize]), answer == label));
            row = rest;
        }
        all
    };
    rows.zip(labels).map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_attribute_has_an_answer_of_its_own() {
        let probabilities = [0.25, 0.75, 0.5, 0.25, 0.25, 0.5, 0.5, 0.125, 0.125, 0.75];
        let found = answers(&probabilities, &[1, 2, 1, 2], &Levels::new(&[2, 3]));
        assert_eq!(found, [[(0.75, true), (0.5, false)], [(0.5, false), (0.75, true)]]);
    }
}
