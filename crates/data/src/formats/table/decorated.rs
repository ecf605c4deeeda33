//! Warns of numbers that are not read as numbers for what stands beside them (`1.5 N`, `1,234.5`, `50%`, `$3`): in a column that is
//! passed over as text, and in labels, where they become names of classes.
//!
//! A column in which all cells are such is refused before. Here some are, beside words such as `weak`.

use crate::Result;
use crate::error::plural;
use crate::formats::table::filled_in::FilledIn;
use crate::formats::table::number_form::{NumberForm, is_filled_in};
use crate::formats::table::recording::TableRecording;
use crate::formats::table::text_columns::{TableRow, TableText};

/// One in so many cells of a column of text has to be a number for a warning.
const SHARE: usize = 2;
/// Letters of a cell that a message shows.
const SHOWN: usize = 40;
/// Labels that say that there is none, and are no names of classes. `none` may be a class: no contact.
const NO_NAMES: [&str; 6] = ["-", "--", "?", "nan", "null", "ol"];

/// Watches the cells of one column that holds no plain number.
#[derive(Debug, Default)]
pub(crate) struct DecoratedCells {
    /// Cells that are not filled in.
    cells: usize,
    decorated: usize,
    /// The first that is decorated: the cell, its place and its form.
    first: Option<(String, String, NumberForm)>,
    /// The first that is no number at all: the cell and its place.
    other: Option<(String, String)>,
}

impl DecoratedCells {
    /// Takes a cell, and its place for messages.
    pub fn add(&mut self, cell: &str, place: impl FnOnce() -> String) {
        if is_filled_in(cell) {
            return;
        }
        self.cells += 1;
        let shown = || cell.chars().take(SHOWN).collect();
        match NumberForm::of(cell) {
            Some(form) => {
                self.decorated += 1;
                self.first.get_or_insert_with(|| (shown(), place(), form));
            }
            None if cell.parse::<f64>().is_ok() => {}
            None => _ = self.other.get_or_insert_with(|| (shown(), place())),
        }
    }

    /// Warns of a column that is passed over though many of its cells are numbers; `kind` and `name` are those of the column.
    pub fn of_text(&self, kind: &str, name: &str) -> Option<String> {
        let (cell, place, form) = self.first.as_ref().filter(|_| self.decorated * SHARE >= self.cells)?;
        let (others, hint) = (self.other.as_ref(), form.hint());
        let other = others
            .map_or(String::new(), |(cell, place)| format!("correct others such as {cell:?} ({place}), or "));
        Some(format!(
            "{kind} {name:?} is passed over as text, and {} of its {} are numbers: {cell:?} ({place}) {hint}; {other}name it with \
             table.ignore if it is no channel",
            self.decorated,
            plural(self.cells, "cell"),
        ))
    }

    /// Warns of labels that are numbers and become names of classes; `name` is that of their column.
    fn of_labels(&self, name: &str) -> Option<String> {
        let (cell, place, form) = self.first.as_ref().filter(|_| self.other.is_none())?;
        Some(format!(
            "{} in column {name:?} are numbers that are taken as names of classes: {cell:?} ({place}) {}, if they are measured \
             values",
            plural(self.decorated, "label"),
            form.hint()
        ))
    }
}

/// Returns the doubts about the columns `texts` of a table, which are passed over.
pub(crate) fn doubts_of_texts(table: &TableText, texts: &[usize]) -> Result<Vec<String>> {
    let mut columns: Vec<DecoratedCells> = texts.iter().map(|_| DecoratedCells::default()).collect();
    if !texts.is_empty() {
        table.rows(|row: TableRow| {
            let places = texts.iter().zip(&mut columns);
            places.for_each(|(at, cells)| cells.add(row.text(*at), || row.place()));
            Ok(true)
        })?;
    }
    let said =
        texts.iter().zip(&columns).filter_map(|(at, cells)| cells.of_text("column", &table.header[*at]));
    Ok(said.map(|words| format!("{}: {words}", table.file)).collect())
}

/// Returns the doubts about the labels of recordings that are names of classes; `names` are those of their columns.
pub(crate) fn doubts_of_labels(file: &str, names: &[String], all: &[TableRecording]) -> Vec<String> {
    let mut said = vec![];
    for (column, name) in names.iter().enumerate() {
        let (mut decorated, mut filled) = (DecoratedCells::default(), FilledIn::default());
        for recording in all {
            let Some(label) = recording.labels.get(column) else { continue };
            decorated.add(label, || format!("line {}", recording.line));
            if NO_NAMES.contains(&label.to_ascii_lowercase().as_str()) {
                filled.add(label);
            }
        }
        said.extend(decorated.of_labels(name));
        if filled.total() > 0 {
            said.push(format!(
                "{} in column {name:?} say that there is none, and are taken as the name of a class: {}; leave these rows out, or \
                 write their label",
                plural(filled.total(), "label"),
                filled.listed()
            ));
        }
    }
    said.into_iter().map(|words| format!("{file}: {words}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watched(cells: &[&str]) -> DecoratedCells {
        let mut watched = DecoratedCells::default();
        for (at, cell) in cells.iter().enumerate() {
            watched.add(cell, || format!("line {}", at + 2));
        }
        watched
    }

    #[test]
    fn a_text_of_which_half_are_numbers_is_doubtful() {
        let said = watched(&["weak", "1.5 N", "2.5 N", "OL"]).of_text("column", "force").unwrap_or_default();
        assert!(
            said.contains("2 of its 3 cells are numbers: \"1.5 N\" (line 3) is a number with a unit"),
            "{said}"
        );
        assert!(said.contains("\"weak\" (line 2)") && said.contains("table.ignore"), "{said}");
        for cells in [&["weak", "strong", "1.5 N"][..], &["cup", "can"], &["", "OL"], &[]] {
            assert_eq!(watched(cells).of_text("column", "force"), None, "{cells:?}");
        }
    }

    #[test]
    fn labels_are_doubtful_where_all_are_numbers() {
        let said = watched(&["1.5 N", "2", "2.5 N"]).of_labels("force").unwrap_or_default();
        assert!(said.contains("2 labels in column \"force\"") && said.contains("measured values"), "{said}");
        assert_eq!(watched(&["1.5 N", "cup"]).of_labels("force"), None);
        assert_eq!(watched(&["1", "2"]).of_labels("force"), None);
    }
}
