//! Reads a folder of recordings, whose classes are said by a table, by folders or by names.

use crate::dataset::raw::Raw;
use crate::formats::bag::names;
use crate::formats::bag::path::{how_to_convert, is_bag};
use crate::layout::files;
use crate::layout::label_table::{self, LABELS};
use crate::layout::listing::{self, FoundFiles, Listing, list, unsorted};
use crate::layout::names_file::{self, NAMES};
use crate::layout::parts;
use crate::options::ReadOptions;
use crate::reader::{Format, Place, Purpose, Reader};
use crate::{Error, Result};
use std::path::Path;

/// Reads a folder of files of which each is one recording. Recordings to predict need no classes.
pub(crate) struct Folder;

const FORMATS: &[Format] = &[
    Format {
        name: "folder of recordings",
        endings: &[],
        holds: "`class/file`, or `class/session/file` with the session as group; files of one format that holds one \
                recording per file; also in `train/` and `test/`, an official split",
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
    } else if let Some(found) = parts::per_part(path, top)? {
        Some(found)
    } else {
        Some(listing::per_class(path, top)?)
    };
    let Some(mut found) = found else { return Ok(None) };
    let names = path.join(NAMES);
    found.ignored.retain(|name| name != NAMES);
    let (order, facts) = names_file::of_named(&[names], &found.classes, &options.limits)?;
    found.facts = facts;
    Ok(Some(match order {
        Some(order) => found.in_order(&order),
        None => found,
    }))
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
    let hint = match sets.as_slice() {
        [] => String::new(),
        names => format!("; give one of {}", names.join(", ")),
    };
    Error::file(file, format!("holds neither data.npz nor class folders{hint}"))
}
