//! One table of many recordings, in CSV or Parquet.

use crate::dataset::labels::by_name;
use crate::dataset::raw::{Facts, Names, Raw, name_of};
use crate::formats::clock::Timing;
use crate::formats::table::columns::{TableColumns, recording_in};
use crate::formats::table::long::{self, Recording};
use crate::formats::table::options::{TableForm, TableOptions};
use crate::formats::table::text_columns::{Row, TableText};
use crate::layout::arrays;
use crate::layout::names_file;
use crate::length::ragged::{Collected, Ragged};
use crate::options::{Limits, ReadOptions, refuse_set};
use crate::reader::{Format, Place, Purpose, Reader};
use crate::{Error, Result};
use std::collections::HashMap;
use std::path::Path;
use taxel_base::Layout;

/// Reads files of tables in one format.
///
/// - wide: a row is a sample `[F]`, or of the shape that is said.
/// - long: rows of the same recording are its readings over time, `[C, T]`, or `[T, H, W]` where a row has that shape;
///   recordings may differ in length, and their rows may be mixed.
///
/// Columns of texts without a role are passed over and named in the card.
pub(crate) struct TableFile {
    pub format: &'static Format,
    /// Whether a file can be nothing else.
    pub is_always: bool,
    pub open: fn(&Path, &Limits) -> Result<TableText>,
}

/// Reads tables as text.
pub(crate) const TEXT: TableFile = TableFile {
    format: &Format {
        name: "table",
        endings: &["csv", "tsv"],
        holds: "a first line with names of columns, then wide, a row per sample with its `label`; or long, a row per \
                reading: `recording`, `time`, channels, `label`, `group`",
        becomes: "wide [F]; long [C, T]; rows of taxels [H, W] or [T, H, W], see [Tables](#tables)",
    },
    is_always: false,
    open: TableText::of_csv,
};

/// Reads tables in Parquet.
#[cfg(feature = "parquet")]
pub(crate) const PARQUET: TableFile = TableFile {
    format: &Format {
        name: "Parquet",
        endings: crate::formats::parquet_file::ENDINGS,
        holds: "the same columns; one of lists is as many columns `name.0`, `name.1`, ... as its first row has values",
        becomes: "as the table",
    },
    is_always: true,
    open: TableText::of_parquet,
};

impl Reader for TableFile {
    fn formats(&self) -> &'static [Format] {
        std::slice::from_ref(self.format)
    }

    fn recognises(&self, place: &Place, options: &ReadOptions) -> bool {
        if !self.format.names(place.path) || !place.path.is_file() {
            return false;
        }
        match place.purpose {
            Purpose::Predict { rank } if !self.is_always => self.is_table(place.path, options, rank),
            _ => true,
        }
    }

    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw> {
        let why = "does not apply to a table, whose channels are its other columns; leave it out";
        let set = [("x", options.names_x()), ("resize", options.resize.is_some())];
        refuse_set(&place.file(), &set, why)?;
        let table = self.opened(place.path, &options.limits)?;
        let beside = names_file::lenient(place.path, &options.limits)?;
        taken(&table, name_of(place.path), beside, options, place.needs_labels(), None)
    }
}

impl TableFile {
    /// Whether a file that could be one recording is a table of many, for a model that takes samples of `rank` axes.
    fn is_table(&self, path: &Path, options: &ReadOptions, rank: usize) -> bool {
        let says = || {
            let named = |header: &[String]| {
                options.table.recording.as_ref().is_some_and(|name| header.contains(name))
            };
            let table = self.opened(path, &options.limits);
            table.is_ok_and(|table| recording_in(&table.header).is_some() || named(&table.header))
        };
        // A model's columns alone do not make a table of a file.
        let is_told = options.table.form.is_some()
            || !options.table.shape.is_empty()
            || options.table.columns.is_empty() && options.table != TableOptions::default();
        rank == 1 || is_told || says()
    }

    /// Opens a file whose columns have different names.
    fn opened(&self, path: &Path, limits: &Limits) -> Result<TableText> {
        (self.open)(path, limits)?.with_different_names()
    }
}

