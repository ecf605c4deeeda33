//! The long form of a table: rows of a recording are its readings over time.

use crate::clock::Timing;
use crate::options::Options;
use crate::ragged::Collected;
use crate::table_columns::TableColumns;
use crate::table_text::{Row, TableText};
use crate::{Error, Result};
use std::collections::HashMap;

/// Seconds between readings that are time stamps and not something else.
const STEPS: std::ops::Range<f64> = 1e-12..1e12;

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

/// Readings in the order of the rows.
#[derive(Default)]
struct Readings {
    /// In the unit of the table, then in seconds.
    times: Vec<f64>,
    /// `[time, channels]`.
    values: Vec<f32>,
}

/// Reads all recordings, in the order in which they begin, and adds them to `collected` as `[C, T]`: where stamps
/// are irregular, at equal steps.
pub(crate) fn read(
    table: &TableText,
    columns: &TableColumns,
    channels: &[usize],
    options: &Options,
    collected: &mut Collected,
) -> Result<(Vec<Recording>, Option<Timing>)> {
    let (all, mut readings) = gathered(table, columns, channels, options)?;
    if let Some((_, clock)) = columns.time {
        let seconds = |stamp: &mut f64| *stamp /= clock.per_second();
        readings.iter_mut().flat_map(|own| &mut own.times).for_each(seconds);
    }
    let stamps: Vec<&[f64]> = readings.iter().map(|own| own.times.as_slice()).collect();
    let timing = Timing::of(&stamps);
    if let Some(timing) = timing.filter(|timing| !STEPS.contains(&timing.step)) {
        let why = "its time stamps give no rate";
        return Err(
            table.refuse(format!("{why}, being {:e} s apart; say their unit with table.clock", timing.step))
        );
    }
    let uneven = timing.filter(|timing| !timing.is_regular);
    if let Some(timing) = &uneven {
        if let Some(why) = timing.gaps(&stamps) {
            return Err(table.refuse(why));
        }
        let readings: f64 = stamps.iter().map(|times| timing.readings(times)).sum();
        refuse_values(table, readings * channels.len() as f64, options)?;
    }
    for (own, Readings { times, values }) in all.iter().zip(readings) {
        let values = match &uneven {
            Some(timing) => timing.resampled(&times, &values, channels.len()),
            None => transposed(&values, channels.len()),
        };
        let shape = [channels.len(), values.len() / channels.len()];
        collected.push(&own.name, &shape, &values, Some(1), "")?;
    }
    Ok((all, timing))
}

/// Recordings, and the rows of each.
fn gathered(
    table: &TableText,
    columns: &TableColumns,
    channels: &[usize],
    options: &Options,
) -> Result<(Vec<Recording>, Vec<Readings>)> {
    #[expect(clippy::expect_used, reason = "no long form is chosen without it")]
    let recording = columns.recording.expect("a column of recordings");
    let (mut all, mut readings): (Vec<Recording>, Vec<Readings>) = (vec![], vec![]);
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut count = 0;
    table.rows(|row: Row| {
        let own = Recording::of(&row, row.named(recording)?, columns)?;
        let at = match places.get(&own.name) {
            Some(at) => *at,
            None => {
                refuse_many(table, all.len(), options)?;
                places.insert(own.name.clone(), all.len());
                all.push(own);
                readings.push(Readings::default());
                all.len() - 1
            }
        };
        refuse_other(table, &all[at], &row, columns)?;
        count += channels.len() as u64;
        refuse_values(table, count as f64, options)?;
        if let Some((time, clock)) = columns.time {
            let stamp = row.stamp(time)?;
            if let Some(before) = readings[at].times.last().filter(|before| **before >= stamp) {
                let (line, own, unit) = (row.line, &all[at].name, clock.name());
                return Err(table.refuse(format!(
                    "line {line}: the time of recording {own:?} goes from {before} to {stamp} {unit}; sort its rows by \
                     time, without doubles"
                )));
            }
            readings[at].times.push(stamp);
        }
        for channel in channels {
            readings[at].values.push(row.number(*channel)?);
        }
        Ok(true)
    })?;
    Ok((all, readings))
}

/// `[time, channels]` as `[channels, time]`.
fn transposed(values: &[f32], channels: usize) -> Vec<f32> {
    (0..channels).flat_map(|channel| values.iter().skip(channel).step_by(channels)).copied().collect()
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
pub(crate) fn refuse_many(table: &TableText, recordings: usize, options: &Options) -> Result<()> {
    let (samples, limit) = (recordings as u64 + 1, options.limits.max_samples);
    match samples > limit {
        true => Err(Error::TooManySamples { at: table.file.clone(), samples, limit }),
        false => Ok(()),
    }
}

fn refuse_values(table: &TableText, values: f64, options: &Options) -> Result<()> {
    let limit = options.limits.max_values;
    match values > limit as f64 {
        true => Err(Error::TooLarge {
            at: table.file.clone(),
            shape: vec![values as u64],
            limit,
            hint: "take fewer recordings or raise limits.max-values",
        }),
        false => Ok(()),
    }
}
