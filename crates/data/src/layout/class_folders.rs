//! Lists recordings that lie in folders of their classes, also below `train` and `test`.

use crate::dataset::channel_names::listed_up_to;
use crate::dataset::labels::group_numbers;
use crate::layout::listing::{FoundFiles, Listing, last, list};
use crate::layout::order::in_order;
use crate::layout::split_part::SplitPart;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Names that a message lists.
const MOST: usize = 4;

/// Lists the recordings of `class/file`, or of `class/session/file` with the session as group; below `train` and `test`,
/// as `train/class/file`, these are the official split, and so are sessions of these names.
pub(crate) fn per_class(root: &Path, top: &Listing) -> Result<FoundFiles> {
    let mut gathered = Gathered::default();
    gathered.found.labelled_by = "the class folders";
    gathered.found.pass_over(root, top.ignored.iter().chain(&top.files).cloned());
    let Some(parts) = parts(root, top)? else {
        gathered.add(root, &top.folders)?;
        return gathered.finish(root);
    };
    let mut folders = vec![];
    for (_, folder, listing) in parts {
        gathered.found.pass_over(root, listing.ignored.into_iter().chain(listing.files));
        gathered.add(root, &listing.folders)?;
        folders.resize(gathered.found.files.len(), last(&folder));
    }
    let mut found = gathered.finish(root)?;
    set_split(&mut found, &folders);
    Ok(found)
}

/// Finds the parts of a split that the folders are, the training part first; none where they are classes.
///
/// They are parts where one is called `train` and another one `test` or `val`. Then all others must be parts too, and
/// hold the same classes.
fn parts(root: &Path, top: &Listing) -> Result<Option<Vec<(SplitPart, PathBuf, Listing)>>> {
    let refuse = |why: String| Err(Error::file(root, why));
    let (mut parts, mut others) = (vec![], vec![]);
    for folder in &top.folders {
        match SplitPart::of(&last(folder)) {
            Some(part) => parts.push((part, folder.clone(), list(folder)?)),
            None => others.push(last(folder)),
        }
    }
    parts.sort_by_key(|(part, ..)| *part);
    let names = parts.iter().map(|(_, folder, _)| last(folder)).collect::<Vec<_>>().join(" and ");
    if let ([(_, _, listing)], []) = (parts.as_slice(), others.as_slice())
        && !listing.folders.is_empty()
    {
        return refuse(format!(
            "holds only {names}, a part of a split; give that folder itself, or add the other part"
        ));
    }
    let has_training = parts.first().is_some_and(|(part, ..)| *part == SplitPart::Training);
    let is_split = has_training && parts.last().is_some_and(|(part, ..)| *part != SplitPart::Training);
    if !is_split {
        return Ok(None);
    }
    if !others.is_empty() {
        let others = listed_up_to(&others, MOST);
        return refuse(format!(
            "holds {names}, the parts of a split, beside {others}, which is none; move it away, or, if all are classes, \
             say the class of each file in labels.csv (file,label)"
        ));
    }
    if let Some((_, folder, _)) = parts.iter().find(|(_, _, listing)| listing.folders.is_empty()) {
        let part = last(folder);
        return refuse(format!(
            "holds {names}, the parts of a split, and {part} has no class folders; put its files into {part}/CLASS, or, \
             if the parts are classes, say the class of each file in labels.csv (file,label)"
        ));
    }
    match odd_classes(&parts).as_slice() {
        [] => Ok(Some(parts)),
        odd => refuse(format!(
            "its parts differ in their class folders: {}; add the missing ones or move the others away",
            listed_up_to(odd, MOST)
        )),
    }
}

/// Says which classes are in one part only. A validation part may lack some.
fn odd_classes(parts: &[(SplitPart, PathBuf, Listing)]) -> Vec<String> {
    let mut odd = vec![];
    let names = |listing: &Listing| listing.folders.iter().map(|folder| last(folder)).collect::<Vec<_>>();
    let mut compare = |(_, a, held): &(SplitPart, PathBuf, Listing),
                       (_, b, other): &(SplitPart, PathBuf, Listing)| {
        let other = names(other);
        let missing = names(held).into_iter().filter(|name| !other.contains(name));
        odd.extend(missing.map(|name| format!("{name:?} is in {} and not in {}", last(a), last(b))));
    };
    for part in &parts[1..] {
        compare(part, &parts[0]);
        if part.0 != SplitPart::Validation {
            compare(&parts[0], part);
        }
    }
    odd
}

/// Marks the recordings to test on by the folders of their parts, where these are a split.
fn set_split(found: &mut FoundFiles, folders: &[String]) -> bool {
    let names: Vec<&str> = folders.iter().map(String::as_str).collect();
    let Some(split) = SplitPart::marks(&names) else { return false };
    found.official = Some(("the folder of the part".into(), split.marks));
    found.read_as.push(split.read_as);
    true
}

/// Recordings of class folders.
#[derive(Default)]
struct Gathered {
    found: FoundFiles,
    /// The session of each recording that lies in one.
    sessions: Vec<Option<String>>,
}

impl Gathered {
    /// Adds the recordings of class folders; a class may be there already.
    fn add(&mut self, root: &Path, classes: &[PathBuf]) -> Result<()> {
        for class in classes {
            let before = self.found.files.len();
            self.add_files(root, class)?;
            let (count, name) = (self.found.files.len() - before, last(class));
            let classes = &mut self.found.classes;
            let label = classes.iter().position(|known| *known == name).unwrap_or_else(|| {
                classes.push(name);
                classes.len() - 1
            });
            self.found.labels.extend(std::iter::repeat_n(label as i64, count));
            self.found.positions.extend(0..count as i64);
        }
        Ok(())
    }

    /// Adds the files of a class.
    fn add_files(&mut self, root: &Path, class: &Path) -> Result<()> {
        let listing = list(class)?;
        let is_nested = !listing.folders.is_empty();
        if let (Some(folder), true) = (listing.folders.first(), !listing.files.is_empty()) {
            return Err(Error::NestedFolder { file: folder.display().to_string() });
        }
        self.found.pass_over(root, listing.ignored);
        let parts = if is_nested { listing.folders } else { vec![class.to_path_buf()] };
        for part in in_order(parts) {
            let listing = list(&part)?;
            if let Some(folder) = listing.folders.first() {
                return Err(Error::NestedFolder { file: folder.display().to_string() });
            }
            if is_nested {
                self.found.pass_over(root, listing.ignored);
            }
            if listing.files.is_empty() {
                return Err(Error::file(part, "class folder holds no files; fill or remove it"));
            }
            self.sessions.extend(listing.files.iter().map(|_| is_nested.then(|| last(&part))));
            self.found.files.extend(in_order(listing.files));
        }
        Ok(())
    }

    /// Returns the recordings with sessions as groups, or as the parts of a split.
    fn finish(self, root: &Path) -> Result<FoundFiles> {
        let Self { mut found, sessions } = self;
        let named: Vec<String> = sessions.iter().flatten().cloned().collect();
        if named.is_empty() {
            return Ok(found);
        }
        if let Some(flat) = sessions.iter().position(Option::is_none) {
            let why = "lies right in its class folder while others lie in a session; use one of the two";
            return Err(Error::file(&found.files[flat], why));
        }
        if !set_split(&mut found, &named) {
            let numbers = group_numbers(named).map_err(|why| Error::file(root, why))?;
            found.groups = Some(("session".into(), numbers));
        }
        Ok(found)
    }
}