/// Reads a table that is open; `told` says the label of each recording in the place of a column.
pub(crate) fn taken(
    table: &TableText,
    set: String,
    beside: (Option<Names>, Facts),
    options: &ReadOptions,
    needs_labels: bool,
    told: Option<&HashMap<String, String>>,
) -> Result<Raw> {
    let file = table.file.clone();
    let columns = TableColumns::of(&table.header, &file, options, needs_labels && told.is_none())?;
    let (channels, texts) = table.numeric(columns.rest.clone())?;
    if channels.is_empty() {
        let held = table.header.join(", ");
        return Err(table.refuse(format!("has no column of numbers beside labels and groups; it has {held}")));
    }
    refuse_shape(table, &columns, channels.len())?;
    let (names, mut facts) = beside;
    let (mut all, x, timing) = match columns.form {
        TableForm::Wide => wide(table, &columns, &channels, options)?,
        TableForm::Long => long::read(table, &columns, &channels, options)?,
    };
    if let Some(timing) = &timing {
        facts.rate = Some(timing.rate());
        facts.stamped = facts.rate;
    }
    if let Some(told) = told {
        tell_labels(table, &mut all, told)?;
    }
    let x = x.ok_or_else(|| Error::NoSamples { at: file.clone() })?;
    let name = |at: usize| table.header[at].clone();
    let y_name = columns.label.map_or_else(|| "label".into(), name);
    let labels = labels(&all, &y_name, &file, names)?;
    let mut read_as = vec![described(table, &columns, channels.len())];
    read_as.extend(timing.map(|timing| timing.to_string()));
    let used: Vec<usize> = columns.used().collect();
    let is_text = |at: &usize| texts.contains(at);
    let is_other = |at: &usize| !used.contains(at) && !channels.contains(at) && !is_text(at);
    let ignored =
        (0..table.header.len()).filter(is_other).map(|at| format!("column {:?}", name(at))).collect();
    let groups = groups(&all, columns.group.map(name), &file, options)?;
    let official = columns.test.map(|at| (name(at), all.iter().filter_map(|own| own.mark).collect()));
    let hashes = x.hashes();
    let origins = all.into_iter().map(|own| own.name).collect();
    Ok(Raw::new(set, file, x, origins)
        .stored_as(table.dtype(), layout(&columns))
        .called("the table", y_name)
        .with_labels(labels.0, 1, labels.1)
        .with_facts(facts)
        .with_groups(groups)
        .with_official(official)
        .with_hashes(hashes)
        .passing_over(texts.iter().map(|at| name(*at)).collect(), ignored)
        .read_as(read_as)
        .of_table(remembered(table, &columns, &channels)))
}

/// Gives each recording the label that is told of it.
fn tell_labels(table: &TableText, all: &mut [Recording], told: &HashMap<String, String>) -> Result<()> {
    for recording in all {
        let label = told.get(&recording.name).cloned();
        let why = || table.refuse(format!("recording {:?} has no row in labels.csv", recording.name));
        recording.label = Some(label.ok_or_else(why)?);
    }
    Ok(())
}

/// Returns what the axes of a sample are; none where the form and the shape of the rows leave that open.
fn layout(columns: &TableColumns) -> Option<Layout> {
    match (columns.form, columns.shape.len()) {
        (TableForm::Wide, 0 | 1) => Some(Layout::Features),
        (TableForm::Wide, 2) => Some(Layout::Image),
        // Colours, frames or fingers.
        (TableForm::Wide, _) => None,
        (TableForm::Long, 0) => Some(Layout::Series),
        (TableForm::Long, _) => Some(Layout::Sequence),
    }
}

/// What another table must hold to be read alike; a row there is what it is here by its columns.
fn remembered(table: &TableText, columns: &TableColumns, channels: &[usize]) -> TableOptions {
    let name = |at: usize| table.header[at].clone();
    let is_long = columns.form == TableForm::Long;
    let time = columns.time.filter(|_| is_long);
    TableOptions {
        form: None,
        recording: columns.recording.filter(|_| is_long).map(name),
        time: time.map(|(at, _)| name(at)),
        clock: time.map(|(_, clock)| clock),
        ignore: vec![],
        columns: channels.iter().copied().map(name).collect(),
        shape: columns.shape.clone(),
    }
}

/// Refuses a shape that the channels of a row do not have.
fn refuse_shape(table: &TableText, columns: &TableColumns, channels: usize) -> Result<()> {
    let TableColumns { form, shape, .. } = columns;
    if shape.is_empty() {
        return Ok(());
    }
    let (axes, wanted) = match form {
        TableForm::Wide => (1..=3, "one to three axes"),
        TableForm::Long => (2..=2, "two axes, rows and columns of taxels"),
    };
    if !axes.contains(&shape.len()) {
        return Err(
            table.refuse(format!("is {form}, whose rows have {wanted}, and table.shape is {shape:?}"))
        );
    }
    let takes = shape.iter().fold(1usize, |all, axis| all.saturating_mul(*axis));
    match takes == channels {
        true => Ok(()),
        false => Err(table.refuse(format!(
            "has {channels} channels in a row, and table.shape {shape:?} takes {takes}; say which with table.columns, or \
             which are none with table.ignore"
        ))),
    }
}

