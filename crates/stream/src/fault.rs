//! Why a line is no time step.

/// Why a line is no time step, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Something in it is no number.
    Malformed(String),
    /// There are more or fewer numbers than a time step has.
    Columns(String),
    /// A number is NaN or infinite.
    NotFinite(String),
    /// No line can be a time step: a column that is needed has another name.
    Names(String),
}
