//! The long form of a table: rows of a recording are its readings over time.

use crate::formats::clock::Timing;
use crate::formats::table::columns::TableColumns;
use crate::formats::table::options::Clock;
use crate::formats::table::text_columns::{Row, TableText};
use crate::formats::timed::Timed;
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::collections::HashMap;

/// What a table says of one recording.
pub(crate) struct Recording {
    pub name: String,
    pub label: Option<String>,
    pub group: Option<String>,
    /// Not 0 where it is tested on.
    pub mark: Option<i64>,
    /// Of its first row.
    line: u64,
}

impl Recording {
    /// The recording that a row is, or starts.
    pub fn of(row: &Row, name: String, columns: &TableColumns) -> Result<Self> {
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
) -> Result<(Vec<Recording>, Option<Ragged>, Option<Timing>)> {
    let (all, mut timed) = gathered(table, columns, channels, options)?;
    if let Some((_, clock)) = columns.time {
        timed.stamps.iter_mut().for_each(|stamp| *stamp /= clock.per_second());
    }
    let timing = Timing::of(&timed.stamps(), options.stamped);
    if let Some(timing) = timing.filter(|timing| !timing.is_likely()) {
        let why = "its time stamps give no rate";
        return Err(
            table.refuse(format!("{why}, being {:e} s apart; say their unit with table.clock", timing.step))
        );
    }
    if all.is_empty() {
        return Ok((all, None, timing));
    }
    let refuse = |why| table.refuse(why);
    let x = timed.into_recordings(timing, &columns.shape, &table.file, options, refuse)?;
    Ok((all, Some(x), timing))
}

/// Recordings, and their rows, recording after recording.
fn gathered(
    table: &TableText,
    columns: &TableColumns,
    channels: &[usize],
    options: &ReadOptions,
) -> Result<(Vec<Recording>, Timed)> {
    #[expect(clippy::expect_used, reason = "no long form is chosen without it")]
    let recording = columns.recording.expect("a column of recordings");
    let mut all: Vec<Recording> = vec![];
    let mut timed = Timed { width: channels.len(), ..Timed::default() };
    let rows = table.likely_rows(channels.len());
    // Without the room it grows step by step, which takes twice the memory in the end.
    let _ = timed.values.try_reserve_exact(rows * channels.len());
    if columns.time.is_some() {
        let _ = timed.stamps.try_reserve_exact(rows);
    }
    let mut places: HashMap<String, usize> = HashMap::new();
    // Rows of a recording that come together, and its last time stamp.
    let (mut runs, mut last): (Vec<(usize, usize)>, Vec<f64>) = (vec![], vec![]);
    table.rows(|row: Row| {
        let own = Recording::of(&row, row.named(recording)?, columns)?;
        let at = match places.get(&own.name) {
            Some(at) => *at,
            None => {
                refuse_many(table, all.len(), options)?;
                places.insert(own.name.clone(), all.len());
                all.push(own);
                timed.rows.push(0);
                last.push(f64::NEG_INFINITY);
                all.len() - 1
            }
        };
        refuse_other(table, &all[at], &row, columns)?;
        refuse_values(table, (timed.values.len() + channels.len()) as f64, options)?;
        if let Some(time) = columns.time {
            last[at] = stamp_after(last[at], table, &row, &all[at].name, time)?;
            timed.stamps.push(last[at]);
        }
        for channel in channels {
            timed.values.push(row.number(*channel)?);
        }
        timed.rows[at] += 1;
        match runs.last_mut() {
            Some((own, rows)) if *own == at => *rows += 1,
            _ => runs.push((at, 1)),
        }
        Ok(true)
    })?;
    if runs.len() > all.len() {
        timed.sort(&runs);
    }
    Ok((all, timed))
}

/// Reads the time stamp of a row, which lies after `before`, that of the last row of the same recording.
fn stamp_after(
    before: f64,
    table: &TableText,
    row: &Row,
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

/// What is said of a recording is the same in each of its rows.
fn refuse_other(table: &TableText, own: &Recording, row: &Row, columns: &TableColumns) -> Result<()> {
    let said = [(columns.label, &own.label), (columns.group, &own.group)];
    let other = said.into_iter().filter_map(|(at, said)| Some((at?, said.as_deref()?)));
    for (at, said) in other {
        if row.text(at) != said {
            return Err(table.refuse(format!(
                "lines {} and {} are both recording {:?}, but {} is {said:?} and {:?}; say one for all its rows",
                own.line,
                row.line,
                own.name,
                table.header[at],
                row.text(at)
            )));
        }
    }
    match columns.test.map(|at| row.mark(at)).transpose()? == own.mark {
        true => Ok(()),
        false => Err(table.refuse(format!(
            "lines {} and {} are both recording {:?}, but one is to be tested on and the other is not",
            own.line, row.line, own.name
        ))),
    }
}

/// Refuses one more recording than allowed.
pub(crate) fn refuse_many(table: &TableText, recordings: usize, options: &ReadOptions) -> Result<()> {
    let (samples, limit) = (recordings as u64 + 1, options.limits.max_samples);
    match samples > limit {
        true => Err(Error::TooManySamples { at: table.file.clone(), samples, limit }),
        false => Ok(()),
    }
}

fn refuse_values(table: &TableText, values: f64, options: &ReadOptions) -> Result<()> {
    let limit = options.limits.max_values;
    match values > limit as f64 {
        true => Err(Error::TooLarge {
            at: table.file.clone(),
            shape: vec![values as u64],
            limit,
            hint: "take fewer recordings or raise limits.max_values",
        }),
        false => Ok(()),
    }
}