/// How the table was taken, for the card.
fn described(table: &TableText, columns: &TableColumns, channels: usize) -> String {
    let name = |at: usize| &table.header[at];
    let axes = columns.shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
    let mut parts = vec![match (columns.form, columns.shape.as_slice()) {
        (TableForm::Wide, []) => format!("a wide table: a row is a sample of {channels} features"),
        (TableForm::Wide, _) => format!("a wide table: a row is a sample of {axes} readings"),
        (TableForm::Long, []) => format!("a long table: a row is a reading of {channels} channels"),
        (TableForm::Long, _) => format!("a long table: a row is a frame of {axes} readings"),
    }];
    let role = |role: &str, at: Option<usize>| at.map(|at| format!("{role} by {:?}", name(at)));
    parts.extend(role("recordings", columns.recording));
    if let (TableForm::Long, Some((at, clock))) = (columns.form, columns.time) {
        parts.push(format!("time by {:?} in {}", name(at), clock.name()));
    }
    parts.extend(role("labels", columns.label));
    parts.extend(role("groups", columns.group));
    parts.join(", ")
}

fn wide(
    table: &TableText,
    columns: &TableColumns,
    channels: &[usize],
    options: &ReadOptions,
) -> Result<(Vec<Recording>, Option<Ragged>, Option<Timing>)> {
    let mut collected =
        Collected::new(&table.file, options.limits).of_about(table.likely_rows(channels.len()));
    let mut all = vec![];
    let mut values = vec![0.0; channels.len()];
    let list = [channels.len()];
    let shape = if columns.shape.is_empty() { &list[..] } else { &columns.shape };
    table.rows(|row: Row| {
        let name = match columns.recording {
            Some(at) => row.named(at)?,
            None => format!("line {}", row.line),
        };
        for (value, at) in values.iter_mut().zip(channels) {
            *value = row.number(*at)?;
        }
        let own = Recording::of(&row, name, columns)?;
        long::refuse_many(table, all.len(), options)?;
        collected.push(&own.name, shape, &values, None, "")?;
        all.push(own);
        Ok(true)
    })?;
    Ok((all, collected.finish(), None))
}

/// Labels as positions among their names: those of the file beside, or those that occur.
fn labels(all: &[Recording], y: &str, file: &str, names: Option<Names>) -> Result<(Vec<i64>, Option<Names>)> {
    let texts: Vec<String> = all.iter().filter_map(|own| own.label.clone()).collect();
    if texts.is_empty() {
        return Ok((vec![], names));
    }
    let numbers: Option<Vec<i64>> = texts.iter().map(|text| text.parse().ok()).collect();
    match (names, numbers) {
        (Some(names), Some(numbers)) if names.columns.iter().any(|own| !own.contains(&texts[0])) => {
            Ok((numbers, Some(names)))
        }
        (Some(names), _) => {
            let read = arrays::named(texts, 1, y, file, Some(&names))?;
            Ok((read.values, Some(names)))
        }
        (None, _) => {
            let (classes, values) = by_name(texts);
            let names = Names { file: y.into(), columns: vec![classes], is_told: true };
            Ok((values.into_iter().map(i64::from).collect(), Some(names)))
        }
    }
}

/// Groups: whole numbers as they are, texts as positions among those that occur.
fn groups(
    all: &[Recording],
    name: Option<String>,
    file: &str,
    options: &ReadOptions,
) -> Result<Option<(String, Vec<i64>)>> {
    let refuse = |why| Err(Error::Option { file: file.into(), option: "group_block", why });
    let Some(name) = name else {
        return match options.group_block {
            None => Ok(None),
            Some(_) => refuse("needs a column to divide into blocks; name it with group = \"trial\""),
        };
    };
    let texts: Vec<String> = all.iter().filter_map(|own| own.group.clone()).collect();
    let numbers: Option<Vec<i64>> = texts.iter().map(|text| text.parse().ok()).collect();
    match (numbers, options.group_block) {
        (Some(numbers), _) => Ok(Some((name, numbers))),
        (None, Some(_)) => refuse("divides consecutive numbers, but the groups are texts; leave it out"),
        (None, None) => Ok(Some((name, by_name(texts).1.into_iter().map(i64::from).collect()))),
    }
}
