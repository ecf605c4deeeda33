//! The one error type of sweeps.

use std::path::Path;

use taxel_base::FileError;

/// A sweep that cannot be planned, run, collected or handed to a scheduler.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or folder cannot be read or written, or does not say what it should.
    #[error(transparent)]
    File(#[from] FileError),
    /// A value outside its range.
    #[error("{key} = {value}: {reason}")]
    Value {
        /// Name of the value.
        key: &'static str,
        /// The value given.
        value: String,
        /// The allowed values.
        reason: String,
    },
    /// A trial's config cannot be used.
    #[error(transparent)]
    Experiment(#[from] taxel_trainer::Error),
    /// A run folder cannot be read or put together.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
    /// The page cannot be drawn or written.
    #[error(transparent)]
    Report(#[from] taxel_report::Error),
    /// Networks cannot be ranked.
    #[error(transparent)]
    Judge(#[from] taxel_judge::Error),
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    pub(crate) fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        FileError::io(path, action, &source).into()
    }

    pub(crate) fn file(path: &Path, reason: impl Into<String>) -> Self {
        FileError::new(path, reason).into()
    }
}
