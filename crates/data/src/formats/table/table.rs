//! Reads one table of many recordings, in CSV or Parquet.

use crate::dataset::labels::group_numbers;
use crate::dataset::precision::Precision;
use crate::dataset::raw::{NamedColumn, Names, Raw, SampleFacts, name_of};
use crate::formats::clock::Timing;
use crate::formats::stamps::Mended;
use crate::formats::table::columns::{TableColumns, recording_in};
use crate::formats::table::decorated::{doubts_of_labels, doubts_of_texts};
use crate::formats::table::long::{self, LongTable};
use crate::formats::table::options::{TableForm, TableOptions};
use crate::formats::table::recording::TableRecording;
use crate::formats::table::targets::{StoredTargets, TableTargets};
use crate::formats::table::text_columns::{TableRow, TableText};
use crate::layout::names_file;
use crate::length::ragged::Collected;
use crate::options::{Limits, ReadOptions, refuse_set};
use crate::reader::{Format, Place, Purpose, Reader};
use crate::targets::quantities::values_said;
use crate::{Error, Result};
use std::collections::HashMap;
use std::path::Path;
use taxel_base::Layout;

/// Reads files of tables in one format.
///
/// - wide: a row is a sample `[F]`, or of the given shape.
/// - long: rows of the same recording are its time steps, `[C, T]`, or `[T, H, W]` where a row has that shape;
///   recordings may differ in length, and their rows may be mixed.
///
/// Columns of texts without a role are passed over and named in the card.
pub(crate) struct TableFile {
    pub format: &'static Format,
    /// A file of this format cannot be one recording.
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
        let beside = names_file::beside(place.path, false, &options.limits)?;
        read(&table, name_of(place.path), beside, options, place.needs_labels(), None)
    }
}

impl TableFile {
    /// Checks whether a file that could be one recording is a table of many, for a model that takes samples of `rank` axes.
    fn is_table(&self, path: &Path, options: &ReadOptions, rank: usize) -> bool {
        let has_recordings = || {
            let Ok(table) = self.opened(path, &options.limits) else { return false };
            let mut named = options.table.recording.iter().chain(&options.recording);
            let is_named = named.any(|name| table.header.contains(name));
            is_named || recording_in(&table.header).is_some()
        };
        // The options of a model may name columns alone, which does not make a table of a file.
        let has_options = options.table.form.is_some()
            || !options.table.shape.is_empty()
            || options.table.columns.is_empty() && options.table != TableOptions::default();
        rank == 1 || has_options || has_recordings()
    }

    /// Opens a file whose columns have different names.
    fn opened(&self, path: &Path, limits: &Limits) -> Result<TableText> {
        (self.open)(path, limits)?.with_different_names()
    }
}

/// Reads a table that is open; `labels_by_recording` takes the place of a column of labels.
pub(crate) fn read(
    table: &TableText,
    set: String,
    beside: (Option<Names>, SampleFacts),
    options: &ReadOptions,
    needs_labels: bool,
    labels_by_recording: Option<&LabelsByRecording>,
) -> Result<Raw> {
    let file = table.file.clone();
    options.refuse_targets(&file)?;
    let needs_labels = needs_labels && labels_by_recording.is_none();
    let mut columns = TableColumns::of(&table.header, &file, options, needs_labels)?;
    let texts = columns.settle(table, options)?;
    let channels = columns.rest.clone();
    refuse_shape(table, &columns, channels.len())?;
    let (names, mut facts) = beside;
    let long = match columns.form {
        TableForm::Wide => wide(table, &columns, &channels, options)?,
        TableForm::Long => long::read(table, &columns, &channels, options)?,
    };
    if let Some(timing) = &long.timing {
        let rate = Some(timing.rate());
        names_file::stamp(&mut facts, rate, options)?;
        facts.rate = rate;
    }
    let parsed = Parsed { table, columns: &columns, channels: &channels, texts: &texts, names, facts, long };
    parsed.raw(set, options, labels_by_recording)
}

