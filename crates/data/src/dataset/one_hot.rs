//! Labels with several columns: one-hot, or attributes that were asked for.

use crate::dataset::raw::{Names, Raw};
use crate::error::Error;
use crate::options::ReadOptions;

/// What the columns of labels are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Columns {
    /// One label per sample.
    One,
    /// They were one per class; the labels are class numbers now.
    OneHot,
    /// One per attribute, as somebody says.
    Attributes,
    /// Nobody says, and they are not one-hot.
    Unsaid,
}

/// Says what the columns of `raw.y` are and turns one-hot rows into class numbers. Whoever speaks of attributes,
/// in the options or by one list of names per column, has attributes.
pub(crate) fn settle(raw: &mut Raw, options: &ReadOptions) -> Columns {
    let columns = raw.columns;
    if columns == 1 {
        return Columns::One;
    }
    let lists = raw.names.as_ref().filter(|names| names.columns.len() > 1);
    if lists.is_some_and(|names| names.is_told)
        || options.attribute.is_some()
        || !options.attributes.is_empty()
    {
        return Columns::Attributes;
    }
    if lists.is_some() {
        // Texts, or numbers from 1: a column of zeros and ones has no names.
        return Columns::Unsaid;
    }
    let class = |row: &[i64]| {
        let one = row.iter().position(|value| *value == 1)?;
        (row.iter().filter(|value| **value != 0).count() == 1).then_some(one as i64)
    };
    let classes: Option<Vec<i64>> = raw.y.chunks_exact(columns).map(class).collect();
    let Some(classes) = classes.filter(|classes| !classes.is_empty()) else { return Columns::Unsaid };
    raw.y = classes;
    raw.columns = 1;
    if raw.names.is_none() {
        let numbers = (0..columns).map(|class| class.to_string()).collect();
        raw.names = Some(Names { file: raw.y_name.clone(), columns: vec![numbers], is_told: false });
    }
    Columns::OneHot
}

/// The error for columns of which nobody says what they are.
pub(crate) fn unsaid(raw: &Raw) -> Error {
    let (file, y) = (raw.file.clone(), raw.y_name.clone());
    Error::Columns { file, y, columns: raw.columns, last: raw.columns - 1 }
}
