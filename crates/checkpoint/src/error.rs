//! The errors of checkpoint files.

use std::io;
use std::path::{Path, PathBuf};

/// A checkpoint that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {cause}", path.display())]
pub struct Error {
    /// File.
    pub path: PathBuf,
    /// The reason, and how to fix it.
    pub cause: Cause,
}

impl Error {
    pub(crate) fn new(path: &Path, cause: Cause) -> Self {
        Error { path: path.into(), cause }
    }
}

/// The reason why the content of a checkpoint is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Cause {
    /// The system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The system does not take it: a full device, a folder that is not there.
    #[error("cannot be written: {0}")]
    Write(io::Error),
    /// The ending of the name says nothing.
    #[error("unknown kind of weights; expected .safetensors, .pth or .pt")]
    Kind,
    /// Tensors that the format cannot hold.
    #[error("cannot be written as safetensors: {0}")]
    Unwritable(String),
    /// Damaged, or of another format.
    #[error("not a whole safetensors file: {0}; copy it again")]
    NotSafetensors(String),
    /// Integers, booleans and the like.
    #[error("tensor `{tensor}` is {dtype}; expected F32, F64, F16 or BF16")]
    Type {
        /// Tensor name.
        tensor: String,
        /// Its type in the file.
        dtype: String,
    },
    /// A value that is not finite, or a variance below 0.
    #[error(transparent)]
    Unsound(Box<taxel_graph::Error>),
    /// A graph that is none, or another than the tensors are of.
    #[error("its network cannot be read: {0}")]
    Network(String),
    /// A tensor in memory that is none.
    #[error("tensor `{tensor}` holds {values} values, which do not fill its shape {shape:?}")]
    Shape {
        /// Tensor name.
        tensor: String,
        /// Axis sizes.
        shape: Vec<usize>,
        /// Number of values.
        values: usize,
    },
    /// PyTorch's format, which this build does not read.
    #[error(
        "this build does not read PyTorch's format; save it as .safetensors, or build taxel with `--features candle`"
    )]
    NoPthReader,
    /// Saved by PyTorch before 1.6, or by a newer one that was asked for that format.
    #[error(
        "is in PyTorch's old format (before 1.6, or _use_new_zipfile_serialization=False); load it with torch.load \
         and save it as .safetensors, or save it again with torch.save(model.state_dict(), path)"
    )]
    LegacyPth,
    /// Another object than a `state_dict`, or damaged.
    #[error("{0}; save it again with torch.save(model.state_dict(), path)")]
    Pth(String),
}

/// Result with this crate's [`struct@Error`].
pub type Result<T> = std::result::Result<T, Error>;
