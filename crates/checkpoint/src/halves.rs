//! Tensors in bf16: the upper half of a float, 8 bits of mantissa.

use half::bf16;
use taxel_graph::{Tensor, Weights};

use crate::stored::StoredTensor;

/// Returns `tensor` as it comes back from bf16: each value the nearest (even among equals).
pub fn halved(tensor: &Tensor) -> Tensor {
    let data = tensor.data.iter().map(|value| bf16::from_f32(*value).to_f32());
    Tensor { shape: tensor.shape.clone(), data: data.collect() }
}

/// Returns the named tensors in bf16, the others as they are.
pub(crate) fn apart(weights: &Weights, names: &[&str]) -> Vec<(String, StoredTensor)> {
    let stored = |(name, tensor): (&str, &Tensor)| {
        let is_named = names.contains(&name);
        let stored = if is_named { StoredTensor::Halves } else { StoredTensor::Floats };
        (name.to_string(), stored(tensor.clone()))
    };
    weights.iter().map(stored).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::safetensors::{from_bytes, to_bytes_of};

    #[test]
    fn what_is_rounded_once_stays_and_comes_back() {
        let data: Vec<f32> = (0..40).map(|i| ((i * 7919 % 2003) as f32 - 1001.0) * 1.7e-3).collect();
        let tensor = Tensor { shape: vec![4, 5, 2], data };
        let once = halved(&tensor);
        assert_ne!(once, tensor);
        assert_eq!(halved(&once), once);
        assert!(tensor.data.iter().zip(&once.data).all(|(a, b)| (a - b).abs() <= a.abs() / 256.0));
        let mut weights = Weights::new();
        weights.insert("conv.bias", Tensor { shape: vec![4], data: vec![0.1; 4] });
        weights.insert("conv.weight", once);
        let bytes = to_bytes_of(&apart(&weights, &["conv.weight"]), "half").unwrap();
        let (read, text) = from_bytes(&bytes).unwrap();
        assert_eq!((read, text.as_deref()), (weights.clone(), Some("half")));
        // Two bytes of each of 40 values less, and what is odd in the header.
        let plain = to_bytes_of(&apart(&weights, &[]), "half").unwrap();
        assert!((72..=88).contains(&(plain.len() - bytes.len())), "{} and {}", plain.len(), bytes.len());
    }
}
