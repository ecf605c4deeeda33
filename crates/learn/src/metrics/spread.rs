//! How far from its answer a network itself expects the true value to lie.

use taxel_base::exponential;
use taxel_graph::Loss;

/// Smallest distance, so that errors can be counted in it.
const LEAST: f32 = 1e-12;

/// Returns how far below and above its answer a network expects the true values, `[n, quantities, 2]`, from rows of its
/// outputs: the standard deviation of [`Loss::GaussianLikelihood`], the outer quantiles of [`Loss::Quantiles`]. Empty for other
/// losses, which say nothing of it.
pub fn spread(loss: Loss, outputs: &[f32], quantities: usize) -> Vec<f32> {
    let rows = outputs.chunks_exact((quantities * loss.outputs_per_target()).max(1));
    let of_row = |row: &[f32]| -> Vec<f32> {
        (0..quantities).flat_map(|at| around(loss, row, quantities, at)).collect()
    };
    match loss {
        Loss::GaussianLikelihood | Loss::Quantiles => rows.flat_map(of_row).collect(),
        _ => vec![],
    }
}

/// Returns the distances below and above the answer to one quantity; 1 where the loss says nothing of it.
pub fn around(loss: Loss, row: &[f32], quantities: usize, at: usize) -> [f32; 2] {
    match loss {
        Loss::GaussianLikelihood => [exponential::exp(0.5 * row[quantities + at]).max(LEAST); 2],
        Loss::Quantiles => {
            let (lower, upper) = (row[quantities + at], row[2 * quantities + at]);
            [(row[at] - lower).max(LEAST), (upper - row[at]).max(LEAST)]
        }
        _ => [1.0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_all_answers_and_then_what_lies_around_them() {
        let gaussian = spread(Loss::GaussianLikelihood, &[5.0, 7.0, 0.0, 2.0f32.ln() * 2.0], 2);
        assert!(
            gaussian.iter().zip([1.0, 1.0, 2.0, 2.0]).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6),
            "{gaussian:?}"
        );
        assert_eq!(spread(Loss::Quantiles, &[5.0, 4.0, 8.0], 1), [1.0, 3.0]);
        // Crossed quantiles.
        assert_eq!(spread(Loss::Quantiles, &[5.0, 6.0, 5.0], 1), [LEAST, LEAST]);
        assert!(spread(Loss::Huber, &[5.0, 4.0], 2).is_empty());
    }
}