/// A table whose recordings are read, and whose targets are not.
struct Parsed<'t> {
    table: &'t TableText,
    columns: &'t TableColumns,
    channels: &'t [usize],
    /// Columns of text, which are passed over.
    texts: &'t [usize],
    names: Option<Names>,
    facts: SampleFacts,
    long: LongTable,
}

impl Parsed<'_> {
    /// Reads the targets, and says what was read as what.
    fn raw(
        self,
        set: String,
        options: &ReadOptions,
        labels_by_recording: Option<&LabelsByRecording>,
    ) -> Result<Raw> {
        let Parsed { table, columns, channels, texts, names, facts, long } = self;
        let LongTable { recordings: mut all, x, timing, mended, mut steps, doubts } = long;
        let file = table.file.clone();
        let name = |at: usize| table.header[at].clone();
        let mut y_names: Vec<String> = columns.labels.iter().map(|at| name(*at)).collect();
        if let Some(labels) = labels_by_recording {
            (y_names, steps) = (labels.names.clone(), None);
            set_labels(table, &mut all, labels)?;
        }
        let x = x.ok_or_else(|| Error::NoSamples { at: file.clone() })?;
        let stored = StoredTargets { table, all: &all, names: &y_names };
        let TableTargets { y, names, values, steps } =
            stored.read(steps.as_ref(), timing, (names, &facts), options)?;
        let mut warnings: Vec<String> = table.left_out.iter().cloned().chain(doubts).collect();
        warnings.extend(doubts_of_texts(table, texts)?);
        if values.is_none() && facts.quantities.is_none() {
            warnings.extend(doubts_of_labels(&file, &y_names, &all));
        }
        let values_are = values.as_ref().and_then(|values| values_said(values.quantities(), options));
        let read_as = described(table, columns, channels.len(), timing).into_iter().chain(mended.said());
        let groups = groups(&all, columns.group.map(name), &file, options)?;
        let official =
            columns.test.map(|at| (name(at), all.iter().filter_map(|recording| recording.mark).collect()));
        Ok(Raw {
            name: set,
            file,
            dtype: table.dtype().into(),
            format: layout(columns),
            channel_names: channels.iter().map(|at| name(*at)).collect(),
            x_name: "the table".into(),
            y_name: if y_names.is_empty() { "label".into() } else { y_names.join(", ") },
            y,
            columns: if values.is_some() { 1 } else { y_names.len().max(1) },
            names,
            values,
            steps,
            facts,
            groups,
            official,
            x,
            origins: all.into_iter().map(|recording| recording.name).collect(),
            others: texts.iter().map(|at| name(*at)).collect(),
            ignored: ignored(table, columns, texts),
            read_as: read_as.chain(values_are).collect(),
            warnings,
            table: Some(remembered(table, columns, channels)),
            ..Raw::default()
        })
    }
}

/// Lists the columns that are not read, and why; `texts` are passed over under another name.
fn ignored(table: &TableText, columns: &TableColumns, texts: &[usize]) -> Vec<String> {
    let used: Vec<usize> = columns.used().chain(columns.rest.iter().chain(texts).copied()).collect();
    let others = (0..table.header.len()).filter(|at| !used.contains(at));
    let why = |at: usize| {
        columns.left_out.iter().find(|(column, _)| *column == at).map(|(_, why)| format!(" ({why})"))
    };
    others.map(|at| format!("column {:?}{}", table.header[at], why(at).unwrap_or_default())).collect()
}

/// Labels of recordings from a table of their own.
pub(crate) struct LabelsByRecording {
    /// The columns.
    pub names: Vec<String>,
    pub of: HashMap<String, Vec<String>>,
}

/// Gives each recording its label.
fn set_labels(table: &TableText, all: &mut [TableRecording], labels: &LabelsByRecording) -> Result<()> {
    for recording in all {
        let label = labels.of.get(&recording.name).cloned();
        let why = || table.refuse(format!("recording {:?} has no row in labels.csv", recording.name));
        recording.labels = label.ok_or_else(why)?;
    }
    Ok(())
}

/// Returns the axes of a sample; none where the form and the shape of the rows leave them open.
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

/// Returns the options by which another table is read alike.
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

