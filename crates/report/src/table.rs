//! A table: one definition for page, Markdown and CSV, so that no column can differ between them.

use std::borrow::Cow;

use taxel_base::{Align, Grid, markdown_text, thousands};

/// One field of a row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cell {
    /// What people read.
    pub shown: String,
    /// What a column is sorted by; by what is shown where it is none.
    pub order: Option<f64>,
    /// What programs read, one value for each CSV column.
    pub values: Vec<String>,
}

impl Cell {
    /// Returns a cell of text, the same for people and programs.
    pub fn text(text: impl Into<String>) -> Self {
        let text = text.into();
        Cell { shown: text.clone(), order: None, values: vec![text] }
    }

    /// Returns a cell that shows `shown` where it is so, and a dash elsewhere.
    pub fn yes(yes: bool, shown: &str) -> Self {
        let shown = if yes { shown.into() } else { "–".into() };
        Cell { shown, order: Some(f64::from(u8::from(yes))), values: vec![yes.to_string()] }
    }

    /// Returns a cell of a whole number.
    pub fn count(count: u64) -> Self {
        Cell::number(Some(count as f64), |_| thousands(count))
    }

    /// A number; `–` and an empty field where there is none.
    pub fn number(value: Option<f64>, show: impl Fn(f64) -> String) -> Self {
        let value = value.filter(|v| v.is_finite());
        Cell {
            shown: value.map_or("–".into(), show),
            order: value,
            values: vec![value.map_or(String::new(), |v| v.to_string())],
        }
    }

    /// More behind the number: `shown` is what people read after it, `more` what programs do.
    pub fn and(mut self, shown: String, more: &[Option<f64>]) -> Self {
        self.shown += &shown;
        self.values.extend(more.iter().map(|v| v.map_or(String::new(), |v| v.to_string())));
        self
    }
}

/// A column before it has rows.
pub struct Column<'a, R> {
    head: String,
    csv: Vec<String>,
    right: bool,
    in_files: bool,
    cell: Box<dyn Fn(&R) -> Cell + 'a>,
}

impl<'a, R> Column<'a, R> {
    /// A column of text; `csv` names its field.
    pub fn text(head: &str, csv: &str, cell: impl Fn(&R) -> Cell + 'a) -> Self {
        Column {
            head: head.into(),
            csv: vec![csv.into()],
            right: false,
            in_files: false,
            cell: Box::new(cell),
        }
    }

    /// A column of numbers; `csv` names their fields, with their units.
    pub fn number(head: &str, csv: &[&str], cell: impl Fn(&R) -> Cell + 'a) -> Self {
        let csv = csv.iter().map(|name| (*name).into()).collect();
        Column { head: head.into(), csv, right: true, in_files: false, cell: Box::new(cell) }
    }

    /// Left out of the page, where the same is said elsewhere.
    pub fn in_files(self) -> Self {
        Column { in_files: true, ..self }
    }
}

/// Head of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// Its text.
    pub shown: String,
    /// Names of its CSV columns, with their units.
    pub csv: Vec<String>,
    /// Whether it holds numbers.
    pub right: bool,
    /// Whether it is in the files alone.
    pub in_files: bool,
}

/// A table with all its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of its files.
    pub name: Cow<'static, str>,
    /// What it shows, on what.
    pub caption: String,
    /// One for each column.
    pub heads: Vec<Head>,
    /// One cell for each column.
    pub rows: Vec<Vec<Cell>>,
    /// Rows that a reader should see first, by position.
    pub marked: Vec<usize>,
}

impl Table {
    /// Makes one row of each of `rows`.
    pub fn new<R>(
        name: impl Into<Cow<'static, str>>,
        caption: String,
        columns: Vec<Column<R>>,
        rows: &[R],
    ) -> Self {
        let name = name.into();
        let cells = |row: &R| columns.iter().map(|column| (column.cell)(row)).collect();
        let rows = rows.iter().map(cells).collect();
        let head = |c: Column<R>| Head { shown: c.head, csv: c.csv, right: c.right, in_files: c.in_files };
        let heads = columns.into_iter().map(head).collect();
        Table { name, caption, heads, rows, marked: vec![] }
    }

    /// What people read.
    pub fn shown(&self) -> Grid {
        let align = |head: &Head| if head.right { Align::Right } else { Align::Left };
        let heads = self.heads.iter();
        let mut grid = heads.fold(Grid::new(), |grid, head| grid.column(&head.shown, align(head)));
        self.rows.iter().for_each(|row| grid.row(row.iter().map(|cell| &cell.shown)));
        grid
    }

    /// The table in Markdown, with its caption above.
    pub fn markdown(&self) -> String {
        format!("{}\n\n{}", markdown_text(&self.caption), self.shown().markdown())
    }

    /// What programs read, in full precision: units in the names of the columns, empty fields for what is not
    /// known.
    pub fn csv(&self) -> String {
        let names = self.heads.iter().flat_map(|head| &head.csv);
        let mut grid = names.fold(Grid::new(), |grid, name| grid.left(name));
        self.rows.iter().for_each(|row| grid.row(row.iter().flat_map(|cell| &cell.values)));
        grid.csv()
    }
}
