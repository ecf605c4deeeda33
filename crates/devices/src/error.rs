//! The errors of a device.

/// A graph that cannot run on a device.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The graph or its weights are not usable.
    #[error(transparent)]
    Graph(#[from] taxel_graph::Error),
    /// candle refused an operation.
    #[error("{node}: {source}")]
    Node {
        /// Node name.
        node: String,
        /// candle's error.
        source: candle_core::Error,
    },
    /// The batch does not fit.
    #[error("{model}: {reason}")]
    Batch {
        /// Network name.
        model: String,
        /// The mismatch.
        reason: String,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
