//! The errors of a network description or its tensors.

/// A network that cannot be built, or tensors that do not fit it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// An operation does not fit its input.
    #[error("{node}: {reason}")]
    Node {
        /// Name of the node, as in the checkpoint.
        node: String,
        /// The mismatch, with axis names.
        reason: String,
    },
    /// A configuration value outside its range.
    #[error("{key} = {value}: {reason}")]
    Config {
        /// Key of the setting.
        key: String,
        /// The value given.
        value: String,
        /// The allowed range.
        reason: String,
    },
    /// The graph names a tensor that the weights lack.
    #[error("{model}: tensor `{name}` is missing; expected shape {shape:?}{hint}")]
    Missing {
        /// Network name.
        model: String,
        /// Tensor name.
        name: String,
        /// Expected shape, PyTorch axis order.
        shape: Vec<usize>,
        /// How to fix it, where the tensors have it under a longer name; empty otherwise.
        hint: Box<str>,
    },
    /// A tensor holds a value that no training gives.
    #[error("tensor `{name}` {reason}")]
    Unsound {
        /// Tensor name.
        name: String,
        /// The value, where it is, and how to fix it.
        reason: String,
    },
    /// The weights hold a tensor that the graph does not name.
    #[error("{model}: tensor `{name}` is not part of this network")]
    Extra {
        /// Network name.
        model: String,
        /// Tensor name.
        name: String,
    },
    /// A tensor has another shape than the graph says.
    #[error("{model}: tensor `{name}` has shape {got:?}, expected {expected:?}")]
    Misshaped {
        /// Network name.
        model: String,
        /// Tensor name.
        name: String,
        /// Shape found.
        got: Vec<usize>,
        /// Shape expected.
        expected: Vec<usize>,
    },
}

/// Result with this crate's [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Makes an [`Error::Config`]: `key = value: reason`.
    pub fn config(key: &str, value: impl ToString, reason: &str) -> Self {
        Error::Config { key: key.into(), value: value.to_string(), reason: reason.into() }
    }

    /// Makes an [`Error::Node`]: `node: reason`; `node` may also be a network or a tensor.
    pub fn node(node: &str, reason: impl Into<String>) -> Self {
        Error::Node { node: node.into(), reason: reason.into() }
    }
}
