//! Lists recordings that lie in folders of the parts of a split: `train/class/file` and `test/class/file`.

use crate::dataset::labels::by_name;
use crate::layout::listing::{FoundFiles, Listing, last, list, per_class};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// A part of a split.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Train,
    Validation,
    Test,
}

impl Part {
    /// Returns the part that a folder is called; none of a class.
    fn of(folder: &Path) -> Option<Self> {
        match last(folder).to_lowercase().as_str() {
            "train" | "training" => Some(Self::Train),
            "val" | "valid" | "validation" | "dev" => Some(Self::Validation),
            "test" | "testing" => Some(Self::Test),
            _ => None,
        }
    }
}

/// Lists the recordings of a folder whose folders are parts of a split, with the marks of those to test on. None where they
/// are classes.
///
/// Validation recordings are trained on: a network holds back its own. Where nothing is called a test they are tested.
pub(crate) fn per_part(root: &Path, top: &Listing) -> Result<Option<FoundFiles>> {
    let parts: Vec<Option<Part>> = top.folders.iter().map(|folder| Part::of(folder)).collect();
    let has = |part: Part| parts.contains(&Some(part));
    if !has(Part::Train) || !(has(Part::Test) || has(Part::Validation)) {
        return Ok(None);
    }
    let mut folders = vec![];
    for (folder, part) in top.folders.iter().zip(&parts) {
        let Some(part) = part else {
            let why = format!(
                "lies beside folders called train and test, which are parts of a split and no classes; rename those, or \
                 move {} away",
                last(folder)
            );
            return Err(Error::file(folder, why));
        };
        folders.push((*part, folder));
    }
    let tested = if has(Part::Test) { Part::Test } else { Part::Validation };
    folders.sort_by_key(|(part, _)| *part == tested);
    let mut found = FoundFiles { labelled_by: "the class folders", ..FoundFiles::default() };
    found.pass_over(root, top.ignored.iter().chain(&top.files).cloned());
    let (mut classes, mut marks, mut has_sessions) = (vec![], vec![], false);
    for (part, folder) in &folders {
        let listing = list(folder)?;
        if listing.folders.is_empty() {
            let why = format!(
                "is a part of a split, and holds no class folders; sort its files into {0}/CLASS, or write labels.csv \
                 (file,label) beside {0}",
                last(folder)
            );
            return Err(Error::file(folder, why));
        }
        let below = per_class(folder, &listing)?;
        classes.extend(below.labels.iter().map(|label| below.classes[*label as usize].clone()));
        marks.extend(below.files.iter().map(|_| i64::from(*part == tested)));
        has_sessions |= below.groups.is_some();
        let above = Path::new(folder.file_name().unwrap_or_default());
        found.ignored.extend(below.ignored.iter().map(|name| above.join(name).display().to_string()));
        found.positions.extend(below.positions);
        found.files.extend(below.files);
    }
    if has_sessions {
        let session = |file: &PathBuf| file.parent().map(last).unwrap_or_default();
        let numbers = by_name(found.files.iter().map(session).collect()).1;
        found.groups = Some(("session".into(), numbers.into_iter().map(i64::from).collect()));
    }
    let (classes, labels) = by_name(classes);
    (found.classes, found.labels) = (classes, labels.into_iter().map(i64::from).collect());
    let name = |wanted: &dyn Fn(Part) -> bool| {
        let names = folders.iter().filter(|(part, _)| wanted(*part)).map(|(_, folder)| last(folder));
        names.collect::<Vec<_>>().join(" and ")
    };
    let (trained, test) = (name(&|part| part != tested), name(&|part| part == tested));
    found.read_as = vec![format!("a split by folders: {trained} to train on, {test} to test on")];
    found.official = Some((format!("the folder {test}"), marks));
    Ok(Some(found))
}
