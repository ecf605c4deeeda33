//! The error of samples that a guard cannot be fitted to.

/// The result of this crate's functions.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Samples that a guard cannot be fitted on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Another shape than the layout has, or no samples.
    #[error("a guard is fitted on samples of {layout}; these have shape {shape:?}")]
    Shape {
        /// Axes of a sample.
        layout: &'static str,
        /// Of all samples.
        shape: Vec<usize>,
    },
    /// A reading is NaN or infinite.
    #[error("reading {reading} of sample {sample} is {value}; a guard is fitted on finite readings")]
    NonFinite {
        /// Place among the samples.
        sample: usize,
        /// Place in the sample, row-major.
        reading: usize,
        /// NaN or an infinity.
        value: f32,
    },
    /// Rest values in the wrong number.
    #[error("{given} rest values for {elements} channels or taxels; give one for all, or one for each")]
    Rest {
        /// How many there are.
        given: usize,
        /// How many there may be, beside one.
        elements: usize,
    },
}
