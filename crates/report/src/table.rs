//! A table: one definition for page, Markdown and CSV, so that no column can differ between them.

use std::borrow::Cow;

use taxel_base::{Align, Grid, markdown_text, thousands};

/// One field of a row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cell {
    /// Text for people.
    pub shown: String,
    /// Value that a column is sorted by; without one it is sorted by `shown`.
    pub order: Option<f64>,
    /// Text for programs, one value for each CSV column.
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

    /// Returns a cell of a number; `–` and an empty field where there is none.
    pub fn number(value: Option<f64>, show: impl Fn(f64) -> String) -> Self {
        let value = value.filter(|v| v.is_finite());
        Cell {
            shown: value.map_or("–".into(), show),
            order: value,
            values: vec![value.map_or(String::new(), |v| v.to_string())],
        }
    }

    /// Adds an interval behind the number, worded by `shown`; nothing for people where there is none.
    pub fn interval(self, bounds: Option<[f64; 2]>, shown: impl Fn([f64; 2]) -> String) -> Self {
        self.and(bounds.map_or(String::new(), shown), &bounds.map_or([None, None], |ends| ends.map(Some)))
    }

    /// Adds more behind the number: `shown` for people, `more` for programs.
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
    /// Returns a column of text; `csv` names its field.
    pub fn text(head: &str, csv: &str, cell: impl Fn(&R) -> Cell + 'a) -> Self {
        Column {
            head: head.into(),
            csv: vec![csv.into()],
            right: false,
            in_files: false,
            cell: Box::new(cell),
        }
    }

    /// Returns a column of numbers; `csv` names their fields, with their units.
    pub fn number(head: &str, csv: &[&str], cell: impl Fn(&R) -> Cell + 'a) -> Self {
        let csv = csv.iter().map(|name| (*name).into()).collect();
        Column { head: head.into(), csv, right: true, in_files: false, cell: Box::new(cell) }
    }

    /// Returns a column of one number a row; `csv` names its field, with its unit.
    pub fn value(
        head: &str,
        csv: &str,
        show: impl Fn(f64) -> String + 'a,
        value: impl Fn(&R) -> Option<f64> + 'a,
    ) -> Self {
        Column::number(head, &[csv], move |row| Cell::number(value(row), &show))
    }

    /// Returns a column of whole numbers; `csv` names its field.
    pub fn count(head: &str, csv: &str, count: impl Fn(&R) -> u64 + 'a) -> Self {
        Column::number(head, &[csv], move |row| Cell::count(count(row)))
    }

    /// Leaves the column out of the page, where the same is said elsewhere.
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
    /// Heading: the quantity and the samples.
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

    /// Returns the cells for people.
    pub fn shown(&self) -> Grid {
        let align = |head: &Head| if head.right { Align::Right } else { Align::Left };
        let heads = self.heads.iter();
        let mut grid = heads.fold(Grid::new(), |grid, head| grid.column(&head.shown, align(head)));
        self.rows.iter().for_each(|row| grid.row(row.iter().map(|cell| &cell.shown)));
        grid
    }

    /// Returns the table in Markdown, with its caption above.
    pub fn markdown(&self) -> String {
        format!("{}\n\n{}", markdown_text(&self.caption), self.shown().markdown())
    }

    /// Returns the table for programs, in full precision: units in the names of the columns, empty fields for unknown
    /// values.
    pub fn csv(&self) -> String {
        let names = self.heads.iter().flat_map(|head| &head.csv);
        let mut grid = names.fold(Grid::new(), |grid, name| grid.left(name));
        self.rows.iter().for_each(|row| grid.row(row.iter().flat_map(|cell| &cell.values)));
        grid.csv()
    }
}
