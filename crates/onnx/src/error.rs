//! What is wrong with an ONNX file, or with a network that is to become one.

use std::io;
use std::path::{Path, PathBuf};

/// An ONNX file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {cause}", path.display())]
pub struct Error {
    /// File.
    pub path: PathBuf,
    /// What is wrong with it, and the way out.
    pub cause: Box<Cause>,
}

impl Error {
    pub(crate) fn new(path: &Path, cause: Cause) -> Self {
        Error { path: path.into(), cause: Box::new(cause) }
    }
}

/// What is wrong with the content of an ONNX file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Cause {
    /// The system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The system does not take it: a full device, a folder that is not there.
    #[error("cannot be written: {0}")]
    Write(io::Error),
    /// Damaged, or of another format.
    #[error("is no ONNX model: {0}")]
    NotOnnx(String),
    /// A version of the operations that is not known here.
    #[error("{0}")]
    Version(String),
    /// An input or output that a network of taxel does not have.
    #[error("{role} `{name}`: {reason}")]
    Port {
        /// `input` or `output`.
        role: &'static str,
        /// Its name in the file.
        name: String,
        /// What does not fit, and the way out.
        reason: String,
    },
    /// A stored tensor that cannot be read.
    #[error("tensor `{name}`: {reason}")]
    Tensor {
        /// Its name in the file.
        name: String,
        /// What does not fit.
        reason: String,
    },
    /// A node that no operation of taxel can do.
    #[error("node `{node}` ({operation}): {reason}")]
    Node {
        /// Name of the node; of one without a name, of its first output.
        node: String,
        /// ONNX's name of the operation.
        operation: String,
        /// What does not fit, and the way out.
        reason: String,
    },
    /// The network that the nodes make is none.
    #[error(transparent)]
    Graph(#[from] taxel_graph::Error),
}

/// Result with this crate's [`struct@Error`].
pub type Result<T> = std::result::Result<T, Error>;
