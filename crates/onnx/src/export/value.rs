//! Descriptions of inputs and outputs.

use crate::proto::{Dimension, Shape, TensorType, Type, ValueInfo, dtype};

/// Describes a value of any number of samples.
pub(super) fn info(name: &str, shape: &[usize], what: Option<&str>) -> ValueInfo {
    let batch = Dimension { size: None, name: Some("batch".into()) };
    let sizes = shape.iter().map(|&size| Dimension { size: Some(size as i64), name: None });
    let dims = std::iter::once(batch).chain(sizes).collect();
    let tensor = TensorType { dtype: Some(dtype::FLOAT), shape: Some(Shape { dims }) };
    ValueInfo {
        name: Some(name.into()),
        kind: Some(Type { tensor: Some(tensor) }),
        doc: what.map(String::from),
    }
}
