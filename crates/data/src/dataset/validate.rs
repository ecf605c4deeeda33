//! Checks of stored arrays: labels, groups, channels, values.

use crate::dataset::problems::Faults;
use crate::dataset::raw::{Names, Raw};
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use crate::{Error, Result};

/// Label of a row whose stored label is unusable; only inside a card.
const NO_LABEL: u32 = u32::MAX;

/// The channels to keep; none for all of them.
pub(crate) fn channels(raw: &Raw, options: &ReadOptions) -> Result<Option<Vec<usize>>> {
    let Some(channels) = &options.channels else {
        return Ok(None);
    };
    let file = raw.file.clone();
    if channels.is_empty() {
        return Err(Error::NoChannels { file });
    }
    let shape = raw.x.shape();
    let mut seen = vec![false; shape[1]];
    for channel in channels {
        match seen.get_mut(*channel) {
            None => {
                return Err(Error::ChannelRange { file, channel: *channel, last: shape[1] - 1, shape });
            }
            Some(true) => {
                return Err(Error::ChannelTwice { file, channel: *channel });
            }
            Some(seen) => *seen = true,
        }
    }
    Ok(Some(channels.clone()))
}

/// How a label is written in a message: `y[17]` or `y[17, 2]`.
fn label_at(raw: &Raw, row: usize, column: usize) -> String {
    match raw.columns {
        1 => format!("{}[{row}]", raw.y_name),
        _ => format!("{}[{row}, {column}]", raw.y_name),
    }
}

/// The names of one column, if the file of names fits the labels.
fn names_of(raw: &Raw, column: usize) -> Option<(&Names, &Vec<String>)> {
    let names = raw.names.as_ref()?;
    let fits = names.columns.len() == raw.columns;
    names.columns.get(column).filter(|_| fits).map(|list| (names, list))
}

/// `array` has `len` values in place of one per sample.
pub(crate) fn wrong_length(raw: &Raw, array: &str, len: usize) -> Error {
    Error::Length {
        file: raw.file.clone(),
        array: array.into(),
        len,
        x: raw.x_name.clone(),
        samples: raw.x.len(),
    }
}

/// All labels `[N * columns]`, unusable ones as [`NO_LABEL`].
pub(crate) fn labels(raw: &Raw, faults: &mut Faults) -> Vec<u32> {
    let (samples, columns) = (raw.x.len(), raw.columns);
    if raw.y.len() != samples * columns {
        faults.push(wrong_length(raw, &raw.y_name, raw.y.len() / raw.columns));
    }
    if let Some(names) = raw.names.as_ref().filter(|n| n.columns.len() != columns) {
        faults.push(Error::LabelsForm {
            file: names.file.clone(),
            why: format!("names {} columns of labels, but {} has {columns}", names.columns.len(), raw.y_name),
        });
    }
    let mut table = vec![NO_LABEL; samples * columns];
    let (mut negative, mut range) = (None, None);
    for (i, (label, value)) in table.iter_mut().zip(&raw.y).enumerate() {
        let (row, column, value) = (i / columns, i % columns, *value);
        let file = || raw.file.clone();
        let named = names_of(raw, column);
        // Without names there are at most as many classes as samples, or there is a gap.
        let classes = named.map_or(samples, |(_, list)| list.len());
        if value < 0 {
            let error = || Error::NegativeLabel { file: file(), at: label_at(raw, row, column), value };
            faults.more(&mut negative, error);
        } else if value < classes as i64 {
            *label = value as u32;
        } else if let Some((names, list)) = named {
            let error = || Error::LabelRange {
                file: file(),
                at: label_at(raw, row, column),
                value,
                names: names.file.clone(),
                classes: list.len(),
                last: list.len().saturating_sub(1),
            };
            faults.more(&mut range, error);
        }
    }
    table
}

/// Names of each column's labels; numbers where no file names them.
pub(crate) fn class_names(raw: &Raw, table: &[u32]) -> Vec<Vec<String>> {
    let column_names = |column: usize| match names_of(raw, column) {
        Some((_, list)) => list.clone(),
        None => {
            let samples = raw.x.len();
            let stored = raw.y.iter().skip(column).step_by(raw.columns);
            let beyond = stored.into_iter().any(|value| *value >= samples as i64);
            let labels = table.iter().skip(column).step_by(raw.columns);
            let usable = labels.filter(|label| **label != NO_LABEL).max();
            let count = if beyond { samples } else { usable.map_or(0, |label| *label as usize + 1) };
            (0..count).map(|label| label.to_string()).collect()
        }
    };
    (0..raw.columns).map(column_names).collect()
}

