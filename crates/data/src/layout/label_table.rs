//! A folder of recordings whose classes a table says: `labels.csv` with `file,label[,group]`.

use crate::dataset::labels::by_name;
use crate::formats::bag::path::is_bag;
use crate::formats::text::read_text;
use crate::layout::listing::{Found, Listing};
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::collections::{HashMap, HashSet};
use std::path::{Component, Path, PathBuf};

/// Name of the table.
pub(crate) const LABELS: &str = "labels.csv";

/// Reads the table of the folder `root`: a header, then a row per recording, its path below the folder, its
/// class and, where there is such a column, its group. Other columns are for people.
///
/// Columns `start` and `end` cut bags into parts: seconds from its first message, the end not included.
///
/// The columns `label` and `group` may bear other names: [`ReadOptions::y`] and [`ReadOptions::group`].
pub(crate) fn read(root: &Path, top: &Listing, options: &ReadOptions) -> Result<Found> {
    let path = root.join(LABELS);
    let file = path.display().to_string();
    let refuse = |why: String| Error::LabelTable { file: file.clone(), why };
    let text = read_text(&path, &options.limits)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let csv = |e: csv::Error| Error::Csv { file: file.clone(), why: e.to_string().to_lowercase() };
    let header = reader.headers().map_err(csv)?.clone();
    let place = |name: &str| header.iter().position(|own| own.eq_ignore_ascii_case(name));
    let needed = |name: &str| {
        let held =
            || format!("has no column {name}: its first line is {:?}", header.iter().collect::<Vec<_>>());
        place(name).ok_or_else(|| refuse(held()))
    };
    let label_name = if options.names_y() { options.y() } else { "label" };
    let (of_file, of_label) = (needed("file")?, needed(label_name)?);
    let of_group = match &options.group {
        Some(name) => Some((needed(name)?, name.clone())),
        None => place("group").map(|at| (at, "group".to_string())),
    };
    let of_span = place("start").zip(place("end"));
    let (mut files, mut labels, mut groups, mut spans) = (vec![], vec![], vec![], vec![]);
    let mut seen: HashMap<(PathBuf, String), u64> = HashMap::new();
    for record in reader.records() {
        let record = record.map_err(csv)?;
        let line = record.position().map_or(0, csv::Position::line);
        let field = |at: usize| record.get(at).unwrap_or_default();
        let own = recording(root, field(of_file)).map_err(|why| refuse(format!("line {line}: {why}")))?;
        let span = of_span.filter(|_| is_bag(&own)).map(|(start, end)| [field(start), field(end)]);
        let part = span.map_or(String::new(), |span| span.join(" to "));
        if let Some(first) = seen.insert((own.clone(), part.clone()), line) {
            return Err(refuse(format!("lines {first} and {line} are both {:?}", field(of_file))));
        }
        if let Some(span) = span {
            let seconds = span.map(|text| text.parse::<f64>().ok());
            let [Some(start), Some(end)] = seconds else {
                return Err(refuse(format!(
                    "line {line}: start and end are {part:?}, not two numbers of seconds"
                )));
            };
            if start.partial_cmp(&end) != Some(std::cmp::Ordering::Less) {
                return Err(refuse(format!("line {line}: end is not after start ({part} s)")));
            }
            spans.push([start, end]);
        }
        let group = of_group.as_ref().map(|(at, _)| *at);
        let empty = [Some(of_label), group].into_iter().flatten().find(|at| field(*at).is_empty());
        if let Some(at) = empty {
            return Err(refuse(format!("line {line}: {} is empty", &header[at])));
        }
        files.push(own);
        labels.push(field(of_label).to_string());
        groups.extend(group.map(|at| field(at).to_string()));
    }
    if files.is_empty() {
        return Err(refuse("has no rows".into()));
    }
    let numbers = |values: Vec<u32>| values.into_iter().map(i64::from).collect();
    let (classes, labels) = by_name(labels);
    let mut found = Found {
        positions: (0..files.len() as i64).collect(),
        labels: numbers(labels),
        classes,
        groups: of_group.map(|(_, name)| (name, numbers(by_name(groups).1))),
        labelled_by: LABELS,
        is_table: true,
        // A table that parts bags parts them all.
        spans: Some(spans).filter(|spans| spans.len() == files.len()),
        files,
        ..Found::default()
    };
    let listed: HashSet<&PathBuf> = found.files.iter().collect();
    let unlisted: Vec<_> =
        top.files.iter().filter(|own| **own != path && !listed.contains(own)).cloned().collect();
    found.pass_over(root, top.ignored.iter().cloned().chain(unlisted));
    Ok(found)
}

/// The file that a row names, which lies below `root`.
fn recording(root: &Path, name: &str) -> Result<PathBuf, String> {
    let inside =
        Path::new(name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if name.is_empty() || !inside {
        return Err(format!("file is {name:?}; give a path below the folder of the table"));
    }
    let path = root.join(Path::new(name).components().collect::<PathBuf>());
    match path.is_file() || is_bag(&path) {
        true => Ok(path),
        false => Err(format!("there is no file {name:?} in the folder of the table")),
    }
}
