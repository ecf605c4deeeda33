//! The error type of the judge.

use std::path::Path;

use taxel_learn::Problem;

/// A run folder, or a setting, that cannot be judged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The run folder, its data or its models.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
    /// Targets that the judgement has no use for.
    #[error(transparent)]
    Data(#[from] taxel_data::Error),
    /// A fault that has no meaning for these readings, or cannot be applied to them.
    #[error("{source_label}: {source}")]
    Fault {
        /// Source of the samples.
        source_label: String,
        /// The fault's reason.
        source: taxel_faults::Error,
    },
    /// A run folder that lacks something, or holds something else.
    #[error("{folder}: {reason}")]
    Run {
        /// The run folder.
        folder: String,
        /// The reason, and how to fix it.
        reason: String,
    },
    /// A setting outside its range.
    #[error("{0}")]
    Setting(Problem),
    /// Threads that cannot be started.
    #[error("threads = {threads}: cannot be started: {reason}")]
    Threads {
        /// How many.
        threads: usize,
        /// Message of the system.
        reason: String,
    },
    /// Values that a statistic cannot be computed of.
    #[error("{what}: {reason}")]
    Statistics {
        /// The statistic.
        what: &'static str,
        /// The reason.
        reason: String,
    },
    /// A picture of a judgement that cannot be drawn, a file that cannot be written.
    #[error(transparent)]
    Report(#[from] taxel_report::Error),
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl From<Problem> for Error {
    fn from(problem: Problem) -> Self {
        Error::Setting(problem)
    }
}

impl Error {
    pub(crate) fn run(folder: &Path, reason: impl Into<String>) -> Self {
        Error::Run { folder: folder.display().to_string(), reason: reason.into() }
    }

    pub(crate) fn write(path: &Path, reason: impl ToString) -> Self {
        taxel_report::Error::write(path, reason).into()
    }
}
