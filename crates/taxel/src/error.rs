//! The error of this crate.

/// An error of any part of taxel; its text names the file, key or sample and how to fix it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Recordings that cannot be read or used.
    #[error(transparent)]
    Data(#[from] taxel_data::Error),
    /// A network that cannot be built.
    #[error(transparent)]
    Graph(#[from] taxel_graph::Error),
    /// A network that is not there, or settings that it does not take.
    #[cfg(feature = "lab")]
    #[error(transparent)]
    Zoo(#[from] taxel_zoo::Error),
    /// A training, a run folder or a model.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
    /// An experiment that cannot be run.
    #[cfg(feature = "lab")]
    #[error(transparent)]
    Experiment(#[from] taxel_trainer::Error),
    /// An ONNX file.
    #[cfg(feature = "lab")]
    #[error(transparent)]
    Onnx(#[from] taxel_onnx::Error),
    /// A network that cannot become C.
    #[cfg(feature = "lab")]
    #[error(transparent)]
    Firmware(#[from] taxel_firmware::Error),
    /// A model that cannot be exported.
    #[cfg(feature = "lab")]
    #[error("{model}: {reason}")]
    Export {
        /// Its name.
        model: String,
        /// Why not.
        reason: String,
    },
    /// A run that cannot be judged.
    #[cfg(feature = "lab")]
    #[error(transparent)]
    Judge(#[from] taxel_judge::Error),
    /// A stream that cannot be predicted.
    #[error(transparent)]
    Stream(#[from] taxel_stream::Error),
    /// Many experiments on many machines.
    #[cfg(feature = "lab")]
    #[error(transparent)]
    Sweep(#[from] taxel_sweep::Error),
    /// A file.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
