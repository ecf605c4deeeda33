//! Reads time series of the UCR and UEA archives: `<name>_TRAIN` and `<name>_TEST`, as `.ts`, `.arff` or plain text.

use crate::dataset::labels::by_name;
use crate::dataset::raw::{DATA, Names, Raw};
use crate::formats::arff;
use crate::formats::case::{Case, number};
use crate::formats::text::read_text;
use crate::layout::listing::new_position;
use crate::layout::names_file;
use crate::length::ragged::Collected;
use crate::options::{ReadOptions, refuse_set};
use crate::reader::{Format, Place, Reader};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use taxel_base::Layout;

/// The endings that are tried, in this order.
const ENDINGS: [&str; 5] = ["ts", "tsv", "txt", "arff", ""];

/// Reads the pairs of files of the UCR and UEA archives.
pub(crate) struct Ucr;

const FORMAT: &[Format] = &[Format {
    name: "UCR and UEA archives",
    endings: &["ts", "tsv", "txt", "arff"],
    holds: "`GunPoint_TRAIN.ts` and `GunPoint_TEST.ts`; give the path without ending, `.../GunPoint`, or the folder \
            that holds them",
    becomes: "[C, T] with the archive's own split",
}];

impl Reader for Ucr {
    fn formats(&self) -> &'static [Format] {
        FORMAT
    }

    fn recognises(&self, place: &Place, _: &ReadOptions) -> bool {
        names_pair(place.path)
    }

    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw> {
        let pair = find(place.path).ok_or_else(|| place.not_found())?;
        read(place.path, &pair, options)
    }
}

/// Checks whether a path names the two files of a data set without their endings: `GunPoint`.
pub(crate) fn names_pair(path: &Path) -> bool {
    find(path).is_some()
}

/// The two files of a data set, and its name.
struct Pair {
    name: String,
    files: [PathBuf; 2],
}

/// Finds the data set that `path` names: `GunPoint`, `GunPoint_TRAIN.ts` or `GunPoint_TEST.ts`, or the folder that holds
/// both files, which are named like it or are the only ones.
fn find(path: &Path) -> Option<Pair> {
    if path.is_dir() {
        return inside(path).filter(|_| !path.join(DATA).is_file());
    }
    let name = path.file_name()?.to_str()?;
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let base = stem.strip_suffix("_TRAIN").or_else(|| stem.strip_suffix("_TEST")).unwrap_or(name);
    pair(path.parent()?, base)
}

/// Finds the data set in a folder.
fn inside(folder: &Path) -> Option<Pair> {
    let named = folder.canonicalize().ok()?;
    if let Some(found) = pair(folder, named.file_name()?.to_str()?) {
        return Some(found);
    }
    let names =
        std::fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let base = |name: String| {
        let stem = name.rsplit_once('.').map_or(name.as_str(), |(stem, _)| stem);
        stem.strip_suffix("_TRAIN").map(str::to_string)
    };
    let mut bases: Vec<String> = names.filter_map(base).filter(|base| pair(folder, base).is_some()).collect();
    bases.sort();
    bases.dedup();
    match bases.as_slice() {
        [one] => pair(folder, one),
        _ => None,
    }
}

fn pair(folder: &Path, name: &str) -> Option<Pair> {
    ENDINGS.iter().find_map(|ending| {
        let file = |part: &str| {
            let dot = if ending.is_empty() { "" } else { "." };
            folder.join(format!("{name}_{part}{dot}{ending}"))
        };
        let files = [file("TRAIN"), file("TEST")];
        files.iter().all(|file| file.is_file()).then(|| Pair { name: name.into(), files })
    })
}

