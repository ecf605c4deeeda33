//! Fingerprints of samples and of data sets.

use crate::dataset::targets::Targets;
use ndarray::ArrayD;
use std::borrow::Borrow;

/// First 16 bytes of the BLAKE3 hash of one sample, as it is trained on.
pub type RowHash = [u8; 16];

/// Hashes one sample, whose values need not lie in memory; -0 and 0 count as equal.
pub fn hash_row(row: impl IntoIterator<Item = impl Borrow<f32>>) -> RowHash {
    let mut hasher = blake3::Hasher::new();
    hash_words(&mut hasher, row.into_iter().map(|value| (*value.borrow() + 0.0).to_le_bytes()));
    let mut hash = [0; 16];
    hash.copy_from_slice(&hasher.finalize().as_bytes()[..16]);
    hash
}

/// Hashes each sample of `x` `[N, ..]`, which is in C order and has no empty axis.
pub(crate) fn hash_rows(x: &ArrayD<f32>) -> Vec<RowHash> {
    #[expect(clippy::expect_used, reason = "readers give C order")]
    let values = x.as_slice().expect("C order");
    values.chunks_exact(values.len() / x.shape()[0]).map(hash_row).collect()
}

/// Returns the BLAKE3 of samples that no data set holds.
pub fn digest_of(x: &ArrayD<f32>) -> String {
    digest(x, None, None)
}

/// Returns the BLAKE3 of samples, targets and groups, each part after its length. Classes come before the groups, values
/// and what else a sample has of targets after them.
pub(crate) fn digest(x: &ArrayD<f32>, targets: Option<&Targets>, groups: Option<&[u32]>) -> String {
    let mut hasher = blake3::Hasher::new();
    let len = |hasher: &mut blake3::Hasher, n: usize| {
        hasher.update(&(n as u64).to_le_bytes());
    };
    let numbers = |hasher: &mut blake3::Hasher, numbers: &[u32]| {
        len(hasher, numbers.len());
        hash_words(hasher, numbers.iter().map(|v| v.to_le_bytes()));
    };
    len(&mut hasher, x.ndim());
    x.shape().iter().for_each(|axis| len(&mut hasher, *axis));
    hash_words(&mut hasher, x.iter().map(|v| v.to_le_bytes()));
    let classes = targets.filter(|targets| !matches!(targets, Targets::Values(_))).map(Targets::strata);
    numbers(&mut hasher, &classes.unwrap_or_default());
    numbers(&mut hasher, groups.unwrap_or_default());
    if let Some(Targets::Values(values)) = targets {
        len(&mut hasher, values.quantities().len());
        hash_words(&mut hasher, values.values().iter().map(|v| v.to_le_bytes()));
    } else if let Some(columns) = targets.and_then(Targets::columns) {
        len(&mut hasher, columns.attributes().len());
        hash_words(&mut hasher, columns.values().iter().map(|v| v.to_le_bytes()));
    }
    hasher.finalize().to_hex().to_string()
}

/// Returns the BLAKE3 of a digest and the weights of the samples.
pub(crate) fn with_weights(digest: &str, weights: &[f32]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(digest.as_bytes());
    hash_words(&mut hasher, weights.iter().map(|weight| weight.to_le_bytes()));
    hasher.finalize().to_hex().to_string()
}

/// Feeds four-byte words to the hasher in large pieces: many small ones are slow.
pub fn hash_words(hasher: &mut blake3::Hasher, words: impl Iterator<Item = [u8; 4]>) {
    let mut buffer = [0; 1 << 14];
    let mut used = 0;
    for word in words {
        buffer[used..used + 4].copy_from_slice(&word);
        used += 4;
        if used == buffer.len() {
            hasher.update(&buffer);
            used = 0;
        }
    }
    hasher.update(&buffer[..used]);
}
