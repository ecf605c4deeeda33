//! Counts cells that loggers fill in where they have no value: empty ones, `NaN`, `-`, `OL`.

use crate::error::plural;
use crate::formats::table::number_form::is_filled_in;
use std::collections::BTreeMap;

/// Texts that a message lists.
const LISTED: usize = 4;

/// The filled-in cells of a column, by their text.
#[derive(Debug, Default)]
pub(crate) struct FilledIn(BTreeMap<String, usize>);

impl FilledIn {
    /// Counts a cell, if it is filled in.
    pub fn add(&mut self, cell: &str) {
        if is_filled_in(cell) {
            *self.0.entry(cell.to_string()).or_default() += 1;
        }
    }

    /// Returns the number of filled-in cells.
    pub fn total(&self) -> usize {
        self.0.values().sum()
    }

    /// Lists the texts, each with its number: `3 × "OL", 2 empty`.
    pub fn listed(&self) -> String {
        let one = |(text, count): (&String, &usize)| match text.as_str() {
            "" => format!("{count} empty"),
            text => format!("{count} × {text:?}"),
        };
        let mut all: Vec<(&String, &usize)> = self.0.iter().collect();
        all.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let more = all.len().saturating_sub(LISTED);
        let listed = all.into_iter().take(LISTED).map(one).collect::<Vec<_>>().join(", ");
        if more > 0 { format!("{listed} and {more} other texts") } else { listed }
    }

    /// Ends the message about the first filled-in cell of a column: counts all of them, where there are several.
    pub fn said(&self) -> String {
        match self.total() {
            0 | 1 => String::new(),
            total => format!("; {} of this column are filled in: {}", plural(total, "cell"), self.listed()),
        }
    }
}

/// Counts cells that say NaN and are read as numbers.
#[derive(Debug, Default)]
pub(crate) struct NoNumbers {
    count: usize,
    /// Place of the first.
    first: Option<String>,
}

impl NoNumbers {
    /// Takes a number, and its place for messages.
    pub fn add(&mut self, number: f32, place: impl FnOnce() -> String) {
        if number.is_nan() {
            self.count += 1;
            self.first.get_or_insert_with(place);
        }
    }

    /// Says how many there are, and what becomes of them.
    pub fn said(&self) -> Option<String> {
        let first = self.first.as_ref()?;
        Some(format!(
            "{} NaN, the first in {first}: time steps at the end of a recording that hold nothing else are left out as padding, all \
             others are refused; fill them in or leave their rows out",
            if self.count == 1 { "1 cell is".into() } else { format!("{} cells are", self.count) }
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_counted_by_their_text() {
        let mut filled = FilledIn::default();
        for cell in ["1.5", "OL", "", "OL", "cup", "-", "OL"] {
            filled.add(cell);
        }
        assert_eq!(filled.total(), 5);
        assert_eq!(filled.said(), "; 5 cells of this column are filled in: 3 × \"OL\", 1 empty, 1 × \"-\"");
        assert_eq!(FilledIn::default().said(), "");
    }
}
