//! The errors of a name, a network's settings or its data.

/// A network that is not there or cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No network of that name.
    #[error("no network is called `{name}`; {hint}")]
    Unknown {
        /// Name asked for.
        name: String,
        /// The names nearest to it, or all of them where none is near.
        hint: String,
    },
    /// A second network of one name.
    #[error("a network is called `{name}` already; give the other one another name")]
    Twice {
        /// The name.
        name: String,
    },
    /// A setting has an unknown key or a value of the wrong type.
    #[error("{model}: {}", taxel_base::names::with_meant(&source.to_string()))]
    Settings {
        /// Network name.
        model: String,
        /// serde's error.
        source: serde_json::Error,
    },
    /// The network refuses its configuration.
    #[error("{model}: {source}")]
    Graph {
        /// Network name.
        model: String,
        /// The graph's error.
        source: taxel_graph::Error,
    },
    /// The data do not have what the network reads.
    #[error("{model} reads `{input}` with {axes} axes; {reason}")]
    Input {
        /// Network name.
        model: String,
        /// Input name.
        input: String,
        /// Axes the network expects, batch left out.
        axes: usize,
        /// The mismatch.
        reason: String,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
