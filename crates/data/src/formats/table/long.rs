//! Reads the long form of a table: the rows of a recording are its time steps.

use crate::check::rates;
use crate::dataset::precision::Precision;
use crate::formats::clock::Timing;
use crate::formats::stamps::{Mended, Stamp, StampRule, TOO_MANY};
use crate::formats::table::columns::TableColumns;
use crate::formats::table::filled_in::NoNumbers;
use crate::formats::table::label_changes::{LabelChanges, StepLabels};
use crate::formats::table::options::Clock;
use crate::formats::table::recording::TableRecording;
use crate::formats::table::text_columns::{TableRow, TableText};
use crate::formats::timed::Timed;
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::collections::HashMap;

/// A long table: its recordings, their values, and what its stamps say.
pub(crate) struct LongTable {
    pub recordings: Vec<TableRecording>,
    pub x: Option<Ragged>,
    pub timing: Option<Timing>,
    pub mended: Mended,
    /// The labels of each row, where those of a recording change.
    pub steps: Option<StepLabels>,
    /// Doubts about time stamps and filled-in cells.
    pub doubts: Vec<String>,
}

/// Reads all recordings, in the order in which they begin, as `[C, T]`, or as `[T, H, W]` where a row has a shape: where
/// stamps are irregular, at equal steps.
pub(crate) fn read(
    table: &TableText,
    columns: &TableColumns,
    channels: &[usize],
    options: &ReadOptions,
) -> Result<LongTable> {
    let mut gathered = Gathered::of(table, columns, channels, options)?;
    let mended = gathered.mended()?;
    let Gathered { recordings, mut timed, changes, missing, .. } = gathered;
    if let Some((_, clock)) = columns.time {
        timed.stamps.iter_mut().for_each(|stamp| *stamp /= clock.per_second());
    }
    let timing = Timing::of(&timed.stamps(), options.stamped);
    if let Some(timing) = timing.filter(|timing| !timing.is_likely()) {
        let why = "its time stamps give no rate";
        let how = "say their unit with table.clock";
        return Err(table.refuse(format!("{why}, being {:e} s apart; {how}", timing.step)));
    }
    let steps = changes.of_rows(&recordings, &timed);
    let mut doubts: Vec<String> =
        missing.said().map(|words| format!("{}: {words}", table.file)).into_iter().collect();
    doubts.extend(rates::doubts(&table.file, &timed.stamps(), |row| {
        format!("recording {:?}", recordings[row].name)
    }));
    if recordings.is_empty() {
        return Ok(LongTable { recordings, x: None, timing, mended, steps, doubts });
    }
    let x = timed.into_recordings(timing, &columns.shape, &table.file, options)?;
    Ok(LongTable { recordings, x: Some(x), timing, mended, steps, doubts })
}

/// The recordings of a table while its rows are read.
struct Gathered<'t> {
    table: &'t TableText,
    columns: &'t TableColumns,
    channels: &'t [usize],
    recordings: Vec<TableRecording>,
    /// Their stamps.
    rules: Vec<StampRule>,
    places: HashMap<String, usize>,
    /// Their rows, in the order of the table until all are read.
    timed: Timed,
    /// Rows that come together, by recording.
    runs: Vec<(usize, usize)>,
    precision: Precision,
    /// Rows whose labels differ from those before.
    changes: LabelChanges,
    missing: NoNumbers,
}

impl<'t> Gathered<'t> {
    /// Gathers the rows of all recordings, recording after recording.
    fn of(
        table: &'t TableText,
        columns: &'t TableColumns,
        channels: &'t [usize],
        options: &ReadOptions,
    ) -> Result<Self> {
        #[expect(clippy::expect_used, reason = "no long form is chosen without it")]
        let recording = columns.recording.expect("a column of recordings");
        let mut all = Self {
            table,
            columns,
            channels,
            recordings: vec![],
            rules: vec![],
            places: HashMap::new(),
            timed: Timed { width: channels.len(), ..Timed::default() },
            runs: vec![],
            precision: Precision::default(),
            changes: LabelChanges::default(),
            missing: NoNumbers::default(),
        };
        let rows = table.likely_rows(channels.len());
        // Growing step by step would take twice the memory in the end.
        let _ = all.timed.values.try_reserve_exact(rows * channels.len());
        if columns.time.is_some() {
            let _ = all.timed.stamps.try_reserve_exact(rows);
        }
        table.rows(|row: TableRow| {
            let read = TableRecording::of(&row, row.named(recording)?, columns)?;
            all.add(read, &row, options)?;
            Ok(true)
        })?;
        table.refuse_lossy(&all.precision, channels)?;
        if all.runs.len() > all.recordings.len() {
            all.timed.sort(&all.runs);
        }
        Ok(all)
    }

