//! Scores as shares.

use taxel_base::exponential;

/// Takes the softmax over each row of `classes` values, in place: the same bits on every processor.
pub fn softmax(values: &mut [f32], classes: usize) {
    values.chunks_exact_mut(classes.max(1)).for_each(exponential::softmax);
}
