//! What the outputs of a convolution start from.

/// What outputs start from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Begin<'a> {
    Zero,
    /// The values already there.
    Add,
    /// One value per filter.
    Bias(&'a [f32]),
}
