//! Pieces of an image between the steps of one pass.

/// Some rows of outputs, or all of them.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    pub(super) from: usize,
    pub(super) rows: usize,
    /// First row of the padded input under it and their number, over all depths.
    pub(super) under: (usize, usize),
}

/// The input under a band, as the kernel reads it; made by [`Conv::pad`](super::Conv::pad).
#[derive(Debug, Clone, Copy)]
pub struct Padded<'a> {
    pub(super) values: &'a [f32],
    pub(super) band: Band,
}
