//! Classes by the names of bags: `cup_03.mcap` is of the class `cup`, in `day1/cup_03.mcap` of the group `day1`.

use crate::Result;
use crate::dataset::labels::by_name;
use crate::formats::bag::path::is_bag;
use crate::layout::listing::{Found, Listing, list};
use crate::layout::order::in_order;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A name without the number that it ends with: `cup` of `cup_03.mcap`.
fn stem(path: &Path) -> String {
    let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
    let name = name.unwrap_or_default().to_string_lossy();
    let is_counting = |c: char| c.is_ascii_digit() || "_-. :()T".contains(c);
    name.trim_end_matches(is_counting).to_string()
}

/// The different names of these paths, numbers left aside.
fn stems<'p>(paths: impl IntoIterator<Item = &'p PathBuf>) -> BTreeSet<String> {
    paths.into_iter().map(|path| stem(path)).collect()
}

/// The bags of a folder by their names; none of a folder that holds something else, or whose folders differ in name:
/// those are classes.
pub(crate) fn per_name(root: &Path, top: &Listing) -> Result<Option<Found>> {
    let mut found = Found { labelled_by: "the names of bags", ..Found::default() };
    found.pass_over(root, top.ignored.iter().cloned());
    let mut sessions = vec![];
    match top.folders.as_slice() {
        [] => found.files = in_order(top.files.clone()),
        folders if stems(folders).len() == 1 => {
            found.pass_over(root, top.files.iter().cloned());
            for folder in in_order(folders.to_vec()) {
                let below = list(&folder)?;
                if !below.folders.is_empty() {
                    return Ok(None);
                }
                found.pass_over(root, below.ignored);
                let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
                sessions.extend(below.files.iter().map(|_| name.clone()));
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
        let numbers = by_name(sessions).1.into_iter().map(i64::from).collect();
        found.groups = Some(("session".into(), numbers));
    }
    Ok(Some(found))
}
