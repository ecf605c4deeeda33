//! What a device or a checkpoint refuses.

use std::path::PathBuf;

/// A graph that cannot run on a device, or a checkpoint that cannot be used.
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
        /// What candle says.
        source: candle_core::Error,
    },
    /// The batch does not fit.
    #[error("{model}: {reason}")]
    Batch {
        /// Network name.
        model: String,
        /// What does not fit.
        reason: String,
    },
    /// A checkpoint cannot be read or written.
    #[error("{}: {reason}", path.display())]
    Checkpoint {
        /// File.
        path: PathBuf,
        /// What is wrong, and the way out.
        reason: String,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
