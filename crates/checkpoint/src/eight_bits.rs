//! Tensors in eight bits: signed bytes symmetric around 0, and one scale per output (first axis).
//!
//! In a file a tensor `w` is of type I8, and `w.scale` beside it holds the scales.

use taxel_graph::{Tensor, Weights};

use crate::stored::StoredTensor;

/// The end of the name of a tensor's scales.
pub(crate) const SCALE: &str = ".scale";
/// Largest whole number.
const MOST: f32 = 127.0;
/// Bits that a scale does without, so that its products with whole numbers are exact: a tensor that was rounded once
/// stays as it is.
const SPARE: u32 = 0x7f;

/// Returns `tensor` as it comes back from eight bits.
pub fn rounded(tensor: &Tensor) -> Tensor {
    let (whole, scales) = apart_one(tensor);
    let data = together(&whole.iter().map(|w| *w as i8).collect::<Vec<_>>(), &scales);
    Tensor { shape: tensor.shape.clone(), data }
}

/// Returns the named tensors as whole numbers, each followed by its scales; the others as they are.
pub(crate) fn apart(weights: &Weights, names: &[&str]) -> Vec<(String, StoredTensor)> {
    let mut stored = vec![];
    for (name, tensor) in weights.iter() {
        if !names.contains(&name) {
            stored.push((name.to_string(), StoredTensor::Floats(tensor.clone())));
            continue;
        }
        let (data, scales) = apart_one(tensor);
        let shape = vec![scales.len()];
        stored.push((name.to_string(), StoredTensor::Bytes(Tensor { shape: tensor.shape.clone(), data })));
        stored.push((format!("{name}{SCALE}"), StoredTensor::Floats(Tensor { shape, data: scales })));
    }
    stored
}

/// Returns the whole numbers, and the scale of each output.
fn apart_one(tensor: &Tensor) -> (Vec<f32>, Vec<f32>) {
    let outputs = tensor.shape.first().copied().unwrap_or(1).max(1);
    let each = (tensor.data.len() / outputs).max(1);
    let scale = |row: &[f32]| {
        let scale = row.iter().fold(0f32, |most, w| most.max(w.abs())) / MOST;
        // Upwards, so that nothing is cut off.
        let scale = f32::from_bits(scale.to_bits().saturating_add(SPARE) & !SPARE);
        if scale.is_normal() { scale } else { 1.0 }
    };
    let scales: Vec<f32> = tensor.data.chunks(each).map(scale).collect();
    let rows = tensor.data.chunks(each).zip(&scales);
    let whole = rows.flat_map(|(row, scale)| row.iter().map(move |w| (w / scale).round_ties_even()));
    (whole.collect(), scales)
}

/// Returns the values of whole numbers.
pub(crate) fn together(whole: &[i8], scales: &[f32]) -> Vec<f32> {
    let each = (whole.len() / scales.len().max(1)).max(1);
    let rows = whole.chunks(each).zip(scales);
    rows.flat_map(|(row, scale)| row.iter().map(move |w| f32::from(*w) * scale)).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::safetensors::{from_bytes, to_bytes_of};

    #[test]
    fn what_is_rounded_once_stays_and_comes_back() {
        let value = |i: usize| ((i * 7919 % 2003) as f32 - 1001.0) * 1.7e-3 * (1.0 + (i / 10) as f32);
        let mut data: Vec<f32> = (0..40).map(value).collect();
        data[30..].fill(0.0);
        let tensor = Tensor { shape: vec![4, 5, 2], data };
        let once = rounded(&tensor);
        assert_ne!(once, tensor);
        assert_eq!(rounded(&once), once);
        for (before, after) in tensor.data.chunks(10).zip(once.data.chunks(10)) {
            let most = before.iter().fold(0f32, |most, w| most.max(w.abs()));
            assert!(before.iter().zip(after).all(|(a, b)| (a - b).abs() <= 0.501 * most / 127.0));
        }
        let mut weights = Weights::new();
        weights.insert("conv.weight", once);
        weights.insert("conv.bias", Tensor { shape: vec![4], data: vec![0.1; 4] });
        let bytes = to_bytes_of(&apart(&weights, &["conv.weight"]), "eight").unwrap();
        let (read, text) = from_bytes(&bytes).unwrap();
        assert_eq!(text.as_deref(), Some("eight"));
        assert_eq!(read.len(), 2);
        weights.iter().for_each(|(name, tensor)| assert_eq!(read.get(name), Some(tensor), "{name}"));
        // 40 bytes in place of 160.
        let plain = to_bytes_of(&apart(&weights, &[]), "eight").unwrap();
        assert!(bytes.len() < plain.len(), "{} and {}", bytes.len(), plain.len());
    }
}
