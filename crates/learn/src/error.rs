//! The one error type of this crate.

use std::path::Path;

use crate::problem::Problem;

/// A training that cannot be done, or was stopped; a model or run folder that cannot be used.
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
        /// The system's message.
        source: std::io::Error,
    },
    /// A setting outside its range, or one that the samples do not allow.
    #[error("{0}")]
    Setting(Problem),
    /// Samples that cannot be read or divided.
    #[error(transparent)]
    Data(Box<taxel_data::Error>),
    /// A checkpoint cannot be read or written.
    #[error(transparent)]
    Checkpoint(#[from] taxel_checkpoint::Error),
    /// The samples cannot be encoded.
    #[error("{source_label}: {input}: {source}")]
    Encoding {
        /// The data set or scene.
        source_label: String,
        /// `signal`, `image`, `tensor`, `rocket` or `series`.
        input: &'static str,
        /// The encoder's error.
        source: taxel_encodings::Error,
    },
    /// The samples have the wrong axes for an encoding.
    #[error("{source_label}: samples of shape {shape:?} cannot become `{input}`: {reason}")]
    Axes {
        /// The data set or scene.
        source_label: String,
        /// `signal`, `image`, `tensor`, `rocket` or `series`.
        input: &'static str,
        /// Shape of one sample.
        shape: Vec<usize>,
        /// The shapes that work.
        reason: &'static str,
    },
    /// A network reads something that the encoding does not make, or of another shape.
    #[error("{network} reads `{input}`: {reason}")]
    Input {
        /// Name of the network.
        network: String,
        /// Name of the input.
        input: String,
        /// The mismatch.
        reason: String,
    },
    /// A network with more or fewer outputs than the targets need.
    #[error("{network} answers with {outputs} numbers; the targets and the loss need {classes}")]
    Outputs {
        /// Name of the network.
        network: String,
        /// Values of its first output.
        outputs: usize,
        /// Classes, levels of all attributes together, or quantities times the outputs that the loss takes for each.
        classes: usize,
    },
    /// A model that eight bits cannot be made of.
    #[error("{model}: {reason}")]
    EightBits {
        /// Its name.
        model: String,
        /// Why not.
        reason: String,
    },
    /// A model that bf16 cannot be made of.
    #[error("{model}: {reason}")]
    Half {
        /// Its name.
        model: String,
        /// Why not.
        reason: String,
    },
    /// A model that cannot be calibrated.
    #[error("{model}: {reason}")]
    Calibration {
        /// Its name.
        model: String,
        /// Why not.
        reason: String,
    },
    /// The engine refuses a graph, its weights or a batch.
    #[error(transparent)]
    Engine(Box<taxel_engine::Error>),
    /// The runtime refuses a graph, its weights or samples.
    #[error(transparent)]
    Runtime(#[from] taxel_runtime::Error),
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
    /// Some trainings diverged; all others are finished and on disk.
    #[error("{} of {total} folds did not finish: their training diverged; {folder} holds the others{}",
        folds.len(), folds.iter().map(|error| format!("\n{error}")).collect::<String>())]
    Unfinished {
        /// [`Error::Diverged`] or [`Error::NothingChosen`] of each.
        folds: Vec<Error>,
        /// All folds.
        total: usize,
        /// The run folder.
        folder: String,
    },
    /// A baseline refuses its data.
    #[error("{baseline}: {source}")]
    Baseline {
        /// Its name.
        baseline: String,
        /// The baseline's error.
        source: taxel_baselines::Error,
    },
    /// The run folder holds something else, or another process works in it.
    #[error("{folder}: {reason}")]
    Folder {
        /// The run folder.
        folder: String,
        /// The reason, and how to fix it.
        reason: String,
    },
    /// A file of a run folder or a model is damaged.
    #[error("{file}: {reason}")]
    Damaged {
        /// The file.
        file: String,
        /// The reason, and how to fix it.
        reason: String,
    },
    /// Samples that are not what a model reads.
    #[error("{model} reads {expected}; {given}")]
    Samples {
        /// Name of the model.
        model: String,
        /// Layout and shape of what it reads.
        expected: String,
        /// The samples that were given.
        given: String,
    },
    /// Stopped from outside.
    #[error("stopped after {done} of {total} folds; {folder} holds them")]
    Cancelled {
        /// Finished folds.
        done: usize,
        /// All folds.
        total: usize,
        /// The run folder; empty where nothing was to be written.
        folder: String,
    },
    /// Numbers that do not describe a set of predictions.
    #[error("{what}: {reason}")]
    Metrics {
        /// Which numbers.
        what: &'static str,
        /// The reason.
        reason: String,
    },
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl From<Problem> for Error {
    fn from(problem: Problem) -> Self {
        Error::Setting(problem)
    }
}

impl From<taxel_engine::Error> for Error {
    fn from(error: taxel_engine::Error) -> Self {
        Error::Engine(Box::new(error))
    }
}

impl From<taxel_graph::Error> for Error {
    fn from(error: taxel_graph::Error) -> Self {
        taxel_engine::Error::from(error).into()
    }
}

impl From<taxel_data::Error> for Error {
    fn from(error: taxel_data::Error) -> Self {
        Error::Data(Box::new(error))
    }
}

impl Error {
    /// Checks whether the error is a training that left the finite numbers: other trainings may go on.
    pub fn is_divergence(&self) -> bool {
        matches!(self, Error::Diverged { .. } | Error::NothingChosen { .. })
    }

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
