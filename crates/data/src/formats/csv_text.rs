//! Reads text tables as loggers and spreadsheets write them: with a line `sep=;`, lines that are no rows, and separators at the end of
//! lines.

use crate::formats::odd_lines::without_odd_lines;
use crate::formats::table::separators::Separators;
use crate::formats::text::read_text;
use crate::options::Limits;
use crate::{Error, Result};
use std::path::Path;

/// A text table that is ready for a reader of CSV. Its lines are those of the file.
pub(crate) struct CsvText {
    pub text: String,
    /// The separator that the file says in its first line (`sep=;`).
    pub said: Option<u8>,
    /// The lines that are no rows, for people.
    pub left_out: Option<String>,
}

impl CsvText {
    /// Reads a file.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        Self::read_as(path, limits, true)
    }

    /// Reads a file that lists something, of which no row is a message.
    pub fn read_list(path: &Path, limits: &Limits) -> Result<Self> {
        Self::read_as(path, limits, false)
    }

    fn read_as(path: &Path, limits: &Limits, of_readings: bool) -> Result<Self> {
        let text = read_text(path, limits)?;
        let table = Self::of(text, of_readings).map_err(|why| Error::file(path, why))?;
        let left_out = table.left_out.map(|words| format!("{}: {words}", path.display()));
        Ok(Self { left_out, ..table })
    }

    /// Takes a text, or says why it is no table and how to fix it.
    fn of(text: String, of_readings: bool) -> Result<Self, String> {
        let (said, text) = match said(&text) {
            // Its line stays, empty: messages count lines.
            Some((separator, end)) => (Some(separator), text[end..].to_string()),
            None => (None, text),
        };
        let (text, left_out) = match without_odd_lines(&text, said, of_readings) {
            Some(without) => (without.text, Some(without.said)),
            None => (text, None),
        };
        let mut table = Self { text, said, left_out };
        if let Some((line, cell)) = table.labelled() {
            return Err(format!(
                "line {line} holds cells of a label and a value, such as {cell:?}; write the labels once, as a first line \
                 of names, and below it the values alone"
            ));
        }
        let separator = table.separator();
        if let Some(text) = without_ends(&table.text, char::from(separator)) {
            table.text = text;
        }
        Ok(table)
    }

    /// Returns the separator of its columns.
    pub fn separator(&self) -> u8 {
        Separators::column_of(&self.text, self.said)
    }

    /// Returns line and first cell of a table whose cells are `label:value`, as serial plotters take them.
    fn labelled(&self) -> Option<(usize, &str)> {
        let (at, line) = self.text.lines().enumerate().find(|(_, line)| !line.trim().is_empty())?;
        let cells = || line.split([',', ';', '\t', ' ']).map(str::trim).filter(|cell| !cell.is_empty());
        let is_labelled = |cell: &str| {
            cell.split_once(':').is_some_and(|(label, value)| {
                label.starts_with(|c: char| c.is_alphabetic() || c == '_') && value.parse::<f64>().is_ok()
            })
        };
        cells().all(is_labelled).then(|| cells().next().map(|cell| (at + 1, cell))).flatten()
    }
}

/// Returns the separator that the first line says, and where that line ends: `sep=;`, for Excel.
fn said(text: &str) -> Option<(u8, usize)> {
    let end = text.find(['\r', '\n']).unwrap_or(text.len());
    let line = text[..end].trim().trim_matches('"');
    let (key, separator) = line.split_at_checked(4)?;
    let separator = if separator.is_empty() && text[..end].ends_with('\t') { "\t" } else { separator };
    let one = <[u8; 1]>::try_from(separator.as_bytes()).ok().filter(|_| key.eq_ignore_ascii_case("sep="));
    one.filter(|[byte]| byte.is_ascii() && !byte.is_ascii_alphanumeric()).map(|[byte]| (byte, end))
}