/// Reads both files: samples `[N, channels, length]`, the training ones first, and the official split.
///
/// - `.ts`: lines with `#` or `@` are head, then one case a line: channels and at last the class, parted by
///   `:`; values by `,`.
/// - `.arff`: see [`arff`].
/// - other endings: one case a line, its class first, parted by blanks, tabs or commas; one channel.
fn read(path: &Path, pair: &Pair, options: &ReadOptions) -> Result<Raw> {
    let file = path.display().to_string();
    let set = [
        ("x", options.names_x()),
        ("y", options.names_y()),
        ("group", options.group.is_some()),
        ("group_block", options.group_block.is_some()),
        ("resize", options.resize.is_some()),
        ("test", options.test.is_some()),
        ("test_above", options.test_above.is_some()),
    ];
    refuse_set(&file, &set, "does not apply to a pair of _TRAIN and _TEST files; leave it out")?;
    let mut collected = Collected::new(&file, options.limits);
    let (mut names, mut origins, mut test) = (vec![], vec![], vec![]);
    for (part, path) in pair.files.iter().enumerate() {
        let file = path.display().to_string();
        let before = names.len();
        let short = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut take = |case: Case| {
            let at = format!("{short}[{}]", names.len() - before);
            let shape = [case.channels.len(), case.channels.first().map_or(0, Vec::len)];
            if case.channels.iter().any(|channel| channel.len() != shape[1]) {
                let lengths: Vec<usize> = case.channels.iter().map(Vec::len).collect();
                let why = format!(
                    "its channels have {lengths:?} values; give all channels of a case the same length"
                );
                return Err(Error::file(format!("{file}: {at}"), why));
            }
            let hint = " but for time";
            collected.push(&at, &shape, &case.channels.concat(), Some(1), hint)?;
            origins.push(at);
            test.push(part as i64);
            names.push(case.class);
            Ok(())
        };
        let text = read_text(path, &options.limits)?;
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("ts") => read_ts(&text, &file, &mut take)?,
            Some("arff") => arff::read(&text, &file, &mut take)?,
            _ => read_plain(&text, &file, &mut take)?,
        }
        if names.len() == before {
            return Err(Error::NoSamples { at: file });
        }
    }
    let x = collected.finish().ok_or_else(|| Error::NoSamples { at: file.clone() })?;
    let (mut classes, mut y) = by_name(names);
    let beside = [format!("{}.classes.json", pair.name), names_file::NAMES.into()];
    let beside = beside.map(|name| pair.files[0].with_file_name(name));
    let (order, facts) = names_file::of_named(&beside, &classes, &options.limits)?;
    if let Some(order) = order {
        y = y.into_iter().map(|label| new_position(&order, label as usize) as u32).collect();
        classes = order.iter().map(|class| classes[*class].clone()).collect();
    }
    let names = Names { file: file.clone(), columns: vec![classes], is_given: true };
    Ok(Raw {
        name: pair.name.clone(),
        file,
        dtype: "text".into(),
        format: Some(Layout::Series),
        x_name: "the series".into(),
        y_name: "the classes".into(),
        y: y.into_iter().map(i64::from).collect(),
        names: Some(names),
        facts,
        official: Some(("the _TEST file".into(), test)),
        x,
        origins,
        ..Raw::default()
    })
}

fn read_ts(text: &str, file: &str, take: &mut dyn FnMut(Case) -> Result<()>) -> Result<()> {
    for (i, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
        if line.is_empty() || line.starts_with(['#', '@', '%']) {
            continue;
        }
        let mut parts: Vec<&str> = line.split(':').collect();
        let class = parts.pop().unwrap_or_default().trim().to_string();
        if parts.is_empty() || class.is_empty() {
            return Err(Error::NoClass { file: file.into(), line: i as u64 });
        }
        let mut column = 0;
        let channel = |part: &&str| -> Result<Vec<f32>> {
            let mut value = |text: &str| {
                column += 1;
                number(text, file, i, column)
            };
            part.split(',').map(&mut value).collect()
        };
        take(Case { class, channels: parts.iter().map(channel).collect::<Result<_>>()? })?;
    }
    Ok(())
}

fn read_plain(text: &str, file: &str, take: &mut dyn FnMut(Case) -> Result<()>) -> Result<()> {
    for (i, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
        let mut fields = line.split([' ', '\t', ',']).filter(|field| !field.is_empty());
        let Some(class) = fields.next() else { continue };
        let values = fields.enumerate().map(|(column, text)| number(text, file, i, column + 2));
        let values: Vec<f32> = values.collect::<Result<_>>()?;
        if values.is_empty() {
            return Err(Error::NoClass { file: file.into(), line: i as u64 });
        }
        // Classes written as 1.0000000e+00 are the class 1.
        let class = class.parse::<f64>().map_or_else(|_| class.to_string(), |number| number.to_string());
        take(Case { class, channels: vec![values] })?;
    }
    Ok(())
}