/// Refuses a table without channels, and a shape that those of a row do not have.
fn refuse_shape(table: &TableText, columns: &TableColumns, channels: usize) -> Result<()> {
    let TableColumns { form, shape, .. } = columns;
    if channels == 0 {
        let held = table.header.join(", ");
        return Err(table.refuse(format!("has no column of numbers beside labels and groups; it has {held}")));
    }
    if shape.is_empty() {
        return Ok(());
    }
    let (axes, wanted) = match form {
        TableForm::Wide => (1..=3, "one to three axes"),
        TableForm::Long => (2..=2, "two axes, rows and columns of taxels"),
    };
    if !axes.contains(&shape.len()) {
        let why = format!("is {form}, whose rows have {wanted}, and table.shape is {shape:?}");
        return Err(table.refuse(why));
    }
    let takes = shape.iter().fold(1usize, |all, axis| all.saturating_mul(*axis));
    if takes != channels {
        return Err(table.refuse(format!(
            "has {channels} channels in a row, and table.shape {shape:?} takes {takes}; say which with table.columns, or \
             which are none with table.ignore"
        )));
    }
    Ok(())
}

/// Says for the card how the table was read.
fn described(
    table: &TableText,
    columns: &TableColumns,
    channels: usize,
    timing: Option<Timing>,
) -> Vec<String> {
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
    let labels: Vec<String> = columns.labels.iter().map(|at| format!("{:?}", name(*at))).collect();
    parts.extend((!labels.is_empty()).then(|| format!("labels by {}", labels.join(", "))));
    parts.extend(role("groups", columns.group));
    parts.extend(table.has_decimal_commas().then(|| "decimals with commas".into()));
    let timing = timing.map(|timing| timing.to_string());
    [Some(parts.join(", ")), timing].into_iter().flatten().collect()
}

fn wide(
    table: &TableText,
    columns: &TableColumns,
    channels: &[usize],
    options: &ReadOptions,
) -> Result<LongTable> {
    let mut collected =
        Collected::new(&table.file, options.limits).of_about(table.likely_rows(channels.len()));
    let mut all = vec![];
    let mut values = vec![0.0; channels.len()];
    let mut precision = Precision::default();
    let list = [channels.len()];
    let shape = if columns.shape.is_empty() { &list[..] } else { &columns.shape };
    table.rows(|row: TableRow| {
        let name = match columns.recording {
            Some(at) => row.named(at)?,
            None => format!("line {}", row.line),
        };
        for (place, (value, at)) in values.iter_mut().zip(channels).enumerate() {
            *value = row.number(*at)?;
            if table.is_wide(*at) {
                precision.see(place, row.long_number(*at)?, *value);
            }
        }
        let recording = TableRecording::of(&row, name, columns)?;
        options.limits.refuse_samples(&table.file, all.len() as u64 + 1)?;
        collected.push(&recording.name, shape, &values, None, "")?;
        all.push(recording);
        Ok(true)
    })?;
    table.refuse_lossy(&precision, channels)?;
    let mended = Mended::default();
    Ok(LongTable {
        recordings: all,
        x: collected.finish(),
        timing: None,
        mended,
        steps: None,
        doubts: vec![],
    })
}

/// Returns groups: whole numbers as they are, texts as positions among those that occur.
fn groups(
    all: &[TableRecording],
    name: Option<String>,
    file: &str,
    options: &ReadOptions,
) -> Result<Option<NamedColumn>> {
    let refuse = |why| Err(Error::Option { file: file.into(), option: "group_block", why });
    let Some(name) = name else {
        return match options.group_block {
            None => Ok(None),
            Some(_) => refuse("needs a column to divide into blocks; name it with group = \"trial\""),
        };
    };
    let texts: Vec<String> = all.iter().filter_map(|recording| recording.group.clone()).collect();
    let numbers: Option<Vec<i64>> = texts.iter().map(|text| text.parse().ok()).collect();
    match (numbers, options.group_block) {
        (Some(numbers), _) => Ok(Some((name, numbers))),
        (None, Some(_)) => refuse("divides consecutive numbers, but the groups are texts; leave it out"),
        (None, None) => Ok(Some((name, group_numbers(texts).map_err(|why| Error::file(file, why))?))),
    }
}
