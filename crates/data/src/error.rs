//! Everything that can be wrong with a data set, in words a user can act on.

use crate::length::length::Length;
use taxel_base::Layout;

/// The result of this crate's functions.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What is wrong, where, and what would do.
///
/// `file` is the path as the user gave it; `at` adds the array (`grasps.npz: x`).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what each field is")]
#[non_exhaustive]
pub enum Error {
    // The path.
    #[error(
        "{file}: no such file or folder; give a {endings}, a folder with data.npz, or a folder with one sub-folder per \
         class"
    )]
    NotFound { file: String, endings: String },
    #[error("{file}: cannot be read: {kind}")]
    Io { file: String, kind: std::io::ErrorKind },
    #[error("{file}: cannot be written: {why}")]
    Write { file: String, why: String },
    #[error(
        "{file}: not a data set; give a {endings} with labels, or a folder with one sub-folder per class"
    )]
    NotADataset { file: String, endings: String },
    #[error("{file}: this build does not read it; build taxel with --features taxel-data/{feature}")]
    NotBuilt { file: String, feature: &'static str },
    #[error("{file}: holds neither data.npz nor class folders{hint}")]
    NoDatasetInFolder { file: String, hint: String },

    // The archive and its arrays.
    #[error("{file}: is empty (0 bytes); copy or record it again")]
    EmptyFile { file: String },
    #[error("{file}: is not a .npz archive ({why}); write it with numpy.savez")]
    NotAnArchive { file: String, why: String },
    #[error("{file}: is cut short or damaged ({why}); copy it again")]
    DamagedArchive { file: String, why: String },
    #[error("{file}: no array {array}: it holds {held}; name yours with {option} = \"...\"")]
    MissingArray { file: String, array: String, held: String, option: &'static str },
    #[error("{file}: {several} could each be {option}; name yours with {option} = \"...\": it holds {held}")]
    AmbiguousArray { file: String, option: &'static str, several: String, held: String },
    #[error("{file}: {first} and {second} are not alike; give both the same type and number of columns")]
    Parts { file: String, first: String, second: String },
    #[error("{at}: is {text:?}; marks are train and test, or 0 and 1")]
    Mark { at: String, text: String },
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
    #[error("{at}: has {bytes} bytes, more than the {limit} allowed; raise limits.max-file-bytes")]
    FileTooLarge { at: String, bytes: u64, limit: u64 },
    #[error("{at}: has shape {shape:?}; {wanted}")]
    Shape { at: String, shape: Vec<u64>, wanted: &'static str },
    #[error("{at}: has shape {shape:?}: axis {axis} is empty; there is nothing to learn from")]
    EmptyAxis { at: String, shape: Vec<u64>, axis: usize },
    #[error("{at}: holds no samples")]
    NoSamples { at: String },
    #[error(
        "{at}{index:?} = {value} does not fit f32 (integers to 2^24 = 16777216, floats to \
         3.4e38); rescale it or save it as f32"
    )]
    NotF32 { at: String, index: Vec<usize>, value: String },
    #[error("{at}{index:?} = {value} is not a whole number; {wanted}")]
    NotWhole { at: String, index: Vec<usize>, value: String, wanted: &'static str },
    #[error("{file}: is not readable as Parquet ({why}); copy it again or write it anew")]
    Parquet { file: String, why: String },
    #[error("{file}: is not readable as HDF5 ({why}); copy it again or write it anew")]
    Hdf5 { file: String, why: String },
    #[error("{file}: is not a MATLAB file of version 5 to 7 ({why}); write it with save(..., '-v7')")]
    NotMatlab { file: String, why: &'static str },
    #[error("{file}: {why}; copy it again or save it anew with save(..., '-v7')")]
    DamagedMatlab { file: String, why: String },
    #[error("{file}: is no MCAP file; record bags with ros2 bag record --storage mcap, or convert them")]
    NotABag { file: String },
    #[error("{file}: {why}; copy it again, or mend it with mcap recover")]
    DamagedBag { file: String, why: String },
    #[error("{file}: {why}")]
    Bag { file: String, why: String },
    #[error(
        "{file}: is one bag, which says no class; give the folder of several, with labels.csv in it (file,label, and of \
         parts of a bag start,end in seconds)"
    )]
    OneBag { file: String },
    #[error(
        "{file}: holds bags but no classes; name bags by class (cup_03.mcap), put them into a folder per class, or write \
         labels.csv (file,label)"
    )]
    BagsWithoutClasses { file: String },
    #[error("{at}{index:?} = {value} does not fit a signed 64-bit integer")]
    NotI64 { at: String, index: Vec<usize>, value: u64 },

    // The content.
    #[error("{file}: {array} has {len} entries but {x} has {samples} samples; one per sample")]
    Length { file: String, array: String, len: usize, x: String, samples: usize },
    #[error("{file}: {at} = {value} is out of range: {names} names {classes} classes (0..{last})")]
    LabelRange { file: String, at: String, value: i64, names: String, classes: usize, last: usize },
    #[error("{file}: {at} = {value} is negative; number the classes from 0")]
    NegativeLabel { file: String, at: String, value: i64 },
    #[error("{file}: no sample in {at} has label {label}{name}; {hint}")]
    EmptyClass { file: String, at: String, label: usize, name: String, hint: &'static str },
    #[error("{file}: attribute = {attribute} is out of range: {y} has {columns} columns (0..{last})")]
    Attribute { file: String, attribute: usize, y: String, columns: usize, last: usize },
    #[error(
        "{file}: {y} has {columns} columns that are not one-hot; choose one with attribute = N (0..{last}), or \
         name them all to learn several attributes: attributes = [\"...\", \"...\"]"
    )]
    Columns { file: String, y: String, columns: usize, last: usize },
    #[error("{file}: all samples are of one class, {class}: nothing to tell apart")]
    OneClass { file: String, class: String },
    #[error("{file}: {at} = {value} is not a group number (0..4294967295); use group_block")]
    GroupRange { file: String, at: String, value: i64 },
    #[error("{sample}: value at {index:?} is {value}; repair the recording or leave it out")]
    NotFinite { sample: String, index: Vec<usize>, value: f32 },
    #[error("{file}: channels: {channel} is out of range: axis 1 of {shape:?} has 0..{last}")]
    ChannelRange { file: String, channel: usize, shape: Vec<usize>, last: usize },
    #[error("{file}: channels: {channel} is listed twice; name each channel once")]
    ChannelTwice { file: String, channel: usize },
    #[error("{file}: channels = []: name at least one channel, or leave the key out")]
    NoChannels { file: String },
    #[error(
        "{file}: {first} and {second} are the same recording, {rows} such rows; set drop = [\"contradictory\"]"
    )]
    Contradiction { file: String, first: String, second: String, rows: usize },
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

    #[error("{at}: its channels have {lengths:?} values; give all channels of a case the same length")]
    ChannelLengths { at: String, lengths: Vec<usize> },
    #[error(
        "{file}: line {line} holds no values with a class; a case is values:class in .ts, class values else"
    )]
    NoClass { file: String, line: u64 },
    #[error(
        "{file}: {array} marks no or all samples for testing; mark some of them with 1, the others with 0"
    )]
    OneSided { file: String, array: String },

    // Class names and facts.
    #[error("{file}: is not valid JSON ({why}); write {{\"classes\": [\"name of 0\", ...]}}")]
    LabelsJson { file: String, why: String },
    #[error("{file}: {why}; write {{\"classes\": [\"name of 0\", ...]}}")]
    LabelsForm { file: String, why: String },
    #[error("{at}: {key} is {value}, {wanted}")]
    Fact { at: String, key: &'static str, value: String, wanted: String },
    #[error("{at}: layout is {layout}, but a sample of shape {shape:?} is not {}", layout.describe())]
    Layout { at: String, layout: Layout, shape: Vec<usize> },
    #[error("{name}: a sample of shape {shape:?} is {}, and has no frames to take apart", layout.describe())]
    Frames { name: String, layout: Layout, shape: Vec<usize> },
    #[error("source = {text:?}: is neither \"simulated: NAME\" nor \"real: NAME\"")]
    Source { text: String },
    #[error("{file}: classes {first} and {second} are both named {name:?}; give each its own name")]
    ClassNamedTwice { file: String, name: String, first: usize, second: usize },

    // What is learned.
    #[error(
        "{source_name}: the targets are values, and classes or levels are needed here; give a data set with labels"
    )]
    NoLabels { source_name: String },
    #[error("{reason}")]
    LearnAttributes { reason: String },
    #[error("{value}: {reason}")]
    KeepClasses { value: String, reason: String },

    // A folder per class.
    #[error("{file}: class folder holds no files; fill or remove it")]
    EmptyClassFolder { file: String },
    #[error(
        "{file}: a folder where recordings are expected; recordings lie in class/file or in class/session/file"
    )]
    NestedFolder { file: String },
    #[error("{file}: lies right in its class folder while others lie in a session; use one of the two")]
    NoSession { file: String },
    #[error("{file}: {why}; write a first line file,label or file,label,group and a line per recording")]
    LabelTable { file: String, why: String },
    #[error("{file}: unknown kind of recording; use {endings}")]
    UnknownExtension { file: String, endings: String },
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
    CsvNumber { file: String, line: u64, column: usize, text: String, hint: &'static str },
    #[error("{file}: holds a header but no rows; one row per time step")]
    CsvNoRows { file: String },
    #[error("{file}: {why}")]
    Table { file: String, why: String },
    #[error("{file}: line {line}, column {column}: {text:?} {why}")]
    TableCell { file: String, line: u64, column: String, text: String, why: &'static str },
    #[error("{file}: is not readable as CSV ({why})")]
    Csv { file: String, why: String },
    #[error("{file}: byte {byte} is not UTF-8; save it as plain text")]
    NotUtf8 { file: String, byte: usize },
    #[error("{file}: is not readable as PNG or JPEG ({why})")]
    Image { file: String, why: String },
    #[error(
        "{file}: is {height} × {width} pixels, more than the {limit} that one image may have; set resize = [height, \
         width], or raise limits.max_pixels"
    )]
    ImageTooLarge { file: String, height: u32, width: u32, limit: u64 },
    #[error(
        "{file}: is {height} × {width} pixels by its head, more than its {bytes} bytes can hold; it is damaged"
    )]
    ImageDamaged { file: String, height: u32, width: u32, bytes: u64 },
    #[error("{file}: has transparent pixels; save it as grey or RGB")]
    Transparent { file: String },

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
    /// What it is called.
    pub name: Option<String>,
}

impl From<u32> for Class {
    fn from(number: u32) -> Self {
        Self { number, name: None }
    }
}

impl std::fmt::Display for Class {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.name {
            Some(name) => f.write_str(name),
            None => write!(f, "{}", self.number),
        }
    }
}

impl Error {
    /// The same with the name of the class that it speaks of, by its label: functions that split see labels only.
    pub fn with_names(mut self, classes: &[String]) -> Self {
        if let Self::ClassTooSmall { class, .. }
        | Self::ClassNotInPart { class, .. }
        | Self::TooFewOfClass { class, .. } = &mut self
        {
            class.name = classes.get(class.number as usize).cloned();
        }
        self
    }

    /// No array of that name among those `held`.
    pub(crate) fn missing(file: &str, array: &str, held: &[String], option: &'static str) -> Self {
        let held = match held {
            [] => "no arrays".into(),
            names => names.join(", "),
        };
        Self::MissingArray { file: file.into(), array: array.into(), held, option }
    }
}

/// A number and what it counts.
pub(crate) fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}
