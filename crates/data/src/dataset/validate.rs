//! Checks stored arrays: labels, groups, channels, values.

use crate::dataset::channel_names::places;
use crate::dataset::labels::refuse_unclear;
use crate::dataset::problems::Problems;
use crate::dataset::raw::{Names, Raw};
use crate::length::ragged::Ragged;
use crate::options::{ReadOptions, refuse_set};
use crate::{Error, Result};

/// Label of a row whose stored label is unusable; only inside a card.
const NO_LABEL: u32 = u32::MAX;

/// Returns the channels to keep; none for all of them. Channels that have names are found by these.
pub(crate) fn channels(raw: &Raw, options: &ReadOptions) -> Result<Option<Vec<usize>>> {
    if is_by_name(raw, options) {
        let by_name = places(&options.channel_names, &raw.channel_names);
        let by_name = by_name.map_err(|why| Error::file(&raw.file, why))?;
        if by_name.is_some() && raw.channel_names.len() != raw.x.shape()[1] {
            let why = "has its taxels in another order than the model; bring them into that order with table.columns";
            return Err(Error::file(&raw.file, why));
        }
        return Ok(by_name);
    }
    let Some(channels) = &options.channels else {
        return Ok(None);
    };
    let refuse = |why: String| Err(Error::file(&raw.file, format!("channels{why}")));
    if channels.is_empty() {
        return refuse(" = []: name at least one channel, or leave the key out".into());
    }
    let shape = raw.x.shape();
    let mut seen = vec![false; shape[1]];
    for channel in channels {
        match seen.get_mut(*channel) {
            None => {
                let last = shape[1] - 1;
                return refuse(format!(": {channel} is out of range: axis 1 of {shape:?} has 0..{last}"));
            }
            Some(true) => return refuse(format!(": {channel} is listed twice; name each channel once")),
            Some(seen) => *seen = true,
        }
    }
    Ok(Some(channels.clone()))
}

/// Checks whether channels are found by the names that a model expects, in place of their numbers.
pub(crate) fn is_by_name(raw: &Raw, options: &ReadOptions) -> bool {
    !options.channel_names.is_empty() && !raw.channel_names.is_empty()
}

/// Returns the name of a label in messages: `y[17]` or `y[17, 2]`.
fn label_at(raw: &Raw, row: usize, column: usize) -> String {
    match raw.columns {
        1 => format!("{}[{row}]", raw.y_name),
        _ => format!("{}[{row}, {column}]", raw.y_name),
    }
}

/// Returns the names of one column, if the file of names fits the labels.
fn names_of(raw: &Raw, column: usize) -> Option<(&Names, &Vec<String>)> {
    let names = raw.names.as_ref()?;
    let fits = names.columns.len() == raw.columns;
    names.columns.get(column).filter(|_| fits).map(|list| (names, list))
}

/// Refuses an array that has `len` values in place of one per sample.
pub(crate) fn wrong_length(raw: &Raw, array: &str, len: usize) -> Error {
    Error::Length {
        file: raw.file.clone(),
        array: array.into(),
        len,
        x: raw.x_name.clone(),
        samples: if array == raw.y_name { raw.target_rows() } else { raw.x.len() },
    }
}

/// Returns all labels `[N * columns]`, unusable ones as [`NO_LABEL`].
pub(crate) fn labels(raw: &Raw, faults: &mut Problems) -> Vec<u32> {
    let (samples, columns) = (raw.target_rows(), raw.columns);
    if raw.y.len() != samples * columns {
        faults.push(wrong_length(raw, &raw.y_name, raw.y.len() / raw.columns));
    }
    if let Some(names) = raw.names.as_ref().filter(|n| n.columns.len() != columns) {
        let why =
            format!("names {} columns of labels, but {} has {columns}", names.columns.len(), raw.y_name);
        faults.push(Error::labels_form(&names.file, why));
    }
    let mut table = vec![NO_LABEL; samples * columns];
    let (mut negative, mut range) = (None, None);
    for (i, (label, value)) in table.iter_mut().zip(&raw.y).enumerate() {
        let (row, column, value) = (i / columns, i % columns, *value);
        let named = names_of(raw, column);
        // Without names there are at most as many classes as samples, or there is a gap.
        let classes = named.map_or(samples, |(_, list)| list.len());
        if value < 0 {
            faults.more(&mut negative, || {
                let at = label_at(raw, row, column);
                Error::file(&raw.file, format!("{at} = {value} is negative; number the classes from 0"))
            });
        } else if value < classes as i64 {
            *label = value as u32;
        } else if let Some((names, list)) = named {
            faults.more(&mut range, || {
                let (at, classes, last) =
                    (label_at(raw, row, column), list.len(), list.len().saturating_sub(1));
                let named = format!("{} names {classes} classes (0..{last})", names.file);
                Error::file(&raw.file, format!("{at} = {value} is out of range: {named}"))
            });
        }
    }
    table
}