    /// Adds a row, and its recording where that is new.
    fn add(&mut self, mut read: TableRecording, row: &TableRow, options: &ReadOptions) -> Result<()> {
        let table = self.table;
        let labels = std::mem::take(&mut read.labels);
        let at = match self.places.get(&read.name) {
            Some(at) => *at,
            None => {
                options.limits.refuse_samples(&table.file, self.recordings.len() as u64 + 1)?;
                self.places.insert(read.name.clone(), self.recordings.len());
                self.recordings.push(TableRecording { labels: labels.clone(), ..read });
                self.timed.rows.push(0);
                self.rules.push(StampRule::default());
                self.recordings.len() - 1
            }
        };
        let recording = &self.recordings[at];
        let is_torn = table.is_in_order
            && self.timed.rows[at] > 0
            && self.runs.last().is_some_and(|(last, _)| *last != at);
        if is_torn || row.file != recording.file {
            return Err(self.refused_again(recording, row));
        }
        refuse_other(table, recording, row, self.columns)?;
        options.limits.refuse_values(&table.file, self.timed.values.len() + self.channels.len())?;
        if let Some((time, clock)) = self.columns.time {
            let pushed = self.rules[at].push(row.stamp(time)?);
            match pushed.map_err(|why| self.refused_time(recording, row, &why, clock))? {
                Stamp::Later(stamp) => self.timed.stamps.push(stamp),
                Stamp::Repeated => return Ok(()),
            }
        }
        for (place, channel) in self.channels.iter().enumerate() {
            let value = row.number(*channel)?;
            self.missing.add(value, || row.place());
            if table.is_wide(*channel) {
                self.precision.see(place, row.long_number(*channel)?, value);
            }
            self.timed.values.push(value);
        }
        self.changes.see(at, self.timed.rows[at], &self.recordings[at], labels, row, self.columns);
        self.timed.rows[at] += 1;
        match self.runs.last_mut() {
            Some((recording, rows)) if *recording == at => *rows += 1,
            _ => self.runs.push((at, 1)),
        }
        Ok(())
    }

    /// Returns the name of the column of recordings.
    fn column(&self) -> &str {
        self.columns.recording.map_or("recording", |at| &self.table.header[at])
    }

    /// Refuses a row whose time is not later than that before.
    fn refused_time(&self, recording: &TableRecording, row: &TableRow, why: &str, clock: Clock) -> Error {
        row.refused(&format!("{} {:?} {why} (time in {})", self.column(), recording.name, clock.name()))
    }

    /// Refuses a row of a recording that was at an end: that of another file, or after rows of others.
    fn refused_again(&self, recording: &TableRecording, row: &TableRow) -> Error {
        row.refused(&format!(
            "{} {} was in {} from row {} on before: two episodes have one number; renumber those of one of the two, or leave \
             it out",
            self.column(),
            recording.name,
            recording.file,
            recording.line
        ))
    }

    /// Counts what was done about time stamps; refuses a clock that stands still.
    fn mended(&mut self) -> Result<Mended> {
        let mut all = Mended::default();
        let Some((time, _)) = self.columns.time else { return Ok(all) };
        for (rule, TableRecording { name, file, .. }) in self.rules.iter().zip(&self.recordings) {
            let mended = rule.finish().map_err(|count| {
                let column = &self.table.header[time];
                let how =
                    format!("write finer stamps, or leave the column out with table.ignore = [{column:?}]");
                Error::file(file, format!("{count} of recording {name:?} {TOO_MANY}; {how}"))
            })?;
            all.add(mended);
        }
        Ok(all)
    }
}

/// Refuses a row whose group or mark differs from that of its recording.
fn refuse_other(
    table: &TableText,
    recording: &TableRecording,
    row: &TableRow,
    columns: &TableColumns,
) -> Result<()> {
    let name = &recording.name;
    let kind = if table.is_text() { "lines" } else { "rows" };
    let both = || format!("{kind} {} and {} are both recording {name:?}", recording.line, row.line);
    let refuse = |why: String| Err(Error::file(row.file, format!("{}, but {why}", both())));
    if let Some((at, said)) = columns.group.zip(recording.group.as_deref())
        && row.text(at) != said
    {
        let (column, now) = (&table.header[at], row.text(at));
        return refuse(format!("{column} is {said:?} and {now:?}; say one for all its rows"));
    }
    if columns.test.map(|at| row.mark(at)).transpose()? != recording.mark {
        return refuse("one is to be tested on and the other is not".into());
    }
    Ok(())
}
