//! Fingerprints of samples and of data sets.

use crate::dataset::labels::Labels;
use crate::dataset::targets::Targets;
use ndarray::ArrayD;
use std::borrow::Borrow;

/// First 16 bytes of the BLAKE3 hash of one recorded sample.
pub type RowHash = [u8; 16];

/// Hashes one sample, whose values need not lie in memory; -0 and 0 count as equal.
pub(crate) fn hash_row(row: impl IntoIterator<Item = impl Borrow<f32>>) -> RowHash {
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
    content(x, &[], &[], None)
}

/// Returns the BLAKE3 of samples, targets and groups.
pub(crate) fn digest(x: &ArrayD<f32>, targets: &Targets, groups: Option<&[u32]>) -> String {
    let words = |columns: &Labels| columns.values().iter().map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let columns = match targets {
        Targets::Values(values) => {
            let words = values.values().iter().map(|v| v.to_le_bytes()).collect();
            return content(x, &[], groups.unwrap_or(&[]), Some((values.quantities().len(), words)));
        }
        Targets::Classes { .. } | Targets::Levels(_) => targets.columns(),
    };
    let columns = columns.map(|columns| (columns.attributes().len(), words(columns)));
    content(x, &targets.strata(), groups.unwrap_or(&[]), columns)
}

/// Returns the BLAKE3 of the content, each part after its length; `columns` are all targets where a sample has several.
fn content(x: &ArrayD<f32>, y: &[u32], groups: &[u32], columns: Option<(usize, Vec<[u8; 4]>)>) -> String {
    let mut hasher = blake3::Hasher::new();
    let len = |hasher: &mut blake3::Hasher, n: usize| {
        hasher.update(&(n as u64).to_le_bytes());
    };
    len(&mut hasher, x.ndim());
    for axis in x.shape() {
        len(&mut hasher, *axis);
    }
    hash_words(&mut hasher, x.iter().map(|v| v.to_le_bytes()));
    len(&mut hasher, y.len());
    hash_words(&mut hasher, y.iter().map(|v| v.to_le_bytes()));
    len(&mut hasher, groups.len());
    hash_words(&mut hasher, groups.iter().map(|v| v.to_le_bytes()));
    if let Some((count, words)) = columns {
        len(&mut hasher, count);
        hash_words(&mut hasher, words.into_iter());
    }
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
