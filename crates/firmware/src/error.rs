//! The error of this crate.

/// A network that cannot become C, or a folder that cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A network that has no C of the same bits.
    #[error("{model}: cannot be exported as C: {reason}")]
    Refused {
        /// Name of the model.
        model: String,
        /// Operation, layer and numbers, and how to fix it.
        reason: String,
    },
    /// The folder.
    #[error("{path}: {reason}")]
    Folder {
        /// Where it should be.
        path: String,
        /// Why it cannot be there.
        reason: String,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
