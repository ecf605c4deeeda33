//! What the judge refuses.

/// A run folder, or a wish, that cannot be judged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The run folder, its data or its models.
    #[error(transparent)]
    Trainer(#[from] taxel_trainer::Error),
    /// A fault that has no meaning for these readings, or cannot be applied to them.
    #[error("{source_label}: {source}")]
    Fault {
        /// What the samples are.
        source_label: String,
        /// What the scenes say.
        source: taxel_scenes::Error,
    },
    /// A run folder that holds something else than is asked of it.
    #[error("{folder}: {reason}")]
    Run {
        /// The run folder.
        folder: String,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// A setting outside its range.
    #[error("{name} = {value}: {reason}")]
    Setting {
        /// The option.
        name: &'static str,
        /// Its value.
        value: String,
        /// What would do.
        reason: String,
    },
    /// Values that a statistic cannot be computed of.
    #[error("{what}: {reason}")]
    Statistics {
        /// The statistic.
        what: &'static str,
        /// What is wrong with them.
        reason: String,
    },
    /// A file that cannot be written.
    #[error("{path}: cannot be written: {reason}")]
    Write {
        /// The file.
        path: String,
        /// What the system says.
        reason: String,
    },
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;