/// Returns the text without a separator at the end of its lines, as loggers write it; none where there is none that can go.
///
/// It goes where all lines have it, or all but the first. If the first has none, the others must have one cell more.
fn without_ends(text: &str, separator: char) -> Option<String> {
    let is_blank = |line: &str| line.trim().is_empty();
    let ends = |line: &str| line.trim_end_matches(['\r', ' ']).ends_with(separator);
    // A cell in quotes may hold separators, and ends of lines.
    let count =
        |line: &str| line.split('"').step_by(2).flat_map(str::chars).filter(|c| *c == separator).count();
    let mut lines = text.lines().filter(|line| !is_blank(line));
    let first = lines.next()?;
    let is_in_quotes = |line: &str| line.matches('"').count() % 2 == 1;
    if is_in_quotes(first) || lines.clone().any(is_in_quotes) {
        return None;
    }
    let (of_first, rest_end) = (ends(first), lines.clone().all(ends));
    let second = lines.next();
    let has_more = |more: &str, less: &str| count(more) == count(less) + 1;
    let (cut_first, cut_rest) = match second {
        _ if of_first && rest_end => (true, true),
        Some(second) if !of_first && rest_end => (false, has_more(second, first)),
        Some(second) if of_first && !lines.chain([second]).any(ends) => (has_more(first, second), false),
        _ => (false, false),
    };
    if !cut_first && !cut_rest {
        return None;
    }
    let mut is_first = true;
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let is_cut = !is_blank(line) && if std::mem::take(&mut is_first) { cut_first } else { cut_rest };
        if is_blank(line) {
            is_first = out.trim().is_empty();
        }
        match line.rfind(separator).filter(|_| is_cut) {
            Some(at) => {
                out.push_str(&line[..at]);
                out.push_str(&line[at + separator.len_utf8()..]);
            }
            None => out.push_str(line),
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn read(text: &str) -> (String, u8) {
        let table = CsvText::of(text.into(), true).unwrap();
        (table.text.clone(), table.separator())
    }

    #[test]
    fn a_first_line_may_say_the_separator() {
        assert_eq!(read("sep=;\r\na;b,c\n"), ("\r\na;b,c\n".into(), b';'));
        assert_eq!(read("\"SEP=,\"\na;b,c;d\n"), ("\na;b,c;d\n".into(), b','));
        assert_eq!(read("sep=\t\na\tb,,\n").1, b'\t');
        assert_eq!(read("sep=a\n1,2\n"), ("sep=a\n1,2\n".into(), b','));
        assert_eq!(read("sep,b\n1,2\n"), ("sep,b\n1,2\n".into(), b','));
    }

    #[test]
    fn separators_at_the_end_of_lines_are_no_cells() {
        for (text, want) in [
            ("a,b,\r\n1,2,\r\n\r\n3,4,\r\n", "a,b\r\n1,2\r\n\r\n3,4\r\n"),
            ("a,b\n1,2,\n3,4,", "a,b\n1,2\n3,4"),
            ("a,b,\n1,2\n3,4", "a,b\n1,2\n3,4"),
            ("\n1;2;\n3;4;\n", "\n1;2\n3;4\n"),
            // Missing values stay, and are refused.
            ("a,b\n1,\n3,\n", "a,b\n1,\n3,\n"),
            ("a,b,\n1,2,\n3,4\n", "a,b,\n1,2,\n3,4\n"),
            ("a,b,\n1,2,3\n", "a,b,\n1,2,3\n"),
            ("\"a,\",b\n1,2\n", "\"a,\",b\n1,2\n"),
            ("a,\"b\n,\"\n1,2,\n", "a,\"b\n,\"\n1,2,\n"),
        ] {
            assert_eq!(read(text).0, want, "{text:?}");
        }
    }

    #[test]
    fn cells_of_label_and_value_are_refused_with_a_way_out() {
        for text in ["t:12,x:0.5\nt:13,x:0.6\n", "\nt:12\tx:0.5\n", "force:1e3\n"] {
            let message = CsvText::of(text.into(), true).err().unwrap();
            assert!(
                message.contains("a label and a value") && message.contains("first line of names"),
                "{message}"
            );
        }
        for text in ["12:30,1\n", "a:b,c\n", "t:12,x\n"] {
            assert!(CsvText::of(text.into(), true).is_ok(), "{text}");
        }
    }
}
