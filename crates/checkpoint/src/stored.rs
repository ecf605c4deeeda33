//! Tensors with the types that they have in a file.

use taxel_graph::Tensor;

/// A tensor with the type that it has in a file.
pub(crate) enum StoredTensor {
    Floats(Tensor),
    /// Values that are bf16 already.
    Halves(Tensor),
    /// Whole numbers from -127 to 127.
    Bytes(Tensor),
}

impl StoredTensor {
    /// Returns shape and values, whatever the type.
    pub fn tensor(&self) -> &Tensor {
        let (StoredTensor::Floats(tensor) | StoredTensor::Halves(tensor) | StoredTensor::Bytes(tensor)) =
            self;
        tensor
    }
}
