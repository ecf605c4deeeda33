//! What a reader brings home before anything about the content is judged.

use crate::dataset::digest::RowHash;
use crate::dataset::source::Source;
use crate::dataset::targets::{Quantity, Values};
use crate::formats::table::options::TableOptions;
use crate::length::ragged::Ragged;
use taxel_base::Layout;

/// A data set as stored: structurally sound, content unchecked.
#[derive(Debug)]
pub(crate) struct Raw {
    /// The last part of the path, without extension.
    pub name: String,
    /// The path of the archive or folder, for messages.
    pub file: String,
    /// Type of the stored values.
    pub dtype: String,
    /// What the axes of a sample are by the format; none of a format that does not say.
    pub format: Option<Layout>,
    /// Samples, all channels, each as long as it was recorded.
    pub x: Ragged,
    /// Names of the arrays of samples and labels, for messages.
    pub x_name: String,
    pub y_name: String,
    /// Labels row by row, `columns` each; may differ from N in number.
    pub y: Vec<i64>,
    pub columns: usize,
    pub names: Option<Names>,
    /// Values row by row, in place of labels.
    pub values: Option<Values>,
    pub facts: Facts,
    pub groups: Option<(String, Vec<i64>)>,
    /// Not 0 for samples that the authors test on, with the array's name.
    pub official: Option<(String, Vec<i64>)>,
    /// File of each sample, or `x[17]`.
    pub origins: Vec<String>,
    /// Hash of each full recorded sample.
    pub row_hash: Vec<RowHash>,
    /// Arrays of the archive that were not read, such as `trial`.
    pub others: Vec<String>,
    /// Files of a folder that were passed over, such as `.DS_Store`.
    pub ignored: Vec<String>,
    /// How the file was taken where it could be taken otherwise, for people.
    pub read_as: Vec<String>,
    /// Of a table what its columns were.
    pub table: Option<TableOptions>,
    /// Of bags the topics that were read.
    pub topics: Vec<String>,
    /// Whether `origins` are paths below `file`.
    pub is_folder: bool,
}

impl Raw {
    /// Samples of which nothing else is known: without labels, called `x`, of the type of no file.
    pub fn new(name: String, file: String, x: Ragged, origins: Vec<String>) -> Self {
        Self {
            name,
            file,
            dtype: String::new(),
            format: None,
            x,
            x_name: "x".into(),
            y_name: "y".into(),
            y: vec![],
            columns: 1,
            names: None,
            values: None,
            facts: Facts::default(),
            groups: None,
            official: None,
            origins,
            row_hash: vec![],
            others: vec![],
            ignored: vec![],
            read_as: vec![],
            topics: vec![],
            table: None,
            is_folder: false,
        }
    }

    /// Says the type of the stored values, and what the axes of a sample are where the format says it.
    pub fn stored_as(self, dtype: impl Into<String>, format: Option<Layout>) -> Self {
        Self { dtype: dtype.into(), format, ..self }
    }

    /// Names the arrays of samples and labels, for messages.
    pub fn called(self, x_name: impl Into<String>, y_name: impl Into<String>) -> Self {
        Self { x_name: x_name.into(), y_name: y_name.into(), ..self }
    }

    /// Adds labels row by row, `columns` each, and their names.
    pub fn with_labels(self, y: Vec<i64>, columns: usize, names: Option<Names>) -> Self {
        Self { y, columns, names, ..self }
    }

    /// Adds values in place of labels.
    pub fn with_values(self, values: Option<Values>) -> Self {
        Self { values, ..self }
    }

    /// Adds what is said of the readings.
    pub fn with_facts(self, facts: Facts) -> Self {
        Self { facts, ..self }
    }

    /// Adds the group of each sample, and what the groups are.
    pub fn with_groups(self, groups: Option<(String, Vec<i64>)>) -> Self {
        Self { groups, ..self }
    }

    /// Adds the marks of the samples that the authors test on, and the name of their array.
    pub fn with_official(self, official: Option<(String, Vec<i64>)>) -> Self {
        Self { official, ..self }
    }

    /// Adds the hash of each full recorded sample.
    pub fn with_hashes(self, row_hash: Vec<RowHash>) -> Self {
        Self { row_hash, ..self }
    }

    /// Notes what was passed over: arrays or columns, and files.
    pub fn passing_over(self, others: Vec<String>, ignored: Vec<String>) -> Self {
        Self { others, ignored, ..self }
    }

    /// Says how the file was taken where it could be taken otherwise.
    pub fn read_as(self, read_as: Vec<String>) -> Self {
        Self { read_as, ..self }
    }

    /// Says what the columns of a table were.
    pub fn of_table(self, table: TableOptions) -> Self {
        Self { table: Some(table), ..self }
    }

    /// Says which topics of bags were read.
    pub fn of_topics(self, topics: Vec<String>) -> Self {
        Self { topics, ..self }
    }

    /// Says that origins are paths below the folder.
    pub fn of_folder(self) -> Self {
        Self { is_folder: true, ..self }
    }

    /// A sample for messages: its file, or its place in a file.
    pub fn sample_name(&self, row: usize) -> String {
        format!("{}{}{}", self.file, if self.is_folder { "/" } else { ": " }, self.origins[row])
    }
}

/// Class names and the file they come from.
#[derive(Debug, Clone)]
pub(crate) struct Names {
    /// Short, for messages: `labels.json`.
    pub file: String,
    /// Per label column the names of 0, 1, ...
    pub columns: Vec<Vec<String>>,
    /// Whether somebody wrote them; otherwise the reader numbered them.
    pub is_told: bool,
}

/// What the file of class names says of the readings.
#[derive(Debug, Clone, Default)]
pub(crate) struct Facts {
    /// The path of that file, for messages.
    pub file: String,
    /// Where the samples come from.
    pub source: Option<Source>,
    /// What the axes of a sample are.
    pub layout: Option<Layout>,
    /// Unit of the readings.
    pub unit: Option<String>,
    /// Readings per second (Hz).
    pub rate: Option<f64>,
    /// The rate (Hz) of time stamps, to which recordings were brought before any rule for their length.
    pub stamped: Option<f64>,
    /// The highest reading that the sensor gives.
    pub full_scale: Option<f32>,
    /// The array of groups.
    pub group_array: Option<String>,
    /// The array that marks the samples to test on.
    pub test_array: Option<String>,
    /// Where each sample comes from.
    pub origins: Option<Vec<String>>,
    /// What targets that are values are, in the order of their columns.
    pub quantities: Option<Vec<Quantity>>,
}

/// The arrays of a data set that is a folder.
pub(crate) const DATA: &str = "data.npz";

/// The name of a path without its extension; `data.npz` goes by its folder.
pub(crate) fn name_of(path: &std::path::Path) -> String {
    let text = |name: Option<&std::ffi::OsStr>| name.map(|n| n.to_string_lossy().into_owned());
    let absolute = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let named = if absolute.is_dir() {
        text(absolute.file_name())
    } else if absolute.file_name().is_some_and(|n| n == DATA) {
        text(absolute.parent().and_then(|folder| folder.file_name()))
    } else {
        text(absolute.file_stem())
    };
    // The root of a file system has no name.
    named.unwrap_or_else(|| "data".into())
}
