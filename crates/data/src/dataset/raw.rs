//! The data set that a reader returns, before its content is checked.

use crate::dataset::source::Source;
use crate::dataset::targets::{Quantity, Values};
use crate::formats::table::options::TableOptions;
use crate::length::ragged::Ragged;
use crate::tare::Tare;
use crate::targets::steps::StepTargets;
use std::collections::BTreeMap;
use taxel_base::Layout;

/// The name of an array, and a number for each sample.
pub(crate) type NamedColumn = (String, Vec<i64>);

/// A data set as stored: structurally sound, content unchecked.
///
/// A reader writes the fields that it knows over `..Raw::default()`. This is all the builder that it needs: setters would
/// name every field again, and move all recordings once more.
#[derive(Debug)]
pub(crate) struct Raw {
    /// The last part of the path, without extension.
    pub name: String,
    /// The path of the archive or folder, for messages.
    pub file: String,
    /// Type of the stored values.
    pub dtype: String,
    /// Axes of a sample by the format; none of a format that does not say.
    pub format: Option<Layout>,
    /// Samples, all channels, each as long as it was recorded.
    pub x: Ragged,
    /// Names of all channels, in their order; empty where the files name none.
    pub channel_names: Vec<String>,
    /// Names of the arrays of samples and labels, for messages.
    pub x_name: String,
    pub y_name: String,
    /// Labels row by row, `columns` each; may differ from N in number.
    pub y: Vec<i64>,
    pub columns: usize,
    pub names: Option<Names>,
    /// Values row by row, in place of labels.
    pub values: Option<Values>,
    /// Where rows of labels or values are time steps, in place of recordings.
    pub steps: Option<StepTargets>,
    /// The array that says to which recording each row of `x` belonged.
    pub recording: Option<String>,
    /// The resting values that were taken off `x`.
    pub tared: Option<Tare>,
    pub facts: SampleFacts,
    pub groups: Option<NamedColumn>,
    /// Not 0 for samples that the authors test on, with the array's name.
    pub official: Option<NamedColumn>,
    /// File of each sample, or `x[17]`.
    pub origins: Vec<String>,
    /// Arrays of the archive that were not read, such as `trial`.
    pub others: Vec<String>,
    /// Files of a folder that were passed over, such as `.DS_Store`.
    pub ignored: Vec<String>,
    /// How the file was read, where it could be read otherwise, for people.
    pub read_as: Vec<String>,
    /// Doubts about the files that may spoil a score, and how to fix each, for people.
    pub warnings: Vec<String>,
    /// Roles of the columns of a table.
    pub table: Option<TableOptions>,
    /// Topics of bags that were read.
    pub topics: Vec<String>,
    /// `origins` are paths below `file`.
    pub is_folder: bool,
}

impl Default for Raw {
    /// Returns no samples, without labels, from arrays called `x` and `y`.
    fn default() -> Self {
        Self {
            name: String::new(),
            file: String::new(),
            dtype: String::new(),
            format: None,
            x: Ragged::default(),
            channel_names: vec![],
            x_name: "x".into(),
            y_name: "y".into(),
            y: vec![],
            columns: 1,
            names: None,
            values: None,
            steps: None,
            recording: None,
            tared: None,
            facts: SampleFacts::default(),
            groups: None,
            official: None,
            origins: vec![],
            others: vec![],
            ignored: vec![],
            read_as: vec![],
            warnings: vec![],
            table: None,
            topics: vec![],
            is_folder: false,
        }
    }
}

impl Raw {
    /// Counts the rows of targets that there must be: one for each recording or, of time steps, for each of these.
    pub fn target_rows(&self) -> usize {
        self.steps.as_ref().map_or(self.x.len(), StepTargets::rows)
    }

    /// Returns the name of a sample in messages: its file, or its place in a file.
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
    /// The user wrote them; otherwise the reader numbered them.
    pub is_given: bool,
}

/// SampleFacts about the samples, from the file of class names.
#[derive(Debug, Clone, Default)]
pub(crate) struct SampleFacts {
    /// The path of that file, for messages.
    pub file: String,
    /// Source of the samples.
    pub source: Option<Source>,
    /// Readings of each recording that are at rest, where nobody says others.
    pub tare: Option<Tare>,
    /// Axes of a sample.
    pub layout: Option<Layout>,
    /// Unit of the values.
    pub unit: Option<String>,
    /// Time steps per second (Hz).
    pub rate: Option<f64>,
    /// The rate (Hz) of time stamps, to which recordings were brought before any rule for their length.
    pub stamped: Option<f64>,
    /// Bits of a pixel.
    pub depth: Option<u8>,
    /// The highest value that the sensor gives.
    pub full_scale: Option<f32>,
    /// The array of groups.
    pub group_array: Option<String>,
    /// The array that marks the samples to test on.
    pub test_array: Option<String>,
    /// Origin of each sample.
    pub origins: Option<Vec<String>>,
    /// Names of the channels, in their order.
    pub channels: Option<Vec<String>>,
    /// Quantities of targets that are values, in the order of their columns.
    pub quantities: Option<Vec<Quantity>>,
    /// Quantities of arrays that hold values beside the labels, by the name of the array.
    pub values: BTreeMap<String, Quantity>,
}

impl SampleFacts {
    /// Returns the quantities of arrays that hold values beside the labels; none where one of them is no such array.
    pub fn values_of<'n>(&self, mut arrays: impl Iterator<Item = &'n str>) -> Option<Vec<Quantity>> {
        arrays.try_fold(vec![], |mut named, array| {
            named.push(self.values.get(array)?.clone());
            Some(named)
        })
    }
}

/// Name of the file of arrays in a data set that is a folder.
pub(crate) const DATA: &str = "data.npz";

/// Returns the name of a path without its extension; `data.npz` goes by its folder.
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
