//! A value of a config that could not be read.

use std::fmt::{self, Display};

use serde::de;
use taxel_base::names::unknown;

/// A value that could not be read, with its key. As the error of a [`Deserializer`](serde::Deserializer) it keeps an unknown
/// key as a value, so that nobody has to find it in a message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Misread {
    /// Dotted path of the key.
    pub key: String,
    /// The mistake and the values that would do.
    pub message: String,
    /// The key that no setting has, where that is the mistake.
    pub unknown: Option<String>,
    /// The keys that would do in its place.
    pub expected: Vec<&'static str>,
}

impl Misread {
    /// Makes an error of a value at `key`.
    pub fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Misread { key: key.into(), message: message.into(), unknown: None, expected: vec![] }
    }

    /// Makes an error of a key that has another name now.
    pub fn renamed(old: &str, new: &str) -> Self {
        let message = format!("unknown field `{old}`: it is called `{new}` now");
        Misread { unknown: Some(old.into()), ..Misread::new(old, message) }
    }

    /// Returns the same, seen from the table or array that holds the value under `parent`.
    pub fn below(self, parent: &str) -> Self {
        Misread { key: joined(parent, &self.key), ..self }
    }
}

/// Joins two parts of a dotted key, either of which may be empty.
pub(crate) fn joined(parent: &str, key: &str) -> String {
    match (parent, key) {
        ("", key) => key.into(),
        (parent, "") => parent.into(),
        (parent, key) => format!("{parent}.{key}"),
    }
}

impl de::Error for Misread {
    fn custom<T: Display>(message: T) -> Self {
        Misread::new("", message.to_string().trim().replace('\n', "; "))
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let message = unknown("field", field, expected);
        Misread { unknown: Some(field.into()), expected: expected.to_vec(), ..Misread::new("", message) }
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        Misread::new("", unknown("variant", variant, expected))
    }

    fn invalid_type(found: de::Unexpected, expected: &dyn de::Expected) -> Self {
        // Names of this program's types say nothing to a user: what is expected in their place is a table.
        let mut expected = expected.to_string();
        if ["internally tagged enum ", "struct "].iter().any(|start| expected.starts_with(start)) {
            expected = "a table".into();
        }
        Misread::new("", format!("invalid type: {found}, expected {expected}"))
    }
}

impl Display for Misread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Misread {}
