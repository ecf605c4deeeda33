//! Values that a statistic can be computed of.

use crate::error::{Error, Result};

/// Returns an error about the values of a statistic.
pub(super) fn refuse<T>(what: &'static str, reason: impl Into<String>) -> Result<T> {
    Err(Error::Statistics { what, reason: reason.into() })
}

/// Checks that every value is finite, and that there are at least `least`.
pub(super) fn check(what: &'static str, values: &[f64], least: usize) -> Result<()> {
    if values.len() < least {
        return refuse(what, format!("{} values; at least {least} are needed", values.len()));
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(at) => refuse(what, format!("value {at} is {}", values[at])),
        None => Ok(()),
    }
}

/// Checks that a share lies between 0 and 1, both excluded.
pub(super) fn check_share(what: &'static str, share: f64) -> Result<()> {
    if share > 0.0 && share < 1.0 { Ok(()) } else { refuse(what, format!("{share} is not in (0, 1)")) }
}
