//! Shapes and the names of their axes.
//!
//! Shapes leave the batch axis out. Axes are PyTorch's and the papers': features; channels × length;
//! channels × rows × columns; channels × rows × columns × frames. How a backend lays them out in
//! memory is its own business.

use crate::error::{Error, Result};

/// The most values of one sample's output or of one tensor: 8 GiB in f32. No product of sizes that passed
/// [`check_count`] overflows.
const MOST_VALUES: usize = 1 << 31;

/// Returns the names of the axes of a shape of `rank`, batch left out.
pub fn axis_names(rank: usize) -> &'static [&'static str] {
    match rank {
        1 => &["features"],
        2 => &["channels", "length"],
        3 => &["channels", "rows", "columns"],
        4 => &["channels", "rows", "columns", "frames"],
        _ => &[],
    }
}

/// Describes a shape with its axis names: `channels 3 × rows 50 × columns 50`.
pub fn describe(shape: &[usize]) -> String {
    let names = axis_names(shape.len());
    if names.is_empty() {
        return format!("{shape:?}");
    }
    let axes: Vec<String> = names.iter().zip(shape).map(|(n, s)| format!("{n} {s}")).collect();
    axes.join(" × ")
}

/// Refuses a `what` of `shape` that has too many values to be built.
pub(crate) fn check_count(node: &str, what: &str, shape: &[usize]) -> Result<()> {
    let count = shape.iter().try_fold(1usize, |count, &size| count.checked_mul(size));
    match count {
        Some(count) if count <= MOST_VALUES => Ok(()),
        _ => Err(Error::node(
            node,
            format!("{what} of {} has more than {MOST_VALUES} values", describe(shape)),
        )),
    }
}
