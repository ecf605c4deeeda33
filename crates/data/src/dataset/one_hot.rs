//! Labels with several columns: one-hot, or attributes that were asked for.

use crate::dataset::raw::{Names, Raw};
use crate::error::Error;
use crate::options::ReadOptions;

/// The meaning of the columns of labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LabelForm {
    /// One label per sample.
    One,
    /// One column per class; the labels are class numbers now.
    OneHot,
    /// One column per attribute, as options or a file of names say.
    Attributes,
    /// Several columns that are not one-hot, of which nothing is said.
    Unsaid,
}

/// Finds the form of the labels and turns one-hot rows into class numbers. LabelForm are attributes where the options say
/// so, or a file with one list of names per column.
pub(crate) fn settle(raw: &mut Raw, options: &ReadOptions) -> LabelForm {
    let columns = raw.columns;
    if columns == 1 || raw.values.is_some() {
        return LabelForm::One;
    }
    let lists = raw.names.as_ref().filter(|names| names.columns.len() > 1);
    if lists.is_some_and(|names| names.is_given)
        || options.attribute.is_some()
        || !options.attributes.is_empty()
    {
        return LabelForm::Attributes;
    }
    if lists.is_some() {
        // Texts, or numbers from 1: a column of zeros and ones has no names.
        return LabelForm::Unsaid;
    }
    let class = |row: &[i64]| class_of(row).map(|class| class as i64);
    let classes: Option<Vec<i64>> = raw.y.chunks_exact(columns).map(class).collect();
    let Some(classes) = classes.filter(|classes| !classes.is_empty()) else { return LabelForm::Unsaid };
    raw.y = classes;
    raw.columns = 1;
    if raw.names.is_none() {
        let numbers = (0..columns).map(|class| class.to_string()).collect();
        raw.names = Some(Names { file: raw.y_name.clone(), columns: vec![numbers], is_given: false });
    }
    LabelForm::OneHot
}

/// Returns the place of the single 1 of a row of zeros; none for other rows.
pub(crate) fn class_of<T: PartialEq + From<u8>>(row: &[T]) -> Option<usize> {
    let one = row.iter().position(|value| *value == T::from(1))?;
    (row.iter().filter(|value| **value != T::from(0)).count() == 1).then_some(one)
}

/// Refuses columns that are neither one-hot nor said to be attributes.
pub(crate) fn unsaid(raw: &Raw) -> Error {
    let (y, columns, last) = (&raw.y_name, raw.columns, raw.columns - 1);
    let could_be_steps = raw.x.sample_shape().len() > 1 && raw.x.sample_shape().last() == Some(&columns);
    let steps = if could_be_steps { ", and if they are labels of time steps, target = \"step\"" } else { "" };
    Error::file(
        &raw.file,
        format!(
            "{y} has {columns} columns that are not one-hot; choose one with attribute = N (0..{last}), or name them \
             all to learn several attributes: attributes = [\"...\", \"...\"]; if they are measured, say task = \
             \"values\"{steps}"
        ),
    )
}
