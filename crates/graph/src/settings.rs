//! A network family's settings: serde reads them, their ranges are checked here, a graph comes out.

use std::fmt::Display;
use std::ops::RangeInclusive;

use crate::error::{Error, Result};
use crate::graph::Graph;

/// The largest size that [`at_least`] lets pass: more would only fail later, when memory runs out.
const MOST: usize = 65_536;

/// A network family's configuration: checked values that become a [`Graph`].
///
/// Every family has one shape. A struct that serde reads and writes, whose `Default` holds a paper's values;
/// what is no setting, such as which network of the family it is, is a field that serde skips.
pub trait Architecture: Sized {
    /// Takes `settings` for this network: whatever serde skips stays as it is here.
    fn with(&self, settings: Self) -> Self {
        settings
    }

    /// Makes the graph.
    ///
    /// # Errors
    /// Which value is out of range, or which node does not fit.
    fn graph(&self) -> Result<Graph>;
}

/// Refuses a setting `key` outside `range`.
///
/// # Errors
/// `key = value: must be in low..=high`.
pub fn within<T: PartialOrd + Display>(key: &str, value: T, range: RangeInclusive<T>) -> Result<()> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(Error::config(key, value, &format!("must be in {}..={}", range.start(), range.end())))
}

/// Refuses sizes below their least or above 65536: (key, value, least).
///
/// # Errors
/// `key = value: must be in least..=65536`, of the first.
pub fn at_least(sizes: &[(&str, usize, usize)]) -> Result<()> {
    sizes.iter().try_for_each(|&(key, value, least)| within(key, value, least..=MOST))
}

/// Refuses a share `key` that is not in 0..1, such as that of dropped values.
///
/// # Errors
/// `key = value: must be at least 0 and below 1`.
pub fn share(key: &str, value: f32) -> Result<()> {
    if (0.0..1.0).contains(&value) {
        return Ok(());
    }
    Err(Error::config(key, value, "must be at least 0 and below 1"))
}

/// Refuses what cannot multiply the channels of a network.
///
/// # Errors
/// `width_mult = value: must be above 0 and at most 4`.
pub fn check_width_mult(value: f64) -> Result<()> {
    if value > 0.0 && value <= 4.0 {
        return Ok(());
    }
    Err(Error::config("width_mult", value, "must be above 0 and at most 4"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_both_ends_and_refusals_name_the_key() {
        let text = |result: Result<()>| result.unwrap_err().to_string();
        assert!(within("pool", 1, 1..=4).is_ok() && within("pool", 4, 1..=4).is_ok());
        assert_eq!(text(within("pool", 5, 1..=4)), "pool = 5: must be in 1..=4");
        assert!(at_least(&[("classes", 2, 2), ("height", 65_536, 21)]).is_ok());
        assert_eq!(
            text(at_least(&[("height", 1, 1), ("classes", 1, 2)])),
            "classes = 1: must be in 2..=65536"
        );
        assert_eq!(text(at_least(&[("height", 65_537, 1)])), "height = 65537: must be in 1..=65536");
        assert!(share("dropout", 0.0).is_ok() && share("dropout", 0.999).is_ok());
        for value in [1.0, -0.1, f32::NAN] {
            let want = format!("dropout = {value}: must be at least 0 and below 1");
            assert_eq!(text(share("dropout", value)), want);
        }
    }
}
