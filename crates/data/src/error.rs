//! Everything that can be wrong with a data set, in words a user can act on.

use crate::length::length::Length;
use std::fmt::Display;
use std::io;
use std::path::Path;
use taxel_base::{FileError, Layout, reason};

/// The result of this crate's functions.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A data set or a setting that is refused: where, why, and how to fix it.
///
/// `file` is the path as the user gave it; `at` adds the array (`grasps.npz: x`). Variants are for callers that tell
/// refusals apart, and for reasons that several readers give; all others are a [`FileError`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what each field is")]
#[non_exhaustive]
pub enum Error {
    #[error(transparent)]
    File(#[from] FileError),

    // The path.
    #[error(
        "{file}: no such file or folder; give a {endings}, a folder with data.npz, or a folder with one sub-folder per \
         class"
    )]
    NotFound { file: String, endings: String },
    #[error("{file}: cannot be read: {why}")]
    Io { file: String, kind: io::ErrorKind, why: String },
    #[error("{file}: cannot be written: {why}")]
    Write { file: String, why: String },
    #[error("{file}: this build does not read it; build taxel with --features taxel-data/{feature}")]
    NotBuilt { file: String, feature: &'static str },

    // The archive and its arrays.
    #[error("{file}: is empty (0 bytes); copy or record it again")]
    EmptyFile { file: String },
    #[error("{at}: is not a NumPy array ({why}); write it with numpy.save or numpy.savez")]
    NotAnArray { at: String, why: String },
    #[error("{at}: has dtype {dtype}; {wanted}")]
    Dtype { at: String, dtype: String, wanted: &'static str },
    #[error("{at}: data end after {got} of {want} bytes; the file is cut short, copy it again")]
    Truncated { at: String, got: u64, want: u64 },
    #[error("{at}: data are damaged ({why}); copy the file again")]
    Damaged { at: String, why: String },
    #[error("{at}: holds more than the {want} bytes that its shape {shape:?} takes; save it again")]
    Excess { at: String, want: u64, shape: Vec<u64> },
    #[error("{at}: shape {shape:?} is more than the {limit} values allowed; {hint}")]
    TooLarge { at: String, shape: Vec<u64>, limit: u64, hint: &'static str },
    #[error("{at}: {samples} samples are more than the {limit} allowed; raise limits.max_samples")]
    TooManySamples { at: String, samples: u64, limit: u64 },
    #[error("{at}: has shape {shape:?}; {wanted}")]
    Shape { at: String, shape: Vec<u64>, wanted: &'static str },
    #[error("{at}: has shape {shape:?}: axis {axis} is empty; there is nothing to learn from")]
    EmptyAxis { at: String, shape: Vec<u64>, axis: usize },
    #[error("{at}: holds no samples")]
    NoSamples { at: String },
    #[error("{at}{index:?} = {value} {why}")]
    Value { at: String, index: Vec<usize>, value: String, why: String },

    // The content.
    #[error("{file}: {array} has {len} entries but {x} has {samples} samples; one per sample")]
    Length { file: String, array: String, len: usize, x: String, samples: usize },
    #[error("{file}: all samples are of one class, {class}: nothing to tell apart")]
    OneClass { file: String, class: String },
    #[error("{sample}: value at {index:?} is {value}; repair the recording or leave it out")]
    NotFinite { sample: String, index: Vec<usize>, value: f32 },
    #[error(
        "{file}: recordings have {shortest} to {longest} readings; say what to do, such as data.{}",
        proposed.key()
    )]
    UnequalLengths { file: String, shortest: usize, longest: usize, proposed: Length },
    #[error(
        "{file}: length: a sample is {}, which has no time; leave it out, or say what the axes are with layout",
        layout.describe()
    )]
    NoTime { file: String, layout: Layout },
    #[error("{sample}: has {}, length.to is {to}; {why}", plural(*length, "reading"))]
    RecordingLength { sample: String, length: usize, to: usize, why: &'static str },
    #[error("{file}: {option}: {why}")]
    Option { file: String, option: &'static str, why: &'static str },
    #[error(
        "{file}: line {line} holds no values with a class; a case is values:class in .ts, class values else"
    )]
    NoClass { file: String, line: u64 },
    #[error(
        "{file}: {array} marks no or all samples for testing; mark some of them with 1, the others with 0"
    )]
    OneSided { file: String, array: String },

    // Class names and facts.
    #[error("{at}: {key} is {value}, {wanted}")]
    Fact { at: String, key: &'static str, value: String, wanted: String },
    #[error("{at}: layout is {layout}, but a sample of shape {shape:?} is not {}", layout.describe())]
    Layout { at: String, layout: Layout, shape: Vec<usize> },
    #[error("source = {text:?}: is neither \"simulated: NAME\" nor \"real: NAME\"")]
    Source { text: String },

    // What is learned.
    #[error(
        "{source_name}: the targets are values, and classes or levels are needed here; give a data set with labels"
    )]
    NoLabels { source_name: String },
    #[error("{reason}")]
    LearnAttributes { reason: String },
    #[error("{value}: {reason}")]
    KeepClasses { value: String, reason: String },

    // Files of recordings and tables.
    #[error(
        "{file}: a folder where recordings are expected; recordings lie in class/file or in class/session/file"
    )]
    NestedFolder { file: String },
    #[error("{file}: is {kind}, but {first} is {first_kind}; use one kind in a data set")]
    MixedKinds { file: String, kind: String, first: String, first_kind: String },
    #[error("{file}: has shape {shape:?}, but {first} has {first_shape:?}; all must be equal{hint}")]
    SampleShape {
        file: String,
        shape: Vec<usize>,
        first: String,
        first_shape: Vec<usize>,
        hint: &'static str,
    },
    #[error("{file}: line {line} has {got} columns, line {first_line} has {want}")]
    RaggedCsv { file: String, line: u64, got: usize, first_line: u64, want: usize },
    #[error("{file}: line {line}, column {column}: {text:?} is not a number{hint}")]
    CsvNumber { file: String, line: u64, column: usize, text: String, hint: String },

    // Augmentation.
    #[error("{key} = {value}: {expected}")]
    Augment { key: &'static str, value: String, expected: &'static str },

    // Splits.
    #[error("folds = {k}: at least 2 are needed, one to test on and one to train on")]
    TooFewFolds { k: usize },
    #[error(
        "class {class} has {}, too few for {k} folds; {}",
        plural(*units, "distinct sample"),
        if *units < 2 { "record more, or leave the class out".into() } else { format!("use at most {units} folds or record more") }
    )]
    ClassTooSmall { class: Class, units: usize, k: usize },
    #[error(
        "{} cannot fill {k} folds; {}",
        plural(*groups, "group"),
        if *groups < 2 { "split by samples instead".into() } else { format!("use at most {groups} folds") }
    )]
    TooFewGroups { groups: usize, k: usize },
    #[error("class {class} has too few samples to be in the {part} part; record more or change the shares")]
    ClassNotInPart { class: Class, part: &'static str },
    #[error("there are too few groups to fill the {part} part; change the shares or record more groups")]
    NoGroupForPart { part: &'static str },
    #[error("{} cannot be cut in two to hold some back", plural(*samples, "training sample"))]
    NothingToHoldBack { samples: usize },
    #[error("class {class} has {} to train on, fewer than the {count} asked for", plural(*samples, "sample"))]
    TooFewOfClass { class: Class, samples: usize, count: usize },
    #[error("there are no samples to split")]
    NothingToSplit,
    #[error("{what} has {len} entries for {samples} labels; one per sample")]
    SplitLength { what: &'static str, len: usize, samples: usize },
}

/// A class by its number, and by its name where that is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Class {
    /// Its label.
    pub number: u32,
    /// Its name.
    pub name: Option<String>,
}

impl From<u32> for Class {
    fn from(number: u32) -> Self {
        Self { number, name: None }
    }
}

impl Display for Class {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.name {
            Some(name) => f.write_str(name),
            None => write!(f, "{}", self.number),
        }
    }
}

