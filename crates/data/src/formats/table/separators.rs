//! Finds what separates the columns of a text, and whether decimals are written with commas.

use crate::formats::table::number_form::{is_decimal_comma, is_decimal_point};
use crate::formats::text::csv_reader;
use std::borrow::Cow;

/// The separators of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Separators {
    /// Between columns.
    pub column: u8,
    /// Decimals have commas: some cells do, and none has a point. Never where commas separate columns.
    pub has_comma: bool,
}

impl Separators {
    /// Finds the separators of a text; `said` is the one that its first line states (`sep=;`).
    pub fn of(text: &str, said: Option<u8>) -> Self {
        let column = Self::column_of(text, said);
        Self { column, has_comma: column != b',' && has_decimal_commas(text, column) }
    }

    /// Finds what separates the columns: the stated separator, or the most frequent of the first line.
    pub fn column_of(text: &str, said: Option<u8>) -> u8 {
        if let Some(said) = said {
            return said;
        }
        let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        let is_number = |cell: &str| cell.parse::<f64>().is_ok() || is_decimal_comma(cell);
        let parts_numbers = |separator: &u8| {
            let separator = char::from(*separator);
            first.contains(separator) && first.split(separator).all(|cell| is_number(cell.trim()))
        };
        let count = |separator: &u8| first.bytes().filter(|byte| byte == separator).count();
        // A line of numbers with decimal commas has as many commas as columns.
        let found = [b'\t', b';'].into_iter().find(parts_numbers);
        // The last of several that are equally frequent: the comma.
        found.or([b'\t', b';', b','].into_iter().max_by_key(count)).unwrap_or(b',')
    }
}

/// Checks whether some cells are numbers with a decimal comma, and none with a point.
fn has_decimal_commas(text: &str, separator: u8) -> bool {
    let mut reader = csv_reader(text, separator, false);
    let mut record = csv::StringRecord::new();
    let mut has_comma = false;
    // What cannot be read is refused when rows are read.
    while let Ok(true) = reader.read_record(&mut record) {
        if record.iter().any(is_decimal_point) {
            return false;
        }
        has_comma |= record.iter().any(is_decimal_comma);
    }
    has_comma
}

/// Returns a cell with a decimal point, where decimals have commas.
pub(crate) fn plain(cell: &str, has_comma: bool) -> Cow<'_, str> {
    if has_comma && is_decimal_comma(cell) {
        return Cow::Owned(cell.replacen(',', ".", 1));
    }
    Cow::Borrowed(cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_are_decimals_where_other_separators_part_columns() {
        for (text, column, has_comma) in [
            ("a,b\n1,2\n", b',', false),
            ("a;b\n1,5;2\n", b';', true),
            ("1,5;2,5\n", b';', true),
            ("a\tb\n1,5\t2,25\n", b'\t', true),
            ("a;b\n1,5;2.5\n", b';', false),
            ("a;b\n1;2\n", b';', false),
            ("a\n\"1,5\"\n", b',', false),
        ] {
            assert_eq!(Separators::of(text, None), Separators { column, has_comma }, "{text:?}");
        }
        assert_eq!((plain("-1,5", true), plain("-1,5", false)), ("-1.5".into(), "-1,5".into()));
    }
}
