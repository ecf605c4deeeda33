//! Lists the files below a folder that are recordings, with class and group.

use crate::dataset::labels::by_name;
use crate::dataset::raw::{NamedColumn, SampleFacts};
use crate::formats::bag::path::{entries, is_bag};
use crate::layout::order::in_order;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Recordings below a folder.
#[derive(Debug, Default)]
pub(crate) struct FoundFiles {
    pub files: Vec<PathBuf>,
    /// Position of each file's class in `classes`.
    pub labels: Vec<i64>,
    pub classes: Vec<String>,
    /// Position of each file in its class folder.
    pub positions: Vec<i64>,
    /// Name of the groups, and the group of each file.
    pub groups: Option<NamedColumn>,
    /// What marks the files to test on, and the mark of each file.
    pub official: Option<NamedColumn>,
    /// The origin of the classes, for messages.
    pub labelled_by: &'static str,
    /// The classes come from a table.
    pub is_table: bool,
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
    let (folders, files) = paths.into_iter().partition(|path| path.is_dir() && !is_bag(path));
    Ok(Listing { folders, files, ignored })
}

/// Checks whether a file is hidden, or left behind by a file browser, an archiver or an editor.
fn is_junk(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let known = ["thumbs.db", "desktop.ini", "__macosx"];
    name.starts_with('.') || name.ends_with('~') || known.contains(&name.to_lowercase().as_str())
}

/// Lists the recordings of `class/file`, or of `class/session/file` with the session as group.
pub(crate) fn per_class(root: &Path, top: &Listing) -> Result<FoundFiles> {
    let mut found = FoundFiles { labelled_by: "the class folders", ..FoundFiles::default() };
    found.pass_over(root, top.ignored.iter().chain(&top.files).cloned());
    let mut sessions: Vec<Option<String>> = vec![];
    for (label, class) in top.folders.iter().enumerate() {
        let listing = list(class)?;
        let is_nested = !listing.folders.is_empty();
        if let (Some(folder), true) = (listing.folders.first(), !listing.files.is_empty()) {
            return Err(Error::NestedFolder { file: folder.display().to_string() });
        }
        found.pass_over(root, listing.ignored);
        let parts = if is_nested { listing.folders } else { vec![class.clone()] };
        let before = found.files.len();
        for part in in_order(parts) {
            let listing = list(&part)?;
            if let Some(folder) = listing.folders.first() {
                return Err(Error::NestedFolder { file: folder.display().to_string() });
            }
            if is_nested {
                found.pass_over(root, listing.ignored);
            }
            if listing.files.is_empty() {
                return Err(Error::file(part, "class folder holds no files; fill or remove it"));
            }
            sessions.extend(listing.files.iter().map(|_| is_nested.then(|| last(&part))));
            found.files.extend(in_order(listing.files));
        }
        let count = found.files.len() - before;
        found.labels.extend(std::iter::repeat_n(label as i64, count));
        found.positions.extend(0..count as i64);
        found.classes.push(last(class));
    }
    let named: Vec<String> = sessions.iter().flatten().cloned().collect();
    if !named.is_empty() {
        if let Some(flat) = sessions.iter().position(Option::is_none) {
            let why = "lies right in its class folder while others lie in a session; use one of the two";
            return Err(Error::file(&found.files[flat], why));
        }
        let (_, numbers) = by_name(named);
        found.groups = Some(("session".into(), numbers.into_iter().map(i64::from).collect()));
    }
    Ok(found)
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
        let below = |path: PathBuf| path.strip_prefix(root).unwrap_or(&path).display().to_string();
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
