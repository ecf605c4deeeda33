//! The digest of a model's tensors.

use taxel_data::hash_words;
use taxel_graph::Weights;

/// Computes the BLAKE3 of all tensors in order of their names.
pub(crate) fn digest(weights: &Weights) -> String {
    let mut named: Vec<_> = weights.iter().collect();
    named.sort_by_key(|(name, _)| *name);
    let mut hasher = blake3::Hasher::new();
    for (name, tensor) in named {
        hasher.update(&(name.len() as u64).to_le_bytes()).update(name.as_bytes());
        hasher.update(&(tensor.shape.len() as u64).to_le_bytes());
        tensor.shape.iter().for_each(|axis| {
            hasher.update(&(*axis as u64).to_le_bytes());
        });
        hash_words(&mut hasher, tensor.data.iter().map(|v| v.to_le_bytes()));
    }
    hasher.finalize().to_hex().to_string()
}