/// Every class must have a sample, or its output is never trained.
pub(crate) fn gaps(raw: &Raw, table: &[u32], kept: &[usize], classes: &[Vec<String>], faults: &mut Faults) {
    for (column, names) in classes.iter().enumerate() {
        let (mut stored, mut left) = (vec![false; names.len()], vec![false; names.len()]);
        let label = |row: usize| table[row * raw.columns + column] as usize;
        for row in 0..table.len() / raw.columns {
            if let Some(seen) = stored.get_mut(label(row)) {
                *seen = true;
            }
        }
        for row in kept {
            if let Some(seen) = left.get_mut(label(*row)) {
                *seen = true;
            }
        }
        let mut empty = None;
        for (label, name) in names.iter().enumerate().filter(|(label, _)| !left[*label]) {
            let named = names_of(raw, column).is_some();
            let error = || Error::EmptyClass {
                file: raw.file.clone(),
                at: match raw.columns {
                    1 => raw.y_name.clone(),
                    _ => format!("{}[:, {column}]", raw.y_name),
                },
                label,
                name: if named { format!(" ({name})") } else { String::new() },
                hint: match (stored[label], named) {
                    (true, _) => "all of them were dropped: drop less or remove the class",
                    (false, true) => "record some or remove its name",
                    (false, false) => "number the classes from 0 without gaps",
                },
            };
            faults.more(&mut empty, error);
        }
    }
}

/// Samples of one class say nothing about another.
pub(crate) fn one_class(raw: &Raw, classes: &[String], y: &[u32], faults: &mut Faults) {
    // A label out of range is a fault of its own.
    let Some(class) = y.first().and_then(|label| classes.get(*label as usize)) else { return };
    if y.iter().all(|label| *label == y[0]) {
        faults.push(Error::OneClass { file: raw.file.clone(), class: class.clone() });
    }
}

/// The group of each sample and what the groups are.
pub(crate) fn groups(
    raw: &Raw,
    options: &ReadOptions,
    faults: &mut Faults,
) -> Result<Option<(String, Vec<u32>)>> {
    if options.group_block == Some(0) {
        return Err(Error::Option {
            file: raw.file.clone(),
            option: "group_block",
            why: "is the number of consecutive values in a block, from 1",
        });
    }
    let Some((name, values)) = &raw.groups else {
        return Ok(None);
    };
    let samples = raw.x.len();
    if values.len() != samples {
        faults.push(wrong_length(raw, name, values.len()));
        return Ok(None);
    }
    #[expect(clippy::expect_used, reason = "readers refuse a set without samples")]
    let lowest = i128::from(*values.iter().min().expect("one value per sample"));
    let (mut groups, mut range) = (Vec::with_capacity(samples), None);
    for (row, value) in values.iter().enumerate() {
        let group = match options.group_block {
            Some(block) => (i128::from(*value) - lowest) / i128::from(block),
            None => i128::from(*value),
        };
        groups.push(u32::try_from(group).unwrap_or_else(|_| {
            let error =
                || Error::GroupRange { file: raw.file.clone(), at: format!("{name}[{row}]"), value: *value };
            faults.more(&mut range, error);
            u32::MAX
        }));
    }
    let name = match options.group_block {
        Some(block) => format!("{name}/{block}"),
        None => name.clone(),
    };
    Ok(Some((name, groups)))
}

/// Which samples the authors test on.
pub(crate) fn official(raw: &Raw, options: &ReadOptions, faults: &mut Faults) -> Option<Vec<bool>> {
    let (name, values) = raw.official.as_ref()?;
    if values.len() != raw.x.len() {
        faults.push(wrong_length(raw, name, values.len()));
        return None;
    }
    let is_tested = |value: &i64| options.test_above.map_or(*value != 0, |above| *value > above);
    let test: Vec<bool> = values.iter().map(is_tested).collect();
    if test.iter().all(|t| *t) || !test.iter().any(|t| *t) {
        let file = raw.file.clone();
        let why = "leaves no or all samples to test; choose a value inside the range of the test array";
        faults.push(match options.test_above {
            Some(_) => Error::Option { file, option: "test_above", why },
            None => Error::OneSided { file, array: name.clone() },
        });
    }
    Some(test)
}

/// Notes values that are NaN or infinite; `sample` names a row.
pub(crate) fn not_finite(
    x: &Ragged,
    channels: Option<&[usize]>,
    faults: &mut Faults,
    sample: impl Fn(usize) -> String,
) {
    let mut at = None;
    for (row, own) in x.each().enumerate() {
        for (flat, value) in own.iter().enumerate().filter(|(_, value)| !value.is_finite()) {
            let error = || {
                let mut inside = index_in(&x.shape_of(row), flat);
                if let (Some(first), Some(channels)) = (inside.first_mut(), channels) {
                    *first = channels[*first];
                }
                Error::NotFinite { sample: sample(row), index: inside, value: *value }
            };
            faults.more(&mut at, error);
        }
    }
}

/// The index along each axis of the `flat`-th value of a sample in C order.
fn index_in(shape: &[usize], mut flat: usize) -> Vec<usize> {
    let mut index = vec![0; shape.len()];
    for (place, axis) in index.iter_mut().zip(shape).rev() {
        *place = flat % axis;
        flat /= axis;
    }
    index
}
