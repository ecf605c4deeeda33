//! The errors of the engine.

/// A batch, label or tensor that the engine cannot take.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The graph or its weights are not usable.
    #[error(transparent)]
    Graph(#[from] taxel_graph::Error),
    /// The batch does not fit.
    #[error("{model}: {reason}")]
    Batch {
        /// Network name.
        model: String,
        /// The mismatch.
        reason: String,
    },
    /// A workspace that another evaluator made.
    #[error(
        "{model}: the workspace belongs to another evaluator; make one with this evaluator's `workspace`"
    )]
    Workspace {
        /// Network name.
        model: String,
    },
    /// The processor has no products of bf16.
    #[error("training in bf16 is not possible here: {reason}; take f32")]
    Precision {
        /// The reason.
        reason: &'static str,
    },
    /// The thread pool could not be started.
    #[error("cannot start {threads} threads: {reason}; try fewer threads")]
    Threads {
        /// Number asked for.
        threads: usize,
        /// The system's message.
        reason: String,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
