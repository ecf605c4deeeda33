//! Reads labels, groups and marks as a file stores them: whole numbers or texts.

use crate::formats::archive::Archive;
use crate::formats::npy::Cap;
use crate::formats::npy_text;
use crate::options::Limits;
use crate::{Error, Result};

/// Values row by row.
pub(crate) enum StoredValues {
    Numbers(Vec<i64>),
    Texts(Vec<String>),
}

/// The content of `[N]` or `[N, k]`.
pub(crate) struct Column {
    pub values: StoredValues,
    /// Number of values of a sample; none of an array of another shape.
    pub columns: Option<usize>,
}

/// Reads one array, or two one after the other; `wanted` says how to fix values of another type.
pub(crate) fn column(
    archive: &mut Archive,
    arrays: &[String],
    option: &'static str,
    wanted: &'static str,
    limits: &Limits,
) -> Result<Column> {
    let mut all: Option<Column> = None;
    for array in arrays {
        let next = one(archive, array, option, wanted, limits)?;
        all = Some(match all {
            None => next,
            Some(before) => before.followed_by(next).ok_or_else(|| parts_differ(archive, arrays, array))?,
        });
    }
    all.ok_or_else(|| Error::NoSamples { at: archive.file().into() })
}

/// Says that an array is not like the first of several.
pub(crate) fn parts_differ(archive: &Archive, arrays: &[String], array: &str) -> Error {
    let why = "are not alike; give both the same type and number of columns";
    Error::file(archive.file(), format!("{} and {array} {why}", arrays[0]))
}

impl Column {
    /// Joins both, where they are of one kind.
    fn followed_by(self, next: Self) -> Option<Self> {
        let columns = self.columns.filter(|columns| next.columns == Some(*columns))?;
        let values = match (self.values, next.values) {
            (StoredValues::Numbers(a), StoredValues::Numbers(b)) => StoredValues::Numbers([a, b].concat()),
            (StoredValues::Texts(a), StoredValues::Texts(b)) => StoredValues::Texts([a, b].concat()),
            _ => return None,
        };
        Some(Self { values, columns: Some(columns) })
    }
}

fn one(
    archive: &mut Archive,
    array: &str,
    option: &'static str,
    wanted: &'static str,
    limits: &Limits,
) -> Result<Column> {
    let cap = Cap::of_labels(limits);
    if let Some(texts) = archive.texts(array, &archive.at(array), cap)? {
        return Ok(Column { columns: columns(&texts.shape), values: StoredValues::Texts(texts.values) });
    }
    archive.with(array, option, |header, reader, at| {
        let header = &header.as_column();
        let Some(columns) = columns(&header.shape) else {
            return Ok(Column { values: StoredValues::Numbers(vec![]), columns: None });
        };
        let values = if npy_text::is_text(header) {
            StoredValues::Texts(npy_text::read(header, reader, at, cap)?)
        } else {
            StoredValues::Numbers(header.read_i64(reader, at, cap, wanted)?)
        };
        Ok(Column { values, columns: Some(columns) })
    })
}

/// Returns the number of values of a sample in an array `[N]` or `[N, k]`.
pub(crate) fn columns(shape: &[u64]) -> Option<usize> {
    match *shape {
        [_] => Some(1),
        [_, columns] if columns > 0 => Some(columns as usize),
        _ => None,
    }
}
