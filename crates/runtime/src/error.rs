//! The errors of the runtime.

/// A network or an input that the runtime cannot take.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Weights that do not fit the graph.
    #[error(transparent)]
    Graph(#[from] taxel_graph::Error),
    /// Inputs that do not fit the network.
    #[error("{model}: {reason}")]
    Input {
        /// Network name.
        model: String,
        /// The mismatch.
        reason: String,
    },
    /// A network in bf16 on a processor that has no products of it.
    #[error(
        "{model}: predicts with products of bf16, which are not possible here: {reason}; take the model in floats that it was made \
         of, or put that in eight bits"
    )]
    Half {
        /// Network name.
        model: String,
        /// The reason.
        reason: &'static str,
    },
    /// A workspace that another network made.
    #[error("{model}: the workspace belongs to another network; make one with this network's `workspace`")]
    Workspace {
        /// Network name.
        model: String,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
