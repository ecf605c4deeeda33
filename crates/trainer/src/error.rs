//! The one error type of the trainer.

use std::path::Path;

/// An experiment that cannot be run, or was stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or folder cannot be read or written.
    #[error("{file}: cannot be {action}: {source}")]
    Io {
        /// The path as the user gave it.
        file: String,
        /// `read`, `written`, `created`, …
        action: &'static str,
        /// What the system says.
        source: std::io::Error,
    },
    /// A config that is not valid TOML, or has an unknown key or a value of the wrong type.
    #[error("{place}: {message}{line}")]
    Config {
        /// `file:line:column`, or `--set key=value`.
        place: String,
        /// What is wrong and what would do.
        message: String,
        /// The line itself on a line of its own, or nothing.
        line: String,
    },
    /// A config value outside its range.
    #[error("{place}: {key} = {value}: {reason}")]
    Value {
        /// `file:line`, or `--set`, or the file alone where the default is meant.
        place: String,
        /// Dotted path of the key.
        key: String,
        /// The value given.
        value: String,
        /// The allowed values.
        reason: String,
    },
    /// An experiment's data cannot be loaded.
    #[error(transparent)]
    Data(Box<taxel_data::Error>),
    /// A checkpoint cannot be read or written.
    #[error(transparent)]
    Checkpoint(#[from] taxel_checkpoint::Error),
    /// An experiment's scene cannot be simulated.
    #[error(transparent)]
    Scene(#[from] taxel_scenes::Error),
    /// The samples cannot be encoded.
    #[error("{source_label}: {input}: {source}")]
    Encoding {
        /// The data set or scene.
        source_label: String,
        /// `signal` or `image`.
        input: &'static str,
        /// What the encoder says.
        source: taxel_encodings::Error,
    },
    /// The samples have the wrong axes for an encoding.
    #[error("{source_label}: samples of shape {shape:?} cannot become `{input}`: {reason}")]
    Axes {
        /// The data set or scene.
        source_label: String,
        /// `signal` or `image`.
        input: &'static str,
        /// Shape of one sample.
        shape: Vec<usize>,
        /// The shapes that work.
        reason: &'static str,
    },
    /// A network cannot be built for these samples.
    #[error(transparent)]
    Zoo(Box<taxel_zoo::Error>),
    /// The engine refuses a graph, its weights or a batch.
    #[error(transparent)]
    Engine(Box<taxel_engine::Error>),
    /// Weights that do not belong to their graph.
    #[error("{file}: {source}")]
    Weights {
        /// The checkpoint.
        file: String,
        /// Which tensor.
        source: Box<taxel_graph::Error>,
    },
    /// Training has left the finite numbers.
    #[error(
        "{network}, repetition {repetition}, fold {fold}: the loss is {loss} in epoch {epoch}, batch {batch}; \
         lower train.optimizer.lr ({lr}) or check the scale of the readings"
    )]
    Diverged {
        /// Name of the network in the experiment.
        network: String,
        /// Repetition, from 0.
        repetition: usize,
        /// Fold, from 0.
        fold: usize,
        /// Epoch, from 0.
        epoch: usize,
        /// Batch, from 0.
        batch: usize,
        /// NaN or infinity.
        loss: f32,
        /// Learning rate of the step before.
        lr: f32,
    },
    /// Every combination of settings has left the finite numbers.
    #[error(
        "{network}, repetition {repetition}, fold {fold}: training diverged with all {trials} combinations of \
         choose.grid; add smaller learning rates or check the scale of the readings"
    )]
    NothingChosen {
        /// Name of the network in the experiment.
        network: String,
        /// Repetition, from 0.
        repetition: usize,
        /// Fold, from 0.
        fold: usize,
        /// Combinations that were tried.
        trials: usize,
    },
    /// A baseline refuses its data.
    #[error("{baseline}: {source}")]
    Baseline {
        /// Its name.
        baseline: String,
        /// What it says.
        source: taxel_baselines::Error,
    },
    /// The run folder holds something else, or another process works in it.
    #[error("{folder}: {reason}")]
    Folder {
        /// The run folder.
        folder: String,
        /// What is in the way, and the way out.
        reason: String,
    },
    /// A file of a run folder or a checkpoint is damaged.
    #[error("{file}: {reason}")]
    Damaged {
        /// The file.
        file: String,
        /// What is wrong with it, and the way out.
        reason: String,
    },
    /// Stopped from outside.
    #[error("stopped after {done} of {total} folds; continue with --resume --out {folder}")]
    Cancelled {
        /// Finished folds.
        done: usize,
        /// All folds.
        total: usize,
        /// The run folder.
        folder: String,
    },
    /// Numbers that do not describe a set of predictions.
    #[error("{what}: {reason}")]
    Metrics {
        /// Which numbers.
        what: &'static str,
        /// What is wrong with them.
        reason: String,
    },
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl From<taxel_zoo::Error> for Error {
    fn from(error: taxel_zoo::Error) -> Self {
        Error::Zoo(Box::new(error))
    }
}

impl From<taxel_engine::Error> for Error {
    fn from(error: taxel_engine::Error) -> Self {
        Error::Engine(Box::new(error))
    }
}

impl From<taxel_data::Error> for Error {
    fn from(error: taxel_data::Error) -> Self {
        Error::Data(Box::new(error))
    }
}

impl Error {
    pub(crate) fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        Error::Io { file: path.display().to_string(), action, source }
    }

    pub(crate) fn folder(path: &Path, reason: impl Into<String>) -> Self {
        Error::Folder { folder: path.display().to_string(), reason: reason.into() }
    }

    pub(crate) fn damaged(path: &Path, reason: impl Into<String>) -> Self {
        Error::Damaged { file: path.display().to_string(), reason: reason.into() }
    }
}
