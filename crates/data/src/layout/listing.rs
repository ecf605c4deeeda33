//! Which files below a folder are recordings, of which class and group.

use crate::dataset::labels::by_name;
use crate::dataset::raw::Facts;
use crate::formats::bag::path::is_bag;
use crate::layout::order::in_order;
use crate::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// Recordings below a folder.
#[derive(Debug, Default)]
pub(crate) struct Found {
    pub files: Vec<PathBuf>,
    /// Position of each file's class in `classes`.
    pub labels: Vec<i64>,
    pub classes: Vec<String>,
    /// Position of each file in its class folder.
    pub positions: Vec<i64>,
    /// What the groups are, and the number of each file's.
    pub groups: Option<(String, Vec<i64>)>,
    /// What says the classes, for messages.
    pub labelled_by: &'static str,
    /// Whether a table does.
    pub is_table: bool,
    /// What is said of the readings.
    pub facts: Facts,
    /// What was passed over, as paths below the folder.
    pub ignored: Vec<String>,
    /// Of recordings that are parts of files, from when to when in seconds.
    pub spans: Option<Vec<[f64; 2]>>,
    /// How the folder was taken where it could be taken otherwise, for people.
    pub read_as: Vec<String>,
}

/// What lies right under a folder.
pub(crate) struct Listing {
    pub folders: Vec<PathBuf>,
    pub files: Vec<PathBuf>,
    /// Hidden files and what systems leave behind.
    pub ignored: Vec<PathBuf>,
}

/// Lists a folder; names are sorted.
pub(crate) fn list(folder: &Path) -> Result<Listing> {
    let io = |e: std::io::Error| Error::Io { file: folder.display().to_string(), kind: e.kind() };
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        paths.push(entry.map_err(io)?.path());
    }
    paths.sort();
    let (ignored, paths): (Vec<_>, Vec<_>) = paths.into_iter().partition(|path| is_junk(path));
    let (folders, files) = paths.into_iter().partition(|path| path.is_dir() && !is_bag(path));
    Ok(Listing { folders, files, ignored })
}

/// Hidden, or left behind by a file browser, an archiver or an editor.
fn is_junk(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let known = ["thumbs.db", "desktop.ini", "__macosx"];
    name.starts_with('.') || name.ends_with('~') || known.contains(&name.to_lowercase().as_str())
}

/// The recordings of `class/file`, or of `class/session/file` with the session as group.
pub(crate) fn per_class(root: &Path, top: &Listing) -> Result<Found> {
    let mut found = Found { labelled_by: "the class folders", ..Found::default() };
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
                return Err(Error::EmptyClassFolder { file: part.display().to_string() });
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
            return Err(Error::NoSession { file: found.files[flat].display().to_string() });
        }
        let (_, numbers) = by_name(named);
        found.groups = Some(("session".into(), numbers.into_iter().map(i64::from).collect()));
    }
    Ok(found)
}

/// Files of which nobody says what class they are.
pub(crate) fn unsorted(files: Vec<PathBuf>) -> Found {
    Found {
        positions: (0..files.len() as i64).collect(),
        files: in_order(files),
        labelled_by: "the class folders",
        ..Found::default()
    }
}

impl Found {
    /// Numbers the classes as `order` lists them. Recordings of class folders follow that order; those of a table
    /// stay as it lists them.
    pub fn in_order(self, order: &[usize]) -> Self {
        let new =
            |label: i64| order.iter().position(|class| *class as i64 == label).map_or(label, |at| at as i64);
        let labels: Vec<i64> = self.labels.iter().map(|label| new(*label)).collect();
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
            spans: self.spans.map(|spans| rows.iter().map(|row| spans[*row]).collect()),
            ..self
        }
    }

    /// Notes what is no recording.
    pub fn pass_over(&mut self, root: &Path, paths: impl IntoIterator<Item = PathBuf>) {
        let below = |path: PathBuf| path.strip_prefix(root).unwrap_or(&path).display().to_string();
        self.ignored.extend(paths.into_iter().map(below));
    }
}

fn last(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
