//! The one error type of shrinking.

use std::path::Path;

use taxel_base::FileError;

/// A run that cannot be shrunk.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The run's experiment or data.
    #[error(transparent)]
    Trainer(#[from] taxel_trainer::Error),
    /// A training, a run folder or a model.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
    /// The page cannot be drawn or written.
    #[error(transparent)]
    Report(#[from] taxel_report::Error),
    /// Statistics.
    #[error(transparent)]
    Judge(#[from] taxel_judge::Error),
    /// A value that does not do.
    #[error("{key} = {value}: {reason}")]
    Value {
        /// The option.
        key: &'static str,
        /// The value given.
        value: String,
        /// Allowed values, or how to fix it.
        reason: String,
    },
    /// A file or folder.
    #[error(transparent)]
    File(#[from] FileError),
    /// It was stopped from outside; finished trainings are kept.
    #[error("{folder}: stopped; finished trainings are kept")]
    Stopped {
        /// Where they are.
        folder: String,
    },
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    pub(crate) fn file(path: &Path, reason: impl ToString) -> Self {
        FileError::new(path, reason.to_string()).into()
    }

    pub(crate) fn value(key: &'static str, value: impl ToString, reason: impl Into<String>) -> Self {
        Error::Value { key, value: value.to_string(), reason: reason.into() }
    }

    /// Checks whether it says that one setting cannot be trained, and others may.
    pub(crate) fn is_of_setting(&self) -> bool {
        use taxel_learn::Error as Learn;
        let learn = |error: &Learn| {
            error.is_divergence()
                || matches!(
                    error,
                    Learn::Setting(_) | Learn::Input { .. } | Learn::Axes { .. } | Learn::Encoding { .. }
                )
        };
        match self {
            Error::Learn(error) | Error::Trainer(taxel_trainer::Error::Learn(error)) => learn(error),
            Error::Trainer(error) => matches!(
                error,
                taxel_trainer::Error::Zoo(_)
                    | taxel_trainer::Error::Value { .. }
                    | taxel_trainer::Error::Unfit { .. }
            ),
            _ => false,
        }
    }
}