impl Error {
    /// Adds the name of the class that the error speaks of: functions that split see labels only.
    pub fn with_names(mut self, classes: &[String]) -> Self {
        if let Self::ClassTooSmall { class, .. }
        | Self::ClassNotInPart { class, .. }
        | Self::TooFewOfClass { class, .. } = &mut self
        {
            class.name = classes.get(class.number as usize).cloned();
        }
        self
    }

    /// Refuses a file, or a place in one (`grasps.npz: x`).
    pub(crate) fn file(at: impl AsRef<Path>, reason: impl Into<String>) -> Self {
        FileError::new(at.as_ref(), reason).into()
    }

    /// Turns the system's refusal to read a file into an error.
    pub(crate) fn io(file: &(impl AsRef<Path> + ?Sized)) -> impl Fn(io::Error) -> Self {
        move |e| Self::Io { file: file.as_ref().display().to_string(), kind: e.kind(), why: reason(&e) }
    }

    /// Refuses a file that is no CSV.
    pub(crate) fn csv(file: &str) -> impl Fn(csv::Error) -> Self {
        move |e| Self::file(file, format!("is not readable as CSV ({})", e.to_string().to_lowercase()))
    }

    /// Refuses a file of class names.
    pub(crate) fn labels_form(file: &str, why: impl Display) -> Self {
        Self::file(file, format!("{why}; write {{\"classes\": [\"name of 0\", ...]}}"))
    }

    /// Refuses an array that is not among those `held`.
    pub(crate) fn missing(file: &str, array: &str, held: &[String], option: &'static str) -> Self {
        let held = if held.is_empty() { "no arrays".into() } else { held.join(", ") };
        Self::file(file, format!("no array {array}: it holds {held}; name yours with {option} = \"...\""))
    }
}

/// Returns a number with the noun that it counts, in the plural where it is not 1.
pub(crate) fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}
