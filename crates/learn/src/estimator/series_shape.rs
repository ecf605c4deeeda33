//! The shape in which baselines read encoded series.

use taxel_baselines::Method;
use taxel_data::Layout;

use crate::encoding::{Encoded, SERIES};
use crate::error::{Error, Result};

/// Returns the shape that a method reads series of `shape` in. A row of features is one channel of as many steps to all but trees:
/// these ask each feature by itself, and its differences to others would hide it.
pub(super) fn read_as(method: &Method, layout: Layout, [channels, length]: [usize; 2]) -> [usize; 2] {
    match (method, layout) {
        (Method::ExtraTrees { .. }, Layout::Features) => [channels * length, 1],
        _ => [channels, length],
    }
}

/// Returns channels and length of encoded series.
pub(super) fn shape_of(series: &Encoded) -> Result<[usize; 2]> {
    match *series.shape() {
        [channels, length] => Ok([channels, length]),
        ref shape => Err(Error::Axes {
            source_label: "readings".into(),
            input: SERIES,
            shape: shape.to_vec(),
            reason: "baselines read channels × time",
        }),
    }
}
