//! The traits of readers, which take a path and return recordings, and of formats whose files hold one recording each.

use crate::dataset::raw::Raw;
use crate::ending::has_ending;
use crate::formats::bag::path::how_to_convert;
use crate::layout::listing::FoundFiles;
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::io::ErrorKind;
use std::path::Path;
use taxel_base::Layout;

/// One row of the table of what can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// Its name.
    pub name: &'static str,
    /// Endings of its files, without the point; none of a folder.
    pub endings: &'static [&'static str],
    /// How recordings lie in it.
    pub holds: &'static str,
    /// The samples that they become, with their axes.
    pub becomes: &'static str,
}

impl Format {
    /// Checks whether a path has one of its endings.
    pub(crate) fn names(&self, path: &Path) -> bool {
        has_ending(path, self.endings)
    }
}

/// The use that recordings are read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A data set to learn from: every sample has a label.
    Learn,
    /// Recordings for a model that takes samples of `rank` axes; labels may be missing.
    Predict { rank: usize },
}

/// A path, and the use that it is read for.
#[derive(Clone, Copy)]
pub(crate) struct Place<'p> {
    pub path: &'p Path,
    pub purpose: Purpose,
    /// All readers, in their order.
    pub readers: &'static [&'static dyn Reader],
}

impl Place<'_> {
    /// Returns the path as messages name it.
    pub fn file(&self) -> String {
        self.path.display().to_string()
    }

    /// Checks whether samples without labels are refused.
    pub fn needs_labels(&self) -> bool {
        self.purpose == Purpose::Learn
    }

    /// Finds the format in which a file is one recording.
    pub fn format_of(&self, path: &Path) -> Option<&'static dyn FileFormat> {
        self.readers.iter().filter_map(|reader| reader.file_format()).find(|format| format.takes(path))
    }

    /// Lists the endings of the files that some readers read, as a message says them: `.csv, .npy or .png`.
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

    /// Adds to an error about a missing file the endings that may be given instead.
    pub fn with_advice(&self, error: Error) -> Error {
        match error {
            Error::Io { file, kind: ErrorKind::NotFound, .. } => {
                Error::NotFound { file, endings: self.endings(|_| true) }
            }
            other => other,
        }
    }

    /// Refuses a file that no format of single recordings takes.
    pub fn unknown_extension(&self, file: String) -> Error {
        if let Some(how) = how_to_convert(Path::new(&file)) {
            return Error::file(file, how);
        }
        let endings = self.endings(|reader| reader.file_format().is_some());
        Error::file(file, format!("unknown kind of recording; use {endings}"))
    }
}

/// Reads what lies at a path. The readers and their order are in `formats/mod.rs`.
pub(crate) trait Reader: Sync {
    /// Returns its rows in the table of what can be read.
    fn formats(&self) -> &'static [Format];

    /// Checks whether it reads the file or folder at a place.
    fn recognises(&self, place: &Place, options: &ReadOptions) -> bool;

    /// Reads the file or folder at a place.
    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw>;

    /// Checks whether its files can be whole data sets, labels included.
    fn reads_sets(&self) -> bool {
        true
    }

    /// Returns its format, where a file in a folder of recordings is one recording.
    fn file_format(&self) -> Option<&dyn FileFormat> {
        None
    }
}

/// Reads files of which each is one recording.
pub(crate) trait FileFormat: Sync {
    /// Returns the name of a file in messages: `CSV`, `an image`.
    fn name(&self) -> &'static str;

    /// Returns its row in the table of what can be read.
    fn format(&self) -> &'static Format;

    /// Checks whether a path is named like a file of this format.
    fn takes(&self, path: &Path) -> bool {
        self.format().names(path)
    }

    /// Returns the axes of a sample that has `rank` of them; none where the format does not say.
    fn layout(&self, _rank: usize) -> Option<Layout> {
        None
    }

    /// Ends the message about samples that differ in more than their length: how to make them equal.
    fn hint(&self) -> &'static str {
        " but for time"
    }

    /// Returns the bits of a pixel in values of a type; none where they are no pixels.
    fn depth(&self, _dtype: &str) -> Option<u8> {
        None
    }

    /// Checks whether an option (`x`, `resize`) applies to these files.
    fn takes_option(&self, _option: &str) -> bool {
        false
    }

    /// Reads the shape of the sample from the head of a file, where it is there.
    fn shape(&self, _path: &Path, _options: &ReadOptions) -> Result<Option<Vec<usize>>> {
        Ok(None)
    }

    /// Reads one file. Formats whose files are read together leave this out.
    fn read(&self, path: &Path, _options: &ReadOptions) -> Result<Sample> {
        Err(Error::NoSamples { at: path.display().to_string() })
    }

    /// Reads all files below `root` together, where they share a clock; none where each is read by [`read`](Self::read).
    fn read_together(
        &self,
        _root: &Path,
        _found: &FoundFiles,
        _options: &ReadOptions,
    ) -> Option<Result<Recorded>> {
        None
    }
}

/// One recording.
pub(crate) struct Sample {
    pub shape: Vec<usize>,
    pub values: Vec<f32>,
    pub dtype: String,
    /// It was turned as its EXIF says.
    pub is_turned: bool,
}

/// Recordings of files in one format.
pub(crate) struct Recorded {
    pub x: Ragged,
    pub dtype: String,
    pub layout: Option<Layout>,
    /// The file of each, below the folder.
    pub origins: Vec<String>,
    /// Readings per second (Hz), as time stamps say it.
    pub rate: Option<f64>,
    /// How files were taken, for the card.
    pub read_as: Vec<String>,
    /// Doubts about the files, and how to fix each.
    pub warnings: Vec<String>,
    /// Columns that are no channels, and why.
    pub ignored: Vec<String>,
    /// Topics that were read.
    pub topics: Vec<String>,
    /// Bits of a pixel, of images.
    pub depth: Option<u8>,
    /// Number of samples of each file where they are not one each: the frames of bags in colour.
    pub frames: Vec<usize>,
    /// Names of the channels, in their order; empty where the files name none.
    pub channel_names: Vec<String>,
}

impl Recorded {
    /// Takes recordings of which nothing else is known.
    pub fn of(x: Ragged, dtype: String, layout: Option<Layout>, origins: Vec<String>) -> Self {
        Self {
            x,
            dtype,
            layout,
            origins,
            rate: None,
            read_as: vec![],
            warnings: vec![],
            ignored: vec![],
            topics: vec![],
            depth: None,
            frames: vec![],
            channel_names: vec![],
        }
    }
}
