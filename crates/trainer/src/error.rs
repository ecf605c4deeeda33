//! The one error type of the trainer.

use std::path::Path;

use taxel_base::FileError;

/// An experiment that cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that cannot be read, or holds no network.
    #[error(transparent)]
    File(#[from] FileError),
    /// A config that is not valid TOML, or has an unknown key or a value of the wrong type.
    #[error("{place}: {message}{line}")]
    Config {
        /// `file:line:column`, or `--set key=value`.
        place: String,
        /// The mistake and how to fix it.
        message: String,
        /// The line itself on a line of its own, or nothing.
        line: String,
    },
    /// A config value outside its range.
    #[error("{place}: {key} = {value}: {reason}")]
    Value {
        /// `file:line`, or `--set`, or the file alone where the default is meant.
        place: String,
        /// Dotted path of the key.
        key: String,
        /// The value given.
        value: String,
        /// The allowed values.
        reason: String,
    },
    /// An experiment's data cannot be loaded.
    #[error(transparent)]
    Data(Box<taxel_data::Error>),
    /// An experiment's scene cannot be simulated.
    #[error(transparent)]
    Scene(#[from] taxel_scenes::Error),
    /// A network cannot be built for these samples.
    #[error(transparent)]
    Zoo(Box<taxel_zoo::Error>),
    /// No network takes such samples.
    #[error("{reason}")]
    Unfit {
        /// Reason of the first of them, and how to fix it.
        reason: String,
    },
    /// A training, a run folder or a model.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
    /// An ONNX file that no network can be made of.
    #[error(transparent)]
    Onnx(#[from] taxel_onnx::Error),
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl From<taxel_zoo::Error> for Error {
    fn from(error: taxel_zoo::Error) -> Self {
        Error::Zoo(Box::new(error))
    }
}

impl From<taxel_data::Error> for Error {
    fn from(error: taxel_data::Error) -> Self {
        Error::Data(Box::new(error))
    }
}

impl Error {
    pub(crate) fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        FileError::io(path, action, &source).into()
    }

    pub(crate) fn config(place: impl Into<String>, message: impl Into<String>) -> Self {
        Error::Config { place: place.into(), message: message.into(), line: String::new() }
    }
}
