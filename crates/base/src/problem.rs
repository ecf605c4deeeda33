//! Settings outside their range, and the checks that find them.

use std::fmt::{self, Display};

/// A value that is not allowed.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Dotted path of the key: `train.epochs`.
    pub key: String,
    /// The value given.
    pub value: String,
    /// The values that work.
    pub reason: String,
}

impl Problem {
    /// Makes a problem that prints as `key = value: reason`.
    pub fn new(key: impl Into<String>, value: impl Display, reason: impl Into<String>) -> Self {
        Problem { key: key.into(), value: value.to_string(), reason: reason.into() }
    }

    /// Puts `parent` before the key.
    pub fn below(self, parent: &str) -> Self {
        let key = if self.key.is_empty() { parent.into() } else { format!("{parent}.{}", self.key) };
        Problem { key, ..self }
    }
}

impl Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: {}", self.key, self.value, self.reason)
    }
}

/// The result of a check.
pub type Check = Result<(), Problem>;

/// Requires a whole number in `least..=most`.
///
/// # Errors
/// One outside.
pub fn within(key: &str, value: usize, least: usize, most: usize) -> Check {
    require((least..=most).contains(&value), key, value, format!("must be in {least}..={most}"))
}

/// Requires a share of the samples, in (0, 1).
///
/// # Errors
/// One outside, NaN too.
pub fn share(key: &str, value: f64) -> Check {
    require(value > 0.0 && value < 1.0, key, value, "must be a share of the samples, in (0, 1)")
}

/// Requires a condition of a value. Conditions say what must hold, so that NaN fails.
///
/// # Errors
/// A value for which it does not hold.
pub fn require(holds: bool, key: &str, value: impl Display, reason: impl Into<String>) -> Check {
    if holds { Ok(()) } else { Err(Problem::new(key, value, reason)) }
}
