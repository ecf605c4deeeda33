//! What may be wrong with a stream.

/// Why a stream cannot be answered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option out of its range, or one that has no meaning for the model.
    #[error("{option} {value}: {why}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// What was given.
        value: String,
        /// What it may be.
        why: String,
    },
    /// A source that cannot be opened, or that broke off.
    #[error("{source_label}: {why}")]
    Source {
        /// File, port, or standard input.
        source_label: String,
        /// What is wrong, and the way out.
        why: String,
    },
    /// Recordings that cannot be read.
    #[error(transparent)]
    Data(#[from] taxel_data::Error),
    /// What the model refuses.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
