//! Reads a folder of recordings, whose classes are said by a table, by folders or by names.

use crate::dataset::raw::Raw;
use crate::dataset::targets::Values;
use crate::formats::bag::names;
use crate::formats::bag::path::{how_to_convert, is_bag};
use crate::formats::ucr::ucr::without_partner;
use crate::layout::class_folders;
use crate::layout::files;
use crate::layout::label_table::{self, LABELS};
use crate::layout::listing::{FoundFiles, Listing, list, unsorted};
use crate::layout::names_file::{self, NAMES};
use crate::options::ReadOptions;
use crate::reader::{Format, Place, Purpose, Reader};
use crate::targets::quantities::values_said;
use crate::targets::texts::TextTargets;
use crate::{Error, Result};
use std::path::Path;

/// Reads a folder of files of which each is one recording. Recordings to predict need no classes.
pub(crate) struct Folder;

const FORMATS: &[Format] = &[
    Format {
        name: "folder of recordings",
        endings: &[],
        holds: "`class/file`, or `class/session/file` with the session as group, also below `train` and `test`; files of \
                one format that holds one recording per file",
        becomes: "as that format says",
    },
    Format {
        name: "folder with a table",
        endings: &[],
        holds: "the same files, and `labels.csv`: a first line `file,label` or `file,label,group`, then a line per \
                recording, its path below the folder",
        becomes: "the same; other columns are for people, `data.y` and `data.group` name other ones",
    },
];

impl Reader for Folder {
    fn formats(&self) -> &'static [Format] {
        FORMATS
    }

    fn recognises(&self, place: &Place, _: &ReadOptions) -> bool {
        place.path.is_dir() && place.format_of(place.path).is_none()
    }

    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw> {
        options.refuse_targets(&place.file())?;
        let top = list(place.path)?;
        match labelled(place.path, &top, options)? {
            Some(found) => files::read(place, found, options),
            None if place.needs_labels() || top.files.is_empty() => Err(refuse(place, &top, options)),
            None => files::read(place, unsorted(top.files), options),
        }
    }
}

/// Lists the recordings of a folder whose classes are said by a table, by folders or by the names of bags; none otherwise.
/// `labels.json` in it may describe the samples, and give the order of the classes.
fn labelled(path: &Path, top: &Listing, options: &ReadOptions) -> Result<Option<FoundFiles>> {
    let found = if path.join(LABELS).is_file() {
        Some(label_table::read(path, top, options)?)
    } else if let Some(found) = names::per_name(path, top)? {
        Some(found)
    } else if top.folders.is_empty() {
        None
    } else {
        Some(class_folders::per_class(path, top)?)
    };
    let Some(mut found) = found else { return Ok(None) };
    let names = path.join(NAMES);
    found.ignored.retain(|name| name != NAMES);
    let (order, facts) = names_file::of_named(&[names], &found.classes, &options.limits)?;
    found.facts = facts;
    // Who lists the numbers as classes means classes.
    if options.wants_values() || order.is_none() && found.is_table {
        set_values(path, &mut found, options)?;
    }
    refuse_no_class(path, &found)?;
    Ok(Some(match order {
        Some(order) => found.in_order(&order),
        None => found,
    }))
}

/// Takes labels as values, where they are asked for or have fractions.
fn set_values(path: &Path, found: &mut FoundFiles, options: &ReadOptions) -> Result<()> {
    if !found.is_table {
        found.texts = found.labels.iter().map(|label| found.classes[*label as usize].clone()).collect();
        found.target_names = vec!["class".into()];
    }
    let place = |row: usize| match found.lines.get(row) {
        Some(line) => format!("line {line}"),
        None => found.files[row].display().to_string(),
    };
    let targets = TextTargets { names: &found.target_names, texts: &found.texts };
    let values = targets.values(options, found.facts.quantities.is_some(), place);
    let file = if found.is_table { path.join(LABELS) } else { path.to_path_buf() };
    let Some(values) = values.map_err(|why| Error::file(file, why))? else { return Ok(()) };
    let columns: Vec<(&str, usize)> = found.target_names.iter().map(|name| (name.as_str(), 1)).collect();
    let quantities = names_file::quantities(&found.facts, &columns)?;
    found.read_as.extend(values_said(&quantities, options));
    found.values = Some(Values::new(quantities, values));
    (found.labels, found.classes) = (vec![], vec![]);
    Ok(())
}

/// Refuses a table that says no class of a recording, or of each several.
fn refuse_no_class(path: &Path, found: &FoundFiles) -> Result<()> {
    if found.values.is_some() || !found.is_table {
        return Ok(());
    }
    let targets = TextTargets { names: &found.target_names, texts: &found.texts };
    let why = if let Some((row, column)) = targets.first_empty() {
        format!(
            "line {}: {column} is empty; write a first line file,label or file,label,group and a line per recording",
            found.lines[row]
        )
    } else if let [_, _, ..] = found.target_names.as_slice() {
        let names = found.target_names.join(" and ");
        format!(
            "{names} hold whole numbers or texts, which are classes; name one of them with y, or say task = \"values\""
        )
    } else {
        return Ok(());
    };
    Err(Error::file(path.join(LABELS), why))
}

/// Says what a folder lacks, and which of its files are data sets themselves.
fn refuse(place: &Place, top: &Listing, options: &ReadOptions) -> Error {
    let file = place.file();
    if top.files.iter().any(|path| is_bag(path)) {
        return Error::file(
            file,
            "holds bags but no classes; name bags by class (cup_03.mcap), put them into a folder per class, or write \
             labels.csv (file,label)",
        );
    }
    if let Some((path, how)) = top.files.iter().find_map(|path| Some((path, how_to_convert(path)?))) {
        return Error::file(path, how);
    }
    let is_set = |path: &Path| {
        let place = Place { path, purpose: Purpose::Learn, readers: place.readers };
        place.readers.iter().any(|reader| reader.recognises(&place, options))
    };
    let sets: Vec<String> = top
        .files
        .iter()
        .filter(|path| is_set(path))
        .filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()))
        .collect();
    let lone = || top.files.iter().find_map(|path| without_partner(path));
    let hint = match sets.as_slice() {
        [] => lone().map_or(String::new(), |why| format!(": {why}")),
        names => format!("; give one of {}", names.join(", ")),
    };
    Error::file(file, format!("holds neither data.npz nor class folders{hint}"))
}
