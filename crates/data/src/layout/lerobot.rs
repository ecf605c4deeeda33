//! Reads data sets of LeRobot: episodes in files of Parquet, described in `meta/`.

use crate::dataset::raw::{Raw, SampleFacts, name_of};
use crate::ending::has_ending;
use crate::formats::names::is_lerobot;
use crate::formats::parquet_file;
use crate::formats::table::options::{TableForm, TableOptions};
use crate::formats::table::table::{self, LabelsByRecording};
use crate::formats::table::text_columns::TableText;
use crate::formats::text::{csv_reader, read_text};
use crate::layout::label_table::LABELS;
use crate::layout::lerobot_meta::{Features, name_tasks};
use crate::layout::listing::list;
use crate::layout::order::in_order;
use crate::options::{ReadOptions, refuse_set};
use crate::reader::{Format, Place, Reader};
use crate::targets::options::TargetNames;
use crate::{Error, Result};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Most levels of folders below the data.
const MAX_DEPTH: usize = 4;
/// The beginning of the name of a column that is read.
const OBSERVED: &str = "observation.";

/// Columns of every set that count its rows.
const COUNTERS: [&str; 3] = ["index", "frame_index", "task_index"];

/// Reads data sets of LeRobot. Episodes are recordings `[C, T]`, observations that are numbers are the channels, and the
/// class is the task, or that of `labels.csv` (`episode,label`). [`ReadOptions::table`] and [`ReadOptions::y`] override
/// this.
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
        let features = Features::read(path, &options.limits)?;
        let mut table = TableText::of_files(file, &files, &options.limits)?.in_order();
        table.meanings = table.header.iter().map(|column| features.meaning(column, &table.header)).collect();
        let labels = labels_by_episode(path, &table.header, &features, options)?;
        let columns = with_columns(&table, &features, options, labels.is_some());
        let has_tasks = labels.is_none() && columns.y_names() == [TASK];
        let beside = (None, SampleFacts::default());
        let needs_labels = place.needs_labels();
        let mut raw = table::read(&table, name_of(path), beside, &columns, needs_labels, labels.as_ref())?;
        raw.read_as.insert(0, "a set of LeRobot: recordings are its episodes".to_string());
        if has_tasks && raw.values.is_none() {
            name_tasks(&mut raw, path, &options.limits)?;
        }
        features.account(&mut raw, OBSERVED, &table.header, options)?;
        features.name_channels(&mut raw, &table.header);
        Ok(raw)
    }
}

const TASK: &str = "task_index";

/// Lists all files of Parquet below a folder, in counting order.
fn data_files(folder: &Path, depth: usize, out: &mut Vec<PathBuf>) -> Result<()> {
    let below = list(folder)?;
    out.extend(in_order(below.files).into_iter().filter(|path| has_ending(path, parquet_file::ENDINGS)));
    for folder in in_order(below.folders).into_iter().filter(|_| depth < MAX_DEPTH) {
        data_files(&folder, depth + 1, out)?;
    }
    Ok(())
}

/// Adds the roles of LeRobot's columns to the options, where they do not say them. A feature that is to be ignored is all of
/// its columns.
fn with_columns(
    table: &TableText,
    features: &Features,
    options: &ReadOptions,
    has_labels: bool,
) -> ReadOptions {
    let given = &options.table;
    let has = |name: &str| table.header.iter().any(|column| column == name);
    let is_time = |name: &str| has(name) && !given.ignore.iter().any(|ignored| ignored == name);
    let named = |given: &Option<String>, name: &str| {
        given.clone().or_else(|| is_time(name).then(|| name.to_string()))
    };
    let observes = table.header.iter().any(|name| name.starts_with(OBSERVED));
    let is_other = |name: &&String| {
        let is_other = if observes { !name.starts_with(OBSERVED) } else { COUNTERS.contains(&name.as_str()) };
        is_other && !options.y_names().contains(name)
    };
    let mut ignore: Vec<String> = table.header.iter().filter(is_other).cloned().collect();
    for name in &given.ignore {
        match features.columns(name, &table.header) {
            Some(columns) => ignore.extend(columns.into_iter().cloned()),
            None => ignore.push(name.clone()),
        }
    }
    let is_other = options.names_y() || has_labels || !has(TASK);
    let recording = options.recording.clone().filter(|name| has(name));
    // A feature of several numbers is all of its columns.
    let columns = |name: &String| match features.columns(name, &table.header) {
        Some(columns) if !has(name) => columns.into_iter().cloned().collect(),
        _ => vec![name.clone()],
    };
    let y: Option<TargetNames> =
        options.y.as_ref().map(|_| options.y_names().iter().flat_map(columns).collect::<Vec<_>>().into());
    ReadOptions {
        y: match (is_other, has_labels) {
            (true, true) => None,
            (true, false) => y,
            (false, _) => Some(TASK.into()),
        },
        table: TableOptions {
            form: given.form.or(Some(TableForm::Long)),
            recording: named(&given.recording.clone().or(recording), "episode_index"),
            time: named(&given.time, "timestamp"),
            ignore,
            ..given.clone()
        },
        ..options.clone()
    }
}

/// Reads the label of each episode from `labels.csv`; none where the options name features.
fn labels_by_episode(
    path: &Path,
    columns: &[String],
    features: &Features,
    options: &ReadOptions,
) -> Result<Option<LabelsByRecording>> {
    let path = path.join(LABELS);
    if !path.is_file() {
        return Ok(None);
    }
    let file = path.display().to_string();
    let text = read_text(&path, &options.limits)?;
    let mut reader = csv_reader(&text, b',', true);
    let csv = Error::csv(&file);
    let header = reader.headers().map_err(&csv)?.clone();
    let place = |names: &[&str]| {
        header.iter().position(|column| names.iter().any(|name| column.eq_ignore_ascii_case(name)))
    };
    let usual = ["label".to_string()];
    let wanted = if options.names_y() { options.y_names() } else { &usual };
    let labels: Option<Vec<usize>> = wanted.iter().map(|name| place(&[name])).collect();
    let (Some(episode), Some(labels)) = (place(&["episode", "episode_index"]), labels) else {
        let is_feature = |name: &String| features.columns(name, columns).is_some();
        if options.names_y() && wanted.iter().all(is_feature) {
            return Ok(None);
        }
        return Err(Error::file(&path, "write a first line episode,label and a line per episode"));
    };
    let mut of = HashMap::new();
    for record in reader.records() {
        let record = record.map_err(&csv)?;
        let field = |at: usize| record.get(at).unwrap_or_default().to_string();
        let texts: Vec<String> = labels.iter().map(|at| field(*at)).collect();
        if texts.iter().all(String::is_empty) || of.insert(field(episode), texts).is_some() {
            return Err(Error::file(&path, format!("episode {:?} has no label or two rows", field(episode))));
        }
    }
    Ok(Some(LabelsByRecording { names: wanted.to_vec(), of }))
}
