//! Labels, groups and marks as a file stores them: whole numbers or texts.

use crate::formats::archive::Archive;
use crate::formats::npy::Cap;
use crate::formats::npy_text;
use crate::options::Limits;
use crate::{Error, Result};

/// Values row by row.
pub(crate) enum Stored {
    Numbers(Vec<i64>),
    Texts(Vec<String>),
}

/// What `[N]` or `[N, k]` hold.
pub(crate) struct Column {
    pub values: Stored,
    /// Values of a sample; none of an array of another shape.
    pub columns: Option<usize>,
}

/// Reads one array, or two one after the other; `wanted` is said of values of another type.
pub(crate) fn column(
    archive: &mut Archive,
    file: &str,
    arrays: &[String],
    option: &'static str,
    wanted: &'static str,
    limits: &Limits,
) -> Result<Column> {
    let mut all: Option<Column> = None;
    for array in arrays {
        let own = one(archive, file, array, option, wanted, limits)?;
        all = Some(match all {
            None => own,
            Some(before) => before.followed_by(own).ok_or_else(|| Error::Parts {
                file: file.into(),
                first: arrays[0].clone(),
                second: array.clone(),
            })?,
        });
    }
    all.ok_or_else(|| Error::NoSamples { at: file.into() })
}

impl Column {
    /// Both, where they are of one kind.
    fn followed_by(self, next: Self) -> Option<Self> {
        let columns = self.columns.filter(|own| next.columns == Some(*own))?;
        let values = match (self.values, next.values) {
            (Stored::Numbers(a), Stored::Numbers(b)) => Stored::Numbers([a, b].concat()),
            (Stored::Texts(a), Stored::Texts(b)) => Stored::Texts([a, b].concat()),
            _ => return None,
        };
        Some(Self { values, columns: Some(columns) })
    }
}

fn one(
    archive: &mut Archive,
    file: &str,
    array: &str,
    option: &'static str,
    wanted: &'static str,
    limits: &Limits,
) -> Result<Column> {
    let cap = Cap::of_labels(limits);
    if let Some(texts) = archive.texts(file, array, cap)? {
        return Ok(Column { columns: columns(&texts.shape), values: Stored::Texts(texts.values) });
    }
    archive.with(file, array, option, |header, reader, at| {
        let header = &header.as_column();
        let Some(columns) = columns(&header.shape) else {
            return Ok(Column { values: Stored::Numbers(vec![]), columns: None });
        };
        let values = match npy_text::is_text(header) {
            true => Stored::Texts(npy_text::read(header, reader, at, cap)?),
            false => Stored::Numbers(header.read_i64(reader, at, cap, wanted)?),
        };
        Ok(Column { values, columns: Some(columns) })
    })
}

/// Values of a sample in an array `[N]` or `[N, k]`.
fn columns(shape: &[u64]) -> Option<usize> {
    match *shape {
        [_] => Some(1),
        [_, columns] if columns > 0 => Some(columns as usize),
        _ => None,
    }
}
