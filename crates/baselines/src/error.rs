//! The errors of the methods.

/// Series, labels or settings that a method cannot take.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what each field is")]
#[non_exhaustive]
pub enum Error {
    #[error("{values} values are not one or more recordings of {channels} channels × {length} readings")]
    Shape { values: usize, channels: usize, length: usize },
    #[error("sample {sample} holds {value}; repair the recording or leave it out")]
    NotFinite { sample: usize, value: f32 },
    #[error("the target of sample {sample} is {value}; repair it or leave the sample out")]
    Target { sample: usize, value: f32 },
    #[error("{labels} labels for {samples} samples; one each is needed")]
    Labels { labels: usize, samples: usize },
    #[error("label {label} is not one of {classes} classes")]
    Label { label: u32, classes: usize },
    #[error("fitted to {} channels × {} readings, given {} × {}", fitted[0], fitted[1], given[0], given[1])]
    OtherShape { fitted: [usize; 2], given: [usize; 2] },
    #[error("MiniRocket needs at least {least} readings in time, the recordings have {length}")]
    TooShort { length: usize, least: usize },
    #[error("{name} = {value}: {reason}")]
    Setting { name: &'static str, value: String, reason: &'static str },
    #[error("saved array {tensor} {reason}; fit the method again")]
    Saved { tensor: String, reason: &'static str },
}

/// A result whose error is [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    pub(crate) fn setting(name: &'static str, value: impl ToString, reason: &'static str) -> Self {
        Error::Setting { name, value: value.to_string(), reason }
    }

    /// Refuses memory that another method made.
    pub(crate) fn foreign_workspace() -> Self {
        Error::setting("workspace", "another method's", "make one with this method's `workspace`")
    }
}
