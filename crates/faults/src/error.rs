//! The one error type of the faults.

/// A fault that cannot be applied as asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No fault has this name.
    #[error("there is no fault `{name}`; {hint}")]
    UnknownFault {
        /// The name asked for.
        name: String,
        /// The nearest names, and all of them.
        hint: String,
    },
    /// A fault has no meaning for these readings.
    #[error("fault {fault} has no meaning for {layout}: {reason}")]
    Fault {
        /// The fault.
        fault: &'static str,
        /// The layout of the readings.
        layout: &'static str,
        /// Why it has none.
        reason: &'static str,
    },
    /// A sample cannot be worked on.
    #[error("sample {sample}: {reason}")]
    Sample {
        /// Index of the sample.
        sample: usize,
        /// The problem, and how to fix it.
        reason: String,
    },
    /// A parameter is impossible.
    #[error("{name} = {value}: {expected}")]
    Parameter {
        /// Name of the parameter.
        name: String,
        /// The value given.
        value: String,
        /// The values that work.
        expected: String,
    },
}

/// A result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;
