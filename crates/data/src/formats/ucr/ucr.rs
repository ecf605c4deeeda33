//! Reads time series of the UCR and UEA archives: `<name>_TRAIN` and `<name>_TEST`, as `.ts`, `.arff` or plain text.

use crate::dataset::labels::{as_values, by_name};
use crate::dataset::raw::{DATA, Names, Raw};
use crate::dataset::targets::Values;
use crate::ending::has_ending;
use crate::formats::text::read_text;
use crate::formats::ucr::case::{Case, CaseTargets};
use crate::formats::ucr::{arff, plain, ts};
use crate::layout::listing::new_position;
use crate::layout::names_file;
use crate::length::ragged::Collected;
use crate::options::{ReadOptions, refuse_set};
use crate::reader::{Format, Place, Reader};
use crate::targets::options::TaskKind;
use crate::targets::quantities::values_said;
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
        read(place, &pair, options)
    }
}

/// Checks whether a path names the two files of a data set without their endings: `GunPoint`.
pub(crate) fn names_pair(path: &Path) -> bool {
    find(path).is_some()
}

/// Says which file is missing beside a `.ts` or `.arff` that is one of two.
pub(crate) fn without_partner(path: &Path) -> Option<String> {
    let ending = ["ts", "arff"].into_iter().find(|ending| has_ending(path, &[ending]))?;
    let stem = path.file_stem()?.to_str()?;
    let missing = match (stem.strip_suffix("_TRAIN"), stem.strip_suffix("_TEST")) {
        (Some(name), _) => format!("{name}_TEST.{ending}"),
        (_, Some(name)) => format!("{name}_TRAIN.{ending}"),
        _ => format!("{stem}_TRAIN.{ending} and {stem}_TEST.{ending}"),
    };
    let two = "a set is two files, one to train on and one to test on";
    Some(format!("a .{ending} file alone is no data set, and there is no {missing}; {two}"))
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

/// The cases of both files, the training ones first.
struct Cases {
    collected: Collected,
    targets: Vec<String>,
    origins: Vec<String>,
    /// 1 for the cases of the test file.
    test: Vec<i64>,
}

impl Cases {
    /// Reads the cases of one of the two files.
    fn add(&mut self, path: &Path, part: i64, options: &ReadOptions) -> Result<CaseTargets> {
        let file = path.display().to_string();
        let before = self.targets.len();
        let short = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut take = |case: Case| {
            let at = format!("{short}[{}]", self.targets.len() - before);
            let shape = [case.channels.len(), case.channels.first().map_or(0, Vec::len)];
            if case.channels.iter().any(|channel| channel.len() != shape[1]) {
                let lengths: Vec<usize> = case.channels.iter().map(Vec::len).collect();
                let why = format!(
                    "its channels have {lengths:?} values; give all channels of a case the same length"
                );
                return Err(Error::file(format!("{file}: {at}"), why));
            }
            self.collected.push(&at, &shape, &case.channels.concat(), Some(1), " but for time")?;
            self.origins.push(at);
            self.test.push(part);
            self.targets.push(case.target);
            Ok(())
        };
        let text = read_text(path, &options.limits)?;
        let targets = match path.extension().and_then(|ending| ending.to_str()) {
            Some("ts") => ts::read(&text, &file, &mut take)?,
            Some("arff") => arff::read(&text, &file, &mut take)?,
            _ => plain::read(&text, &file, &mut take)?,
        };
        if self.targets.len() == before {
            return Err(Error::NoSamples { at: file });
        }
        Ok(targets)
    }
}

/// Reads both files: samples `[N, channels, length]`, the training ones first, and the official split. How cases are
/// written depends on the ending: see [`ts`], [`arff`] and [`plain`].
fn read(place: &Place, pair: &Pair, options: &ReadOptions) -> Result<Raw> {
    let file = place.file();
    let set = [
        ("x", options.names_x()),
        ("y", options.names_y()),
        ("target", options.target.is_some()),
        ("recording", options.recording.is_some() && place.needs_labels()),
        ("group", options.group.is_some()),
        ("group_block", options.group_block.is_some()),
        ("resize", options.resize.is_some()),
        ("test", options.test.is_some()),
        ("test_above", options.test_above.is_some()),
    ];
    refuse_set(&file, &set, "does not apply to a pair of _TRAIN and _TEST files; leave it out")?;
    let collected = Collected::new(&file, options.limits);
    let mut cases = Cases { collected, targets: vec![], origins: vec![], test: vec![] };
    let [train, test] = &pair.files;
    let [first, second] = [cases.add(train, 0, options)?, cases.add(test, 1, options)?];
    let (held, other) = (first.described(), second.described());
    let targets = first.both(second).ok_or_else(|| {
        let why =
            format!("its cases have {other}, and those of {} have {held}; make them alike", train.display());
        Error::file(test, why)
    })?;
    let x = cases.collected.finish().ok_or_else(|| Error::NoSamples { at: file.clone() })?;
    let mut raw = Raw {
        name: pair.name.clone(),
        file,
        dtype: "text".into(),
        format: Some(Layout::Series),
        x_name: "the series".into(),
        official: Some(("the _TEST file".into(), cases.test)),
        x,
        origins: cases.origins,
        ..Raw::default()
    };
    set_targets(&mut raw, place, pair, cases.targets, &targets, options)?;
    Ok(raw)
}

/// Gives the samples their classes or values, and the facts of the file beside.
fn set_targets(
    raw: &mut Raw,
    place: &Place,
    pair: &Pair,
    texts: Vec<String>,
    targets: &CaseTargets,
    options: &ReadOptions,
) -> Result<()> {
    let beside = [format!("{}.classes.json", pair.name), names_file::NAMES.into()];
    let beside = beside.map(|name| pair.files[0].with_file_name(name));
    let values = match targets {
        CaseTargets::Nothing if place.needs_labels() => {
            let why = "its cases have no classes, as its head says (@classLabel false); write @classLabel true and end \
                       each case with its class, or @targetLabel true and end it with a number";
            return Err(Error::file(&pair.files[0], why));
        }
        CaseTargets::Nothing => return Ok(()),
        _ if options.wants_values() => Some(numbers(&texts, &raw.file)?),
        CaseTargets::Classes(_) => None,
        CaseTargets::Unsaid => as_values(&texts),
        CaseTargets::Values => Some(numbers(&texts, &raw.file)?),
    };
    if values.is_some() && options.task == Some(TaskKind::Classes) {
        let why = "its targets are values, and task = \"classes\" takes classes; leave task out";
        return Err(Error::file(&pair.files[0], why));
    }
    let (mut classes, mut y) = by_name(texts);
    let (order, facts) = names_file::of_named(&beside, &classes, &options.limits)?;
    // Who lists the numbers as classes means classes.
    if let Some(values) = values.filter(|_| order.is_none() || options.wants_values()) {
        let quantities = names_file::quantities(&facts, &[("target", 1)])?;
        raw.read_as = values_said(&quantities, options).into_iter().collect();
        raw.y_name = "the targets".into();
        raw.values = Some(Values::new(quantities, values));
        raw.facts = facts;
        return Ok(());
    }
    if let CaseTargets::Classes(listed) = targets {
        let unused = listed.iter().filter(|name| !classes.contains(name));
        raw.read_as = unused.map(|name| format!("class {name:?} is listed, and no case is of it")).collect();
    }
    if let Some(order) = order {
        y = y.into_iter().map(|label| new_position(&order, label as usize) as u32).collect();
        classes = order.iter().map(|class| classes[*class].clone()).collect();
    }
    raw.y_name = "the classes".into();
    raw.y = y.into_iter().map(i64::from).collect();
    raw.names = Some(Names { file: raw.file.clone(), columns: vec![classes], is_given: true });
    raw.facts = facts;
    Ok(())
}

/// Reads targets that the head calls numbers.
fn numbers(texts: &[String], file: &str) -> Result<Vec<f32>> {
    let number = |text: &String| {
        text.parse()
            .map_err(|_| Error::file(file, format!("the target {text:?} is not a number; correct it")))
    };
    texts.iter().map(number).collect()
}
