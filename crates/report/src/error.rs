//! The error type of reports.

use std::path::Path;

/// A picture that cannot be drawn, or a file of a report that cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A picture whose values are not those of its shape.
    #[error("picture `{name}`: {reason}; measure the judgement again")]
    Picture {
        /// Name of the picture.
        name: String,
        /// The reason.
        reason: String,
    },
    /// A file that cannot be written.
    #[error("{path}: cannot be written: {reason}")]
    Write {
        /// The file.
        path: String,
        /// Message of the system.
        reason: String,
    },
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Returns the error of a file that cannot be written.
    pub fn write(path: &Path, reason: impl ToString) -> Self {
        Error::Write { path: path.display().to_string(), reason: reason.to_string() }
    }
}
