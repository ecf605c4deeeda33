//! A setting outside its range, and the checks that find one.

use std::fmt::{self, Display};

/// A value that does not do.
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
    /// `key = value: reason`.
    pub fn new(key: impl Into<String>, value: impl Display, reason: impl Into<String>) -> Self {
        Problem { key: key.into(), value: value.to_string(), reason: reason.into() }
    }

    /// The same with `parent` before the key.
    pub fn below(self, parent: &str) -> Self {
        match self.key.is_empty() {
            true => Problem { key: parent.into(), ..self },
            false => Problem { key: format!("{parent}.{}", self.key), ..self },
        }
    }
}

impl Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: {}", self.key, self.value, self.reason)
    }
}

/// What a check ends with.
pub type Check = Result<(), Problem>;

/// A whole number in `least..=most`.
///
/// # Errors
/// One outside.
pub fn within(key: &str, value: usize, least: usize, most: usize) -> Check {
    require((least..=most).contains(&value), key, value, format!("must be in {least}..={most}"))
}

/// A share of the samples, in (0, 1).
///
/// # Errors
/// One outside, NaN too.
pub fn share(key: &str, value: f64) -> Check {
    require(value > 0.0 && value < 1.0, key, value, "must be a share of the samples, in (0, 1)")
}

/// Whatever else must hold of a value. Written as "holds", so that NaN fails.
///
/// # Errors
/// What does not hold.
pub fn require(holds: bool, key: &str, value: impl Display, reason: impl Into<String>) -> Check {
    match holds {
        true => Ok(()),
        false => Err(Problem::new(key, value, reason)),
    }
}
