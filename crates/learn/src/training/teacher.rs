//! The predictions of a better network, which a network learns from beside its labels (distillation).
//!
//! # Reference
//!
//! Hinton, Vinyals, Dean, "Distilling the Knowledge in a Neural Network", 2015, at temperature 1.

/// The predictions of a better method for training samples, which it must not have learned from itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Teacher {
    /// How much its predictions count beside the labels, [0, 1].
    share: f32,
    outputs: usize,
    /// Probabilities of each sample of the data set, `[samples, outputs]`; NaN where it has predicted nothing.
    predictions: Vec<f32>,
}

impl Teacher {
    /// Makes a teacher without predictions yet, for `samples` samples.
    ///
    /// # Panics
    /// For a share outside [0, 1].
    pub fn new(share: f32, samples: usize, outputs: usize) -> Self {
        assert!((0.0..=1.0).contains(&share), "a share of the targets");
        Teacher { share, outputs, predictions: vec![f32::NAN; samples * outputs] }
    }

    /// Takes its predictions for `rows`: probabilities `[rows, outputs]`.
    ///
    /// # Panics
    /// For a row that the data set has not, or another number of probabilities.
    pub fn tell(&mut self, rows: &[usize], probabilities: &[f32]) {
        assert_eq!(rows.len() * self.outputs, probabilities.len(), "one probability per output");
        for (&row, given) in rows.iter().zip(probabilities.chunks_exact(self.outputs)) {
            self.predictions[row * self.outputs..][..self.outputs].copy_from_slice(given);
        }
    }

    /// Puts its predictions for `rows` into their targets, as far as its share goes; a sample that it has not
    /// predicted keeps its target.
    pub(crate) fn teach(&self, rows: &[usize], targets: &mut [f32]) {
        for (&row, targets) in rows.iter().zip(targets.chunks_exact_mut(self.outputs)) {
            let predictions = &self.predictions[row * self.outputs..][..self.outputs];
            if predictions.iter().all(|value| value.is_finite()) {
                let both = targets.iter_mut().zip(predictions);
                both.for_each(|(to, predicted)| *to = (1.0 - self.share) * *to + self.share * predicted);
            }
        }
    }

    /// Computes the digest of all that it says.
    pub fn digest(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.share.to_le_bytes());
        self.predictions.iter().for_each(|value| {
            hasher.update(&value.to_le_bytes());
        });
        hasher.finalize().to_hex().to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn predictions_count_as_much_as_their_share() {
        let mut teacher = Teacher::new(0.25, 3, 2);
        teacher.tell(&[2, 0], &[0.8, 0.2, 0.5, 0.5]);
        let mut targets = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
        teacher.teach(&[0, 1, 2], &mut targets);
        let wanted = [0.875, 0.125, 0.0, 1.0, 0.2, 0.8];
        assert!(targets.iter().zip(wanted).all(|(got, want)| (got - want).abs() < 1e-6), "{targets:?}");
        let other = Teacher::new(0.25, 3, 2);
        assert_ne!(teacher.digest(), other.digest());
    }
}
