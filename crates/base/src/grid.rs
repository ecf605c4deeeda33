//! A table of texts, printed for terminals, as Markdown and as CSV.

use std::fmt;

use crate::printable::spreadsheet_text;

/// The side of a column on which its texts stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// Rows of texts below the heads of their columns.
///
/// [`fmt::Display`] prints aligned columns, two spaces apart.
///
/// ```
/// use taxel_base::Grid;
///
/// let mut grid = Grid::new().left("network").right("accuracy %");
/// grid.row(["k-nn", "91.2"]);
/// assert_eq!(grid.to_string(), "network  accuracy %\nk-nn           91.2\n");
/// assert_eq!(grid.markdown(), "| network | accuracy % |\n| --- | ---: |\n| k-nn | 91.2 |\n");
/// assert_eq!(grid.csv(), "network,accuracy %\nk-nn,91.2\n");
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Grid {
    heads: Vec<(String, Align)>,
    rows: Vec<Vec<String>>,
    rule: bool,
}

impl Grid {
    /// Makes a table without columns and rows.
    pub fn new() -> Self {
        Grid::default()
    }

    /// Adds a column.
    pub fn column(mut self, head: impl Into<String>, align: Align) -> Self {
        self.heads.push((head.into(), align));
        self
    }

    /// Adds a column of words.
    pub fn left(self, head: impl Into<String>) -> Self {
        self.column(head, Align::Left)
    }

    /// Adds a column of numbers.
    pub fn right(self, head: impl Into<String>) -> Self {
        self.column(head, Align::Right)
    }

    /// Adds a line of dashes below the heads, for terminals only.
    pub fn ruled(self) -> Self {
        Grid { rule: true, ..self }
    }

    /// Adds a row, one text for each column.
    ///
    /// # Panics
    /// Another number of texts than columns.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        let cells: Vec<String> = cells.into_iter().map(Into::into).collect();
        assert_eq!(cells.len(), self.heads.len(), "a row has one text for each column");
        self.rows.push(cells);
    }

    /// Returns the heads of the columns.
    pub fn heads(&self) -> impl Iterator<Item = &str> {
        self.heads.iter().map(|(head, _)| head.as_str())
    }

    /// Returns the rows.
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// Writes the table in Markdown; characters that would end a cell or begin a tag are escaped.
    pub fn markdown(&self) -> String {
        let line = |cells: &mut dyn Iterator<Item = String>| {
            let cells: Vec<String> = cells.collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rule = |align| if align == Align::Right { "---:" } else { "---" };
        let mut text = line(&mut self.heads().map(markdown_text));
        text += &line(&mut self.heads.iter().map(|(_, align)| rule(*align).into()));
        for row in &self.rows {
            text += &line(&mut row.iter().map(|cell| markdown_text(cell)));
        }
        text
    }

    /// Writes the table as comma-separated values with a line of heads (RFC 4180, but with `\n`). Cells that a spreadsheet
    /// would run are texts ([`spreadsheet_text`]).
    pub fn csv(&self) -> String {
        let line = |cells: &mut dyn Iterator<Item = &str>| {
            let cells: Vec<String> = cells.map(csv_field).collect();
            // An empty line would be no row.
            if cells == [""] { "\"\"\n".into() } else { cells.join(",") + "\n" }
        };
        let mut text = line(&mut self.heads());
        for row in &self.rows {
            text += &line(&mut row.iter().map(String::as_str));
        }
        text
    }
}

impl fmt::Display for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let heads: Vec<String> = self.heads().map(String::from).collect();
        let width = |column: usize| {
            let cells = self.rows.iter().chain([&heads]).map(|row| row[column].chars().count());
            cells.max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..heads.len()).map(width).collect();
        let dashes: Vec<String> = widths.iter().map(|width| "-".repeat(*width)).collect();
        let rule = self.rule.then_some(&dashes);
        for row in std::iter::once(&heads).chain(rule).chain(&self.rows) {
            let cells = row.iter().zip(&widths).zip(&self.heads);
            let cells = cells.map(|((cell, &width), (_, align))| match align {
                Align::Left => format!("{cell:<width$}"),
                Align::Right => format!("{cell:>width$}"),
            });
            writeln!(f, "{}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
        }
        Ok(())
    }
}

/// Escapes a text for Markdown, on one line and inside a cell.
pub fn markdown_text(text: &str) -> String {
    let line = text.replace('\\', "\\\\").replace('|', "\\|").replace(['\n', '\r'], " ");
    line.replace('<', "&lt;")
}

fn csv_field(text: &str) -> String {
    let text = spreadsheet_text(text);
    if text.contains(['"', ',', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text.into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_by_characters_and_not_by_bytes() {
        let mut grid = Grid::new().left("name").right("±").left("why").ruled();
        grid.row(["a", "1 ± 2", "é"]);
        grid.row(["bcdef", "3", ""]);
        assert_eq!(grid.to_string(), "name       ±  why\n-----  -----  ---\na      1 ± 2  é\nbcdef      3\n");
        assert_eq!(Grid::new().left("alone").to_string(), "alone\n");
    }

    #[test]
    fn texts_cannot_leave_their_cells() {
        let mut grid = Grid::new().left("a|b").left("c,d");
        grid.row(["x\ny \\ <b>", "say \"no\", twice"]);
        assert_eq!(
            grid.markdown(),
            "| a\\|b | c,d |\n| --- | --- |\n| x y \\\\ &lt;b> | say \"no\", twice |\n"
        );
        assert_eq!(grid.csv(), "a|b,\"c,d\"\n\"x\ny \\ <b>\",\"say \"\"no\"\", twice\"\n");
        let mut one = Grid::new().left("one");
        one.row([""]);
        assert_eq!(one.csv(), "one\n\"\"\n");
        let mut formulas = Grid::new().left("+a").left("b");
        formulas.row(["=HYPERLINK(\"x\")", "-1.5"]);
        assert_eq!(formulas.csv(), "'+a,b\n\"'=HYPERLINK(\"\"x\"\")\",-1.5\n");
    }

    #[test]
    #[should_panic(expected = "one text for each column")]
    fn a_row_of_another_length_is_a_mistake() {
        Grid::new().left("one").row(["1", "2"]);
    }
}
