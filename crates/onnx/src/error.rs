//! The errors of ONNX files, and of networks that are to become one.

use std::io;
use std::path::{Path, PathBuf};

/// An ONNX file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {cause}", path.display())]
pub struct Error {
    /// File.
    pub path: PathBuf,
    /// The reason, and how to fix it.
    pub cause: Box<Cause>,
}

impl Error {
    pub(crate) fn new(path: &Path, cause: Cause) -> Self {
        Error { path: path.into(), cause: Box::new(cause) }
    }
}

/// The reason why the content of an ONNX file is refused.
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
        /// The mismatch, and how to fix it.
        reason: String,
    },
    /// A stored tensor that cannot be read.
    #[error("tensor `{name}`: {reason}")]
    Tensor {
        /// Its name in the file.
        name: String,
        /// The mismatch.
        reason: String,
    },
    /// A node that no operation of taxel can do.
    #[error("node `{node}` ({operation}): {reason}")]
    Node {
        /// Name of the node; of one without a name, of its first output.
        node: String,
        /// ONNX's name of the operation.
        operation: String,
        /// The mismatch, and how to fix it.
        reason: String,
    },
    /// The network that the nodes make is none.
    #[error(transparent)]
    Graph(#[from] taxel_graph::Error),
}

/// Result with this crate's [`struct@Error`].
pub type Result<T> = std::result::Result<T, Error>;
