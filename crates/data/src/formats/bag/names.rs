//! Finds classes by the names of bags: `cup_03.mcap` is of the class `cup`, in `day1/cup_03.mcap` of the group `day1`.

use crate::dataset::labels::{by_name, group_numbers};
use crate::formats::bag::path::is_bag;
use crate::layout::listing::{FoundFiles, Listing, last, list};
use crate::layout::names_file::NAMES;
use crate::layout::order::in_order;
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Returns a name without the number at its end: `cup` of `cup_03.mcap`.
fn stem(path: &Path) -> String {
    let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
    let name = name.unwrap_or_default().to_string_lossy();
    let is_counting = |c: char| c.is_ascii_digit() || "_-. :()T".contains(c);
    name.trim_end_matches(is_counting).to_string()
}

/// Returns the different names of these paths, without numbers.
fn stems<'p>(paths: impl IntoIterator<Item = &'p PathBuf>) -> BTreeSet<String> {
    paths.into_iter().map(|path| stem(path)).collect()
}

/// Lists the bags of a folder by their names; none where it holds something else, or where its folders differ in name and
/// so are classes.
pub(crate) fn per_name(root: &Path, top: &Listing) -> Result<Option<FoundFiles>> {
    let mut found = FoundFiles { labelled_by: "the names of bags", ..FoundFiles::default() };
    found.pass_over(root, top.ignored.iter().cloned());
    let mut sessions = vec![];
    match top.folders.as_slice() {
        [] => {
            let (about, bags): (Vec<PathBuf>, Vec<PathBuf>) =
                top.files.iter().cloned().partition(|path| last(path) == NAMES);
            found.pass_over(root, about);
            found.files = in_order(bags);
        }
        folders if stems(folders).len() == 1 => {
            found.pass_over(root, top.files.iter().cloned());
            for folder in in_order(folders.to_vec()) {
                let below = list(&folder)?;
                if !below.folders.is_empty() {
                    return Ok(None);
                }
                found.pass_over(root, below.ignored);
                sessions.extend(below.files.iter().map(|_| last(&folder)));
                found.files.extend(in_order(below.files));
            }
        }
        _ => return Ok(None),
    }
    let classes = stems(&found.files);
    if classes.len() < 2 || classes.contains("") || !found.files.iter().all(|path| is_bag(path)) {
        return Ok(None);
    }
    let (classes, labels) = by_name(found.files.iter().map(|path| stem(path)).collect());
    let mut counts = vec![0; classes.len()];
    let position = |label: &u32| {
        counts[*label as usize] += 1;
        counts[*label as usize] - 1
    };
    found.positions = labels.iter().map(position).collect();
    found.labels = labels.into_iter().map(i64::from).collect();
    let example = found.files[0].strip_prefix(root).unwrap_or(&found.files[0]).display().to_string();
    let by_folder = if sessions.is_empty() { "" } else { ", groups by their folders" };
    let class = stem(&found.files[0]);
    found.read_as = vec![format!("classes by the names of bags, as {example} is of {class}{by_folder}")];
    found.classes = classes;
    if !sessions.is_empty() {
        let numbers = group_numbers(sessions).map_err(|why| Error::file(root, why))?;
        found.groups = Some(("session".into(), numbers));
    }
    Ok(Some(found))
}
