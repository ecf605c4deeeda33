//! Readers: what takes a path and brings home recordings, and the formats whose files hold one recording each.

use crate::dataset::digest::RowHash;
use crate::dataset::raw::Raw;
use crate::layout::listing::Found;
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::io::ErrorKind;
use std::path::Path;
use taxel_base::Layout;

/// One row of the table of what can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// What it is called.
    pub name: &'static str,
    /// Endings of its files, without the point; none of a folder.
    pub endings: &'static [&'static str],
    /// How recordings lie in it.
    pub holds: &'static str,
    /// What the samples become, with their axes.
    pub becomes: &'static str,
}

impl Format {
    /// Whether a path has one of its endings.
    pub(crate) fn names(&self, path: &Path) -> bool {
        has_ending(path, self.endings)
    }
}

/// Whether a path ends in one of `endings`, in small or capital letters.
pub(crate) fn has_ending(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|own| endings.iter().any(|ending| own.eq_ignore_ascii_case(ending)))
}

/// What recordings are read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A data set to learn from: every sample has a label.
    Learn,
    /// Recordings for a model that takes samples of `rank` axes; labels may be missing.
    Predict { rank: usize },
}

/// A path, and what it is read for.
#[derive(Clone, Copy)]
pub(crate) struct Place<'p> {
    pub path: &'p Path,
    pub purpose: Purpose,
    /// All readers, in their order.
    pub readers: &'static [&'static dyn Reader],
}

impl Place<'_> {
    /// The path as messages name it.
    pub fn file(&self) -> String {
        self.path.display().to_string()
    }

    /// Whether samples without labels are refused.
    pub fn needs_labels(&self) -> bool {
        self.purpose == Purpose::Learn
    }

    /// The format in which a file is one recording.
    pub fn format_of(&self, path: &Path) -> Option<&'static dyn FileFormat> {
        self.readers.iter().filter_map(|reader| reader.file_format()).find(|format| format.takes(path))
    }

    /// Lists the endings of what some readers read, as a message says them: `.csv, .npy or .png`.
    pub fn endings(&self, of: fn(&dyn Reader) -> bool) -> String {
        let mut endings: Vec<String> = vec![];
        for reader in self.readers.iter().filter(|reader| of(**reader)) {
            for ending in reader.formats().iter().flat_map(|format| format.endings) {
                let ending = format!(".{ending}");
                if !endings.contains(&ending) {
                    endings.push(ending);
                }
            }
        }
        match endings.split_last() {
            Some((last, first)) if !first.is_empty() => format!("{} or {last}", first.join(", ")),
            _ => endings.concat(),
        }
    }

    /// Refuses a path where nothing lies.
    pub fn not_found(&self) -> Error {
        Error::NotFound { file: self.file(), endings: self.endings(|_| true) }
    }

    /// Says what may be given instead, where an error says that a file is not there.
    pub fn with_advice(&self, error: Error) -> Error {
        match error {
            Error::Io { file, kind: ErrorKind::NotFound } => {
                Error::NotFound { file, endings: self.endings(|_| true) }
            }
            other => other,
        }
    }

    /// Refuses a file that no format of single recordings takes.
    pub fn unknown_extension(&self, file: String) -> Error {
        Error::UnknownExtension { file, endings: self.endings(|reader| reader.file_format().is_some()) }
    }
}

/// Reads what lies at a path. The readers and their order are in `formats/mod.rs`.
pub(crate) trait Reader: Sync {
    /// The rows of this reader in the table of what can be read.
    fn formats(&self) -> &'static [Format];

    /// Whether it reads what lies at a place.
    fn recognises(&self, place: &Place, options: &ReadOptions) -> bool;

    /// Reads what lies there.
    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw>;

    /// Whether what it reads can be a whole data set, labels included.
    fn reads_sets(&self) -> bool {
        true
    }

    /// How a file in a folder of recordings is read, where one of its files is one recording.
    fn file_format(&self) -> Option<&dyn FileFormat> {
        None
    }
}

/// Reads files of which each is one recording.
pub(crate) trait FileFormat: Sync {
    /// What a file is, for messages: `CSV`, `an image`.
    fn name(&self) -> &'static str;

    /// Its row in the table of what can be read.
    fn format(&self) -> &'static Format;

    /// Whether a path is named like a file of this format.
    fn takes(&self, path: &Path) -> bool {
        self.format().names(path)
    }

    /// What the axes of a sample of so many are; none where the file does not say.
    fn layout(&self, rank: usize) -> Option<Layout>;

    /// How samples that differ in more than their length are made equal, as the end of a message.
    fn hint(&self) -> &'static str {
        " but for time"
    }

    /// Whether an option (`x`, `resize`) says something of these files.
    fn takes_option(&self, _option: &str) -> bool {
        false
    }

    /// The shape of the sample in a file, where its head says it before the file is read.
    fn shape(&self, _path: &Path, _options: &ReadOptions) -> Result<Option<Vec<usize>>> {
        Ok(None)
    }

    /// Reads one file.
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Sample>;

    /// Reads all files below `root` where they share a clock; none where each is read alone.
    fn read_together(
        &self,
        _root: &Path,
        _found: &Found,
        _options: &ReadOptions,
    ) -> Option<Result<Recorded>> {
        None
    }
}

/// One recording.
pub(crate) struct Sample {
    pub shape: Vec<usize>,
    pub values: Vec<f32>,
    pub hash: RowHash,
    pub dtype: String,
}

/// Recordings of files in one format.
pub(crate) struct Recorded {
    pub x: Ragged,
    pub dtype: String,
    pub layout: Option<Layout>,
    pub row_hash: Vec<RowHash>,
    /// The file of each, below the folder.
    pub origins: Vec<String>,
    /// Readings per second (Hz), as time stamps say it.
    pub rate: Option<f64>,
    /// How files were taken, for the card.
    pub read_as: Vec<String>,
    /// Topics that were read.
    pub topics: Vec<String>,
}
