//! The one error type of the encodings.
//!
//! # Reference
//!
//! None: every message names the thing, its value and how to fix it.

/// A reading, a setting or a shape that cannot be encoded.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A reading is NaN or infinite.
    #[error("{place} is {value}; drop or interpolate bad taxels before encoding")]
    NonFinite {
        /// Which reading, such as `reading 17 of sample 3`.
        place: String,
        /// NaN or an infinity.
        value: f32,
    },
    /// The series has fewer readings than the image has rows.
    #[error(
        "the series is too short: {length} readings for an image of size {size}; record longer or set size to {length} or less"
    )]
    TooShort {
        /// Readings in the series.
        length: usize,
        /// Rows of the image.
        size: usize,
    },
    /// All segments of the series have the same mean, so there is nothing to rescale by.
    #[error(
        "the series is constant (value {value}), per-sample rescaling has no range; use a fixed range, drop the recording, or set constant to zero"
    )]
    Constant {
        /// The one value.
        value: f64,
    },
    /// The fixed range is empty, reversed or not finite.
    #[error(
        "range {low}..{high} is empty or not finite; low must be below high, as in 0..1023 for 10-bit counts"
    )]
    Range {
        /// Value that becomes -1.
        low: f32,
        /// Value that becomes 1.
        high: f32,
    },
    /// A difference to a reading that is not there.
    #[error("lag {lag}: must be from 1 to {}, as recordings have {length} time steps", length.saturating_sub(1))]
    Lag {
        /// Time steps before the last one.
        lag: usize,
        /// Time steps of a recording.
        length: usize,
    },
    /// The image size cannot work.
    #[error("size = {size}: must be at least {least}{why}")]
    Size {
        /// The size asked for.
        size: usize,
        /// The smallest that works.
        least: usize,
        /// Why, where it is not obvious.
        why: &'static str,
    },
    /// An array has the wrong shape.
    #[error("{what}: expected {expected}, got shape {got:?}")]
    Shape {
        /// The array.
        what: &'static str,
        /// The expected shape, in words.
        expected: String,
        /// The shape given.
        got: Vec<usize>,
    },
    /// A scaling parameter is not a positive, finite number, or not finite.
    #[error("{name} = {value}: must be {expected}")]
    Parameter {
        /// Name of the parameter, with its channel if it has one.
        name: String,
        /// The value given.
        value: f32,
        /// The values that work.
        expected: &'static str,
    },
    /// A reduction that is none, or has no meaning for the samples.
    #[error(transparent)]
    Reduction(Box<RefusedReduction>),
    /// The contact judge never fired.
    #[error(
        "no AC value is more than {above} or less than {below} times the one before: nothing was touched, or the thresholds do not fit the sensor"
    )]
    NoContact {
        /// The upper threshold.
        above: f32,
        /// The lower threshold.
        below: f32,
    },
    /// Contact leaves no room for the window, or for the rest before it.
    #[error(
        "contact in tick {onset} of {ticks}: there must be a tick of rest before it and a window of {window} from it on; record longer, or set window or offset"
    )]
    Window {
        /// The tick of the contact.
        onset: usize,
        /// Ticks asked for.
        window: usize,
        /// Ticks recorded.
        ticks: usize,
    },
    /// One sample of a batch failed.
    #[error("sample {sample}: {error}")]
    Sample {
        /// Index of the sample in the batch.
        sample: usize,
        /// The problem.
        error: Box<Error>,
    },
}

/// A value of a reduction that does not do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {value}: {reason}")]
pub struct RefusedReduction {
    /// Its key.
    pub key: &'static str,
    /// The value given.
    pub value: String,
    /// The values that work.
    pub reason: String,
}

impl Error {
    pub(crate) fn reduction(key: &'static str, value: String, reason: impl Into<String>) -> Self {
        Self::Reduction(Box::new(RefusedReduction { key, value, reason: reason.into() }))
    }

    /// Says which sample of a batch the error is about.
    pub(crate) fn in_sample(self, sample: usize) -> Self {
        match self {
            Self::NonFinite { place, value } => {
                Self::NonFinite { place: format!("{place} of sample {sample}"), value }
            }
            // A wrong setting is wrong for every sample.
            Self::Range { .. } | Self::Size { .. } | Self::Parameter { .. } | Self::Reduction(_) => self,
            other => Self::Sample { sample, error: Box::new(other) },
        }
    }
}

/// A result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;
