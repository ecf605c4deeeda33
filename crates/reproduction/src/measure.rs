//! Scores that claims compare.

/// The score that is compared.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Measure {
    /// Over all attributes.
    Accuracy,
    /// Accuracy on one attribute.
    Attribute(&'static str),
    /// Precision of the worst level of an attribute.
    WorstPrecision(&'static str),
}
