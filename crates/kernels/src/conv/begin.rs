//! The values from which the outputs of a convolution start.

/// The values from which outputs start.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Begin<'a> {
    Zero,
    /// The values already there.
    Add,
    /// One value per filter.
    Bias(&'a [f32]),
}
