//! Reads labels of classes from arrays.

use crate::dataset::labels::by_name;
use crate::dataset::raw::Names;
use crate::formats::archive::Archive;
use crate::formats::stored::{Column, StoredValues, column};
use crate::options::Limits;
use crate::{Error, Result};

/// Labels row by row, the number of columns, and their names where the array says them.
pub(crate) struct StoredLabels {
    pub values: Vec<i64>,
    pub columns: usize,
    pub names: Option<Names>,
}

impl Default for StoredLabels {
    /// Returns no labels, in one column.
    fn default() -> Self {
        Self { values: vec![], columns: 1, names: None }
    }
}

pub(crate) fn read_labels(
    archive: &mut Archive,
    arrays: &[String],
    known: Option<&Names>,
    limits: &Limits,
    samples: usize,
) -> Result<StoredLabels> {
    let wanted = "labels are whole numbers from 0: save y as an integer array, or say task = \"values\" (--task values) if it is measured";
    let Column { values, columns } = column(archive, arrays, "y", wanted, limits)?;
    let columns = columns.ok_or_else(|| Error::Shape {
        at: archive.at(&arrays[0]),
        shape: archive.shape(&arrays[0]),
        wanted: "labels are [N], or [N, k] for k attributes",
    })?;
    let name = arrays.join(" with ");
    match values {
        StoredValues::Texts(texts) => named(texts, columns, &name, archive.file(), known),
        StoredValues::Numbers(values) if archive.counts_from_one() => {
            Ok(from_one(values, columns, samples, name))
        }
        StoredValues::Numbers(values) => Ok(StoredLabels { values, columns, names: None }),
    }
}

/// Turns texts into labels: positions among those that occur, or among the names of a file beside.
pub(crate) fn named(
    texts: Vec<String>,
    columns: usize,
    array: &str,
    file: &str,
    known: Option<&Names>,
) -> Result<StoredLabels> {
    let mut values = vec![0; texts.len()];
    let mut lists = vec![];
    for column in 0..columns {
        let texts: Vec<String> = texts.iter().skip(column).step_by(columns).cloned().collect();
        let places: Vec<i64> = match known.and_then(|known| Some((known, known.columns.get(column)?))) {
            None => {
                let (names, places) = by_name(texts);
                lists.push(names);
                places.into_iter().map(i64::from).collect()
            }
            Some((known, names)) => {
                let place = |(row, text): (usize, &String)| {
                    let place = names.iter().position(|name| name == text);
                    place.map(|place| place as i64).ok_or_else(|| {
                        let why = format!("does not name {text:?}, which {file}: {array}[{row}] is");
                        Error::labels_form(&known.file, why)
                    })
                };
                texts.iter().enumerate().map(place).collect::<Result<_>>()?
            }
        };
        values.iter_mut().skip(column).step_by(columns).zip(places).for_each(|(value, place)| *value = place);
    }
    let names = known.is_none().then(|| Names { file: array.into(), columns: lists, is_given: false });
    Ok(StoredLabels { values, columns, names })
}

/// Turns numbers that MATLAB counts from 1 into numbers from 0, with the old number as name.
fn from_one(mut y: Vec<i64>, columns: usize, samples: usize, array: String) -> StoredLabels {
    if y.iter().min() != Some(&1) {
        return StoredLabels { values: y, columns, names: None };
    }
    y.iter_mut().for_each(|label| *label -= 1);
    let names = |column: usize| match y.iter().skip(column).step_by(columns).max() {
        None => vec![],
        // More names than samples are never needed: larger numbers are refused as gaps.
        Some(last) => (0..=*last.min(&(samples as i64))).map(|label| (label + 1).to_string()).collect(),
    };
    let columns_of = (0..columns).map(names).collect();
    let names = Names { file: array, columns: columns_of, is_given: false };
    StoredLabels { values: y, columns, names: Some(names) }
}
