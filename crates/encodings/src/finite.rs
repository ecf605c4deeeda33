//! Readings that are numbers.

use ndarray::{ArrayView, Dimension};

use crate::{Error, Result};

/// Checks whether all readings are numbers; no branch, so that the loop is as fast as memory.
pub(crate) fn all_finite(x: &[f32]) -> bool {
    x.iter().fold(true, |finite, v| finite & v.is_finite())
}

/// Refuses readings that are none; `place` names one by its index.
pub(crate) fn check_finite(x: &[f32], place: impl FnOnce(usize) -> String) -> Result<()> {
    if all_finite(x) {
        return Ok(());
    }
    match x.iter().position(|v| !v.is_finite()) {
        Some(at) => Err(Error::NonFinite { place: place(at), value: x[at] }),
        None => Ok(()),
    }
}

/// Says where a reading is: `reading [2, 0, 5]` of a recording with three axes.
pub(crate) fn place([_, b, c]: [usize; 3], at: usize) -> String {
    format!("reading [{}, {}, {}]", at / (b * c), at / c % b, at % c)
}

/// Returns the values of an array, row-major: borrowed where they lie so.
pub(crate) fn values<'a, D: Dimension>(x: &'a ArrayView<'a, f32, D>) -> std::borrow::Cow<'a, [f32]> {
    match x.as_slice() {
        Some(values) => values.into(),
        None => x.iter().copied().collect::<Vec<f32>>().into(),
    }
}