/// Returns the names of each column's labels; numbers where no file names them.
pub(crate) fn class_names(raw: &Raw, table: &[u32]) -> Vec<Vec<String>> {
    let column_names = |column: usize| match names_of(raw, column) {
        Some((_, list)) => list.clone(),
        None => {
            let samples = raw.target_rows();
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

/// Refuses names of classes that cannot be told apart, and names of classes and channels with control characters.
pub(crate) fn unclear_names(raw: &Raw, classes: &[Vec<String>], faults: &mut Problems) {
    for names in classes {
        if let Err(why) = refuse_unclear("class", names) {
            faults.push(Error::file(&raw.file, why));
        }
    }
    let steers = |name: &&String| name.chars().any(char::is_control);
    if let Some(name) = raw.channel_names.iter().find(steers) {
        let why = format!("the channel name {name:?} holds a control character; rename it");
        faults.push(Error::file(&raw.file, why));
    }
}

/// Refuses classes without a sample: their output would never be trained.
pub(crate) fn gaps(raw: &Raw, table: &[u32], kept: &[usize], classes: &[Vec<String>], faults: &mut Problems) {
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
            faults.more(&mut empty, || {
                let y = &raw.y_name;
                let at = if raw.columns == 1 { y.clone() } else { format!("{y}[:, {column}]") };
                let name = if named { format!(" ({name})") } else { String::new() };
                let hint = match (stored[label], named) {
                    (true, _) => "all of them were dropped: drop less or remove the class",
                    (false, true) => "record some or remove its name",
                    (false, false) => "number the classes from 0 without gaps",
                };
                Error::file(&raw.file, format!("no sample in {at} has label {label}{name}; {hint}"))
            });
        }
    }
}

/// Refuses samples that are all of one class.
pub(crate) fn one_class(raw: &Raw, classes: &[String], y: &[u32], faults: &mut Problems) {
    // A label out of range has been refused already.
    let Some(class) = y.first().and_then(|label| classes.get(*label as usize)) else { return };
    if y.iter().all(|label| *label == y[0]) {
        faults.push(Error::OneClass { file: raw.file.clone(), class: class.clone() });
    }
}

/// Returns the name of the groups, and the group of each sample.
pub(crate) fn groups(
    raw: &Raw,
    options: &ReadOptions,
    faults: &mut Problems,
) -> Result<Option<(String, Vec<u32>)>> {
    let why = "is the number of consecutive values in a block, from 1";
    refuse_set(&raw.file, &[("group_block", options.group_block == Some(0))], why)?;
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
            faults.more(&mut range, || {
                let why = "is not a group number (0..4294967295); use group_block";
                Error::file(&raw.file, format!("{name}[{row}] = {value} {why}"))
            });
            u32::MAX
        }));
    }
    let name = match options.group_block {
        Some(block) => format!("{name}/{block}"),
        None => name.clone(),
    };
    Ok(Some((name, groups)))
}

/// Returns which samples the authors test on.
pub(crate) fn official(raw: &Raw, options: &ReadOptions, faults: &mut Problems) -> Option<Vec<bool>> {
    let (name, values) = raw.official.as_ref()?;
    if values.len() != raw.x.len() {
        faults.push(wrong_length(raw, name, values.len()));
        return None;
    }
    let odd = values.iter().enumerate().find(|(_, value)| !(0..=1).contains(*value));
    if let Some((row, value)) = odd.filter(|_| options.test_above.is_none()) {
        let why = format!(
            "{name}[{row}] = {value} is no mark: 0 is trained on and 1 tested; to test the samples above a number, say \
             test_above"
        );
        faults.push(Error::file(&raw.file, why));
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

/// Notes values that are NaN or infinite; `sample` names a row in messages.
pub(crate) fn not_finite(
    x: &Ragged,
    channels: Option<&[usize]>,
    faults: &mut Problems,
    sample: impl Fn(usize) -> String,
) {
    let mut at = None;
    for (row, values) in x.each().enumerate() {
        for (flat, value) in values.iter().enumerate().filter(|(_, value)| !value.is_finite()) {
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

/// Returns the index along each axis of the `flat`-th value of a sample in C order.
fn index_in(shape: &[usize], mut flat: usize) -> Vec<usize> {
    let mut index = vec![0; shape.len()];
    for (place, axis) in index.iter_mut().zip(shape).rev() {
        *place = flat % axis;
        flat /= axis;
    }
    index
}
