//! Lists the files below a folder that are recordings, with class and group.

use crate::dataset::raw::{NamedColumn, SampleFacts};
use crate::dataset::targets::Values;
use crate::formats::bag::path::{entries, is_bag};
use crate::layout::order::in_order;
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use taxel_base::printable;

/// Recordings below a folder.
#[derive(Debug, Default)]
pub(crate) struct FoundFiles {
    pub files: Vec<PathBuf>,
    /// Position of each file's class in `classes`.
    pub labels: Vec<i64>,
    pub classes: Vec<String>,
    /// The targets in a table, row by row of as many columns as `target_names` names, and the line of each row.
    pub texts: Vec<String>,
    pub target_names: Vec<String>,
    pub lines: Vec<u64>,
    /// Position of each file in its class folder.
    pub positions: Vec<i64>,
    /// Name of the groups, and the group of each file.
    pub groups: Option<NamedColumn>,
    /// The origin of the classes, for messages.
    pub labelled_by: &'static str,
    /// The classes come from a table.
    pub is_table: bool,
    /// Values of the recordings, in place of their classes.
    pub values: Option<Values>,
    /// Not 0 for the recordings that the authors test on, and what says so.
    pub official: Option<NamedColumn>,
    /// Facts about the samples.
    pub facts: SampleFacts,
    /// Files that were passed over, as paths below the folder.
    pub ignored: Vec<String>,
    /// Start and end in seconds of recordings that are parts of files.
    pub spans: Option<Vec<[f64; 2]>>,
    /// How the folder was read, where it could be read otherwise, for people.
    pub read_as: Vec<String>,
}

/// The files and folders directly below a folder.
pub(crate) struct Listing {
    pub folders: Vec<PathBuf>,
    pub files: Vec<PathBuf>,
    /// Hidden files, and files that systems leave behind.
    pub ignored: Vec<PathBuf>,
}

/// Lists a folder; names are sorted.
pub(crate) fn list(folder: &Path) -> Result<Listing> {
    let mut paths = entries(folder)?;
    paths.sort();
    let (ignored, paths): (Vec<_>, Vec<_>) = paths.into_iter().partition(|path| is_junk(path));
    let (folders, files): (Vec<_>, Vec<_>) =
        paths.into_iter().partition(|path| path.is_dir() && !is_bag(path));
    refuse_names(folder, &folders, &files)?;
    Ok(Listing { folders, files, ignored })
}

/// Refuses names that could steer a terminal, and names of folders and bags, which may be classes, that are no text.
fn refuse_names(folder: &Path, folders: &[PathBuf], files: &[PathBuf]) -> Result<()> {
    for path in folders.iter().chain(files) {
        let name = path.file_name().unwrap_or_default();
        if name.to_string_lossy().chars().any(char::is_control) {
            return Err(Error::file(
                folder,
                format!("the name {name:?} holds a control character; rename it"),
            ));
        }
        if name.to_str().is_none() && (folders.contains(path) || is_bag(path)) {
            return Err(Error::file(folder, format!("the name {name:?} is not UTF-8; rename it")));
        }
    }
    Ok(())
}

/// Checks whether a file is hidden, or left behind by a file browser, an archiver or an editor.
fn is_junk(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let known = ["thumbs.db", "desktop.ini", "__macosx"];
    name.starts_with('.') || name.ends_with('~') || known.contains(&name.to_lowercase().as_str())
}

/// Takes files without classes.
pub(crate) fn unsorted(files: Vec<PathBuf>) -> FoundFiles {
    FoundFiles {
        positions: (0..files.len() as i64).collect(),
        files: in_order(files),
        labelled_by: "the class folders",
        ..FoundFiles::default()
    }
}

impl FoundFiles {
    /// Gives the classes their numbers as `order` lists them. Recordings of class folders follow that order; a table
    /// keeps its own.
    pub fn in_order(self, order: &[usize]) -> Self {
        let labels: Vec<i64> =
            self.labels.iter().map(|label| new_position(order, *label as usize) as i64).collect();
        let mut rows: Vec<usize> = (0..labels.len()).collect();
        if !self.is_table {
            rows.sort_by_key(|row| labels[*row]);
        }
        let moved = |values: &[i64]| rows.iter().map(|row| values[*row]).collect();
        Self {
            files: rows.iter().map(|row| self.files[*row].clone()).collect(),
            labels: moved(&labels),
            classes: order.iter().map(|class| self.classes[*class].clone()).collect(),
            positions: moved(&self.positions),
            groups: self.groups.map(|(name, values)| (name, moved(&values))),
            official: self.official.map(|(name, marks)| (name, moved(&marks))),
            spans: self.spans.map(|spans| rows.iter().map(|row| spans[*row]).collect()),
            ..self
        }
    }

    /// Notes files that are no recordings.
    pub fn pass_over(&mut self, root: &Path, paths: impl IntoIterator<Item = PathBuf>) {
        let below = |path: PathBuf| {
            printable(&path.strip_prefix(root).unwrap_or(&path).to_string_lossy()).into_owned()
        };
        self.ignored.extend(paths.into_iter().map(below));
    }
}

/// Returns the place of a label among the classes in another order; a label without a class stays.
pub(crate) fn new_position(order: &[usize], label: usize) -> usize {
    order.iter().position(|class| *class == label).unwrap_or(label)
}

/// Returns the last part of a path.
pub(crate) fn last(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
