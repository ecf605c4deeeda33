//! Reads the long form of a table: the rows of a recording are its time steps.

use crate::Result;
use crate::formats::clock::Timing;
use crate::formats::table::columns::TableColumns;
use crate::formats::table::options::Clock;
use crate::formats::table::text_columns::{TableRow, TableText};
use crate::formats::timed::Timed;
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use std::collections::HashMap;

/// One recording of a table, without its values.
pub(crate) struct TableRecording {
    pub name: String,
    pub label: Option<String>,
    pub group: Option<String>,
    /// Not 0 where it is tested on.
    pub mark: Option<i64>,
    /// Line of its first row.
    line: u64,
}

impl TableRecording {
    /// Takes name, label, group and mark of a recording from a row.
    pub fn of(row: &TableRow, name: String, columns: &TableColumns) -> Result<Self> {
        Ok(Self {
            name,
            label: columns.label.map(|at| row.named(at)).transpose()?,
            group: columns.group.map(|at| row.named(at)).transpose()?,
            mark: columns.test.map(|at| row.mark(at)).transpose()?,
            line: row.line,
        })
    }
}

/// Reads all recordings, in the order in which they begin, as `[C, T]`, or as `[T, H, W]` where a row has a shape: where
/// stamps are irregular, at equal steps.
pub(crate) fn read(
    table: &TableText,
    columns: &TableColumns,
    channels: &[usize],
    options: &ReadOptions,
) -> Result<(Vec<TableRecording>, Option<Ragged>, Option<Timing>)> {
    let (all, mut timed) = gathered(table, columns, channels, options)?;
    if let Some((_, clock)) = columns.time {
        timed.stamps.iter_mut().for_each(|stamp| *stamp /= clock.per_second());
    }
    let timing = Timing::of(&timed.stamps(), options.stamped);
    if let Some(timing) = timing.filter(|timing| !timing.is_likely()) {
        let why = "its time stamps give no rate";
        let how = "say their unit with table.clock";
        return Err(table.refuse(format!("{why}, being {:e} s apart; {how}", timing.step)));
    }
    if all.is_empty() {
        return Ok((all, None, timing));
    }
    let x = timed.into_recordings(timing, &columns.shape, &table.file, options)?;
    Ok((all, Some(x), timing))
}

/// Gathers the recordings, and their rows, recording after recording.
fn gathered(
    table: &TableText,
    columns: &TableColumns,
    channels: &[usize],
    options: &ReadOptions,
) -> Result<(Vec<TableRecording>, Timed)> {
    #[expect(clippy::expect_used, reason = "no long form is chosen without it")]
    let recording = columns.recording.expect("a column of recordings");
    let mut all: Vec<TableRecording> = vec![];
    let mut timed = Timed { width: channels.len(), ..Timed::default() };
    let rows = table.likely_rows(channels.len());
    // Growing step by step would take twice the memory in the end.
    let _ = timed.values.try_reserve_exact(rows * channels.len());
    if columns.time.is_some() {
        let _ = timed.stamps.try_reserve_exact(rows);
    }
    let mut places: HashMap<String, usize> = HashMap::new();
    // Rows that come together, by recording; and the last time stamp of each recording.
    let (mut runs, mut last): (Vec<(usize, usize)>, Vec<f64>) = (vec![], vec![]);
    table.rows(|row: TableRow| {
        let read = TableRecording::of(&row, row.named(recording)?, columns)?;
        let at = match places.get(&read.name) {
            Some(at) => *at,
            None => {
                options.limits.refuse_samples(&table.file, all.len() as u64 + 1)?;
                places.insert(read.name.clone(), all.len());
                all.push(read);
                timed.rows.push(0);
                last.push(f64::NEG_INFINITY);
                all.len() - 1
            }
        };
        refuse_other(table, &all[at], &row, columns)?;
        options.limits.refuse_values(&table.file, timed.values.len() + channels.len())?;
        if let Some(time) = columns.time {
            last[at] = stamp_after(last[at], table, &row, &all[at].name, time)?;
            timed.stamps.push(last[at]);
        }
        for channel in channels {
            timed.values.push(row.number(*channel)?);
        }
        timed.rows[at] += 1;
        match runs.last_mut() {
            Some((recording, rows)) if *recording == at => *rows += 1,
            _ => runs.push((at, 1)),
        }
        Ok(true)
    })?;
    if runs.len() > all.len() {
        timed.sort(&runs);
    }
    Ok((all, timed))
}

/// Reads the time stamp of a row, which must be later than `before`, that of the last row of the same recording.
fn stamp_after(
    before: f64,
    table: &TableText,
    row: &TableRow,
    recording: &str,
    (time, clock): (usize, Clock),
) -> Result<f64> {
    let stamp = row.stamp(time)?;
    if before >= stamp {
        let (line, unit) = (row.line, clock.name());
        return Err(table.refuse(format!(
            "line {line}: the time of recording {recording:?} goes from {before} to {stamp} {unit}; sort its rows by \
             time, without doubles"
        )));
    }
    Ok(stamp)
}

/// Refuses a row whose label, group or mark differs from that of its recording.
fn refuse_other(
    table: &TableText,
    recording: &TableRecording,
    row: &TableRow,
    columns: &TableColumns,
) -> Result<()> {
    let (name, first, line) = (&recording.name, recording.line, row.line);
    let said = [(columns.label, &recording.label), (columns.group, &recording.group)];
    let other = said.into_iter().filter_map(|(at, said)| Some((at?, said.as_deref()?)));
    for (at, said) in other {
        if row.text(at) != said {
            return Err(table.refuse(format!(
                "lines {first} and {line} are both recording {name:?}, but {} is {said:?} and {:?}; say one for all its \
                 rows",
                table.header[at],
                row.text(at)
            )));
        }
    }
    if columns.test.map(|at| row.mark(at)).transpose()? != recording.mark {
        return Err(table.refuse(format!(
            "lines {first} and {line} are both recording {name:?}, but one is to be tested on and the other is not"
        )));
    }
    Ok(())
}
