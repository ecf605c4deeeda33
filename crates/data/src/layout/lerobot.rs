//! A data set of LeRobot: episodes in files of Parquet, what they are in `meta/`.

use crate::dataset::raw::{Facts, Names, Raw, name_of};
use crate::formats::names::is_lerobot;
use crate::formats::parquet_file;
use crate::formats::table::options::{TableForm, TableOptions};
use crate::formats::table::table;
use crate::formats::table::text_columns::TableText;
use crate::formats::text::read_text;
use crate::layout::label_table::LABELS;
use crate::layout::listing::list;
use crate::layout::order::in_order;
use crate::options::{ReadOptions, refuse_set};
use crate::reader::{Format, Place, Reader, has_ending};
use crate::{Error, Result};
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Folders within folders of data.
const MAX_DEPTH: usize = 4;
/// What a column that is read begins with.
const OBSERVED: &str = "observation.";

/// Reads data sets of LeRobot: episodes are recordings `[C, T]`, observations that are numbers are the channels, the task
/// is the class, or what `labels.csv` (`episode,label`) says. [`ReadOptions::table`] and [`ReadOptions::y`] say it
/// otherwise.
pub(crate) struct LeRobot;

const FORMAT: &[Format] = &[Format {
    name: "LeRobot",
    endings: &[],
    holds: "a folder with `meta/info.json` and `data/**/*.parquet`: an episode is a recording",
    becomes: "[C, T] of all numbers in `observation.*`; the class is the task, or what `labels.csv` (`episode,label`) \
              says",
}];

impl Reader for LeRobot {
    fn formats(&self) -> &'static [Format] {
        FORMAT
    }

    fn recognises(&self, place: &Place, _: &ReadOptions) -> bool {
        is_lerobot(place.path)
    }

    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw> {
        let (path, file) = (place.path, place.file());
        let why = "does not apply to a set of LeRobot; leave it out";
        refuse_set(&file, &[("x", options.names_x()), ("resize", options.resize.is_some())], why)?;
        let mut files = vec![];
        data_files(&path.join("data"), 0, &mut files)?;
        if files.is_empty() {
            return Err(Error::NoSamples { at: file });
        }
        let table = TableText::of_files(file, &files, &options.limits)?;
        let told = labels(path, options)?;
        let options = said(&table, options, told.is_some());
        let has_tasks = told.is_none() && options.y() == TASK;
        let names = has_tasks.then(|| tasks(path, &options)).transpose()?.flatten();
        let beside = (names, Facts::default());
        let needs_labels = place.needs_labels();
        let raw = table::taken(&table, name_of(path), beside, &options, needs_labels, told.as_ref())?;
        let mut read_as = vec!["a set of LeRobot: recordings are its episodes".to_string()];
        read_as.extend_from_slice(&raw.read_as);
        Ok(raw.read_as(read_as))
    }
}

const TASK: &str = "task_index";

/// All files of Parquet below a folder, in counting order.
fn data_files(folder: &Path, depth: usize, out: &mut Vec<PathBuf>) -> Result<()> {
    let below = list(folder)?;
    out.extend(in_order(below.files).into_iter().filter(|path| has_ending(path, parquet_file::ENDINGS)));
    for own in in_order(below.folders).into_iter().filter(|_| depth < MAX_DEPTH) {
        data_files(&own, depth + 1, out)?;
    }
    Ok(())
}

/// The options, and what the columns of LeRobot are where they do not say it.
fn said(table: &TableText, options: &ReadOptions, is_told: bool) -> ReadOptions {
    let has = |name: &str| table.header.iter().any(|own| own == name);
    let named =
        |own: &Option<String>, name: &str| own.clone().or_else(|| has(name).then(|| name.to_string()));
    let observes = table.header.iter().any(|name| name.starts_with(OBSERVED));
    let own = &options.table;
    let others =
        table.header.iter().filter(|name| observes && !name.starts_with(OBSERVED) && *name != options.y());
    let ignore: Vec<String> = match own.ignore.is_empty() {
        true => others.cloned().collect(),
        false => own.ignore.clone(),
    };
    let is_other = options.names_y() || is_told || !has(TASK);
    ReadOptions {
        y: if is_other { options.y.clone() } else { Some(TASK.into()) },
        table: TableOptions {
            form: own.form.or(Some(TableForm::Long)),
            recording: named(&own.recording, "episode_index"),
            time: named(&own.time, "timestamp"),
            ignore,
            ..own.clone()
        },
        ..options.clone()
    }
}

/// What `labels.csv` says of each episode.
fn labels(path: &Path, options: &ReadOptions) -> Result<Option<HashMap<String, String>>> {
    let path = path.join(LABELS);
    if !path.is_file() {
        return Ok(None);
    }
    let file = path.display().to_string();
    let refuse = |why: String| Error::Table { file: file.clone(), why };
    let text = read_text(&path, &options.limits)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let csv = |e: csv::Error| Error::Csv { file: file.clone(), why: e.to_string().to_lowercase() };
    let header = reader.headers().map_err(csv)?.clone();
    let place = |names: &[&str]| {
        header.iter().position(|own| names.iter().any(|name| own.eq_ignore_ascii_case(name)))
    };
    let label = if options.names_y() { options.y() } else { "label" };
    let (Some(episode), Some(label)) = (place(&["episode", "episode_index"]), place(&[label])) else {
        return Err(refuse("write a first line episode,label and a line per episode".into()));
    };
    let mut told = HashMap::new();
    for record in reader.records() {
        let record = record.map_err(csv)?;
        let own = |at: usize| record.get(at).unwrap_or_default().to_string();
        if own(label).is_empty() || told.insert(own(episode), own(label)).is_some() {
            return Err(refuse(format!("episode {:?} has no label or two rows", own(episode))));
        }
    }
    Ok(Some(told))
}

/// The names of the tasks by their numbers, where `meta/tasks.jsonl` has them without gaps.
fn tasks(path: &Path, options: &ReadOptions) -> Result<Option<Names>> {
    let path = path.join("meta/tasks.jsonl");
    if !path.is_file() {
        return Ok(None);
    }
    let file = path.display().to_string();
    let mut names: Vec<String> = vec![];
    for line in read_text(&path, &options.limits)?.lines().filter(|line| !line.trim().is_empty()) {
        let refuse = |why: String| Error::Table { file: file.clone(), why };
        let own: Value = serde_json::from_str(line).map_err(|e| refuse(format!("is no JSON ({e})")))?;
        match (own["task_index"].as_u64(), own["task"].as_str()) {
            (Some(index), Some(task)) if index == names.len() as u64 => names.push(task.into()),
            _ => return Ok(None),
        }
    }
    Ok(Some(Names { file: "meta/tasks.jsonl".into(), columns: vec![names], is_told: true }))
}
