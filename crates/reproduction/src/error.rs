//! The error type of the study.

use std::path::Path;

/// A run or a page that the study cannot use.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A run, its data or its judgement.
    #[error(transparent)]
    Taxel(#[from] taxel::Error),
    /// Statistics of a run.
    #[error(transparent)]
    Judge(#[from] taxel::judge::Error),
    /// A page of tables that cannot be written.
    #[error(transparent)]
    Report(#[from] taxel::report::Error),
    /// A file that cannot be read or written, or does not say what it should.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// The reason, and how to fix it.
        reason: String,
    },
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    pub(crate) fn file(path: &Path, reason: impl ToString) -> Self {
        Error::File { file: path.display().to_string(), reason: reason.to_string() }
    }
}
