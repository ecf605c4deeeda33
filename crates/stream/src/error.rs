//! The errors of streams.

/// Why a stream cannot be predicted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option out of its range, or one that has no meaning for the model.
    #[error("{option} {value}: {why}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// The value given.
        value: String,
        /// The allowed values.
        why: String,
    },
    /// A source that cannot be opened, or that broke off.
    #[error("{source_label}: {why}")]
    Source {
        /// File, port, or standard input.
        source_label: String,
        /// The problem and how to fix it.
        why: String,
    },
    /// A file that cannot be opened.
    #[error(transparent)]
    File(#[from] taxel_base::FileError),
    /// Recordings that cannot be read.
    #[error(transparent)]
    Data(#[from] taxel_data::Error),
    /// Samples that the model refuses.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
