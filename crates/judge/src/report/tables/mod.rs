//! Tables: one definition for page, Markdown and CSV, so that no column can differ between them.

mod costs;
mod evidence;
mod faults;
mod scores;

pub(super) use evidence::claims;
pub(super) use scores::networks;

use std::borrow::Cow;

use crate::choice::Choice;
use crate::claims::Claim;
use crate::error::{Error, Result};
use crate::judgement::Judgement;

/// One field of a row.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Cell {
    /// What people read.
    pub shown: String,
    /// What a column is sorted by; by what is shown where it is none.
    pub order: Option<f64>,
    /// What programs read, one value for each CSV column.
    pub values: Vec<String>,
}

impl Cell {
    pub(super) fn text(text: impl Into<String>) -> Self {
        let text = text.into();
        Cell { shown: text.clone(), order: None, values: vec![text] }
    }

    pub(super) fn yes(yes: bool, shown: &str) -> Self {
        let shown = if yes { shown.into() } else { "–".into() };
        Cell { shown, order: Some(f64::from(u8::from(yes))), values: vec![yes.to_string()] }
    }

    pub(super) fn count(count: u64) -> Self {
        Cell::number(Some(count as f64), |_| taxel_trainer::thousands(count))
    }

    /// A number; `–` and an empty field where there is none.
    pub(super) fn number(value: Option<f64>, show: impl Fn(f64) -> String) -> Self {
        let value = value.filter(|v| v.is_finite());
        Cell {
            shown: value.map_or("–".into(), show),
            order: value,
            values: vec![value.map_or(String::new(), |v| v.to_string())],
        }
    }

    /// More behind the number: `shown` is what people read after it, `more` what programs do.
    pub(super) fn and(mut self, shown: String, more: &[Option<f64>]) -> Self {
        self.shown += &shown;
        self.values.extend(more.iter().map(|v| v.map_or(String::new(), |v| v.to_string())));
        self
    }
}

/// A column before it has rows.
pub(super) struct Column<'a, R> {
    head: String,
    csv: Vec<String>,
    right: bool,
    in_files: bool,
    cell: Box<dyn Fn(&R) -> Cell + 'a>,
}

impl<'a, R> Column<'a, R> {
    /// A column of text; `csv` names its field.
    pub(super) fn text(head: &str, csv: &str, cell: impl Fn(&R) -> Cell + 'a) -> Self {
        Column {
            head: head.into(),
            csv: vec![csv.into()],
            right: false,
            in_files: false,
            cell: Box::new(cell),
        }
    }

    /// A column of numbers; `csv` names their fields, with their units.
    pub(super) fn number(head: &str, csv: &[&str], cell: impl Fn(&R) -> Cell + 'a) -> Self {
        let csv = csv.iter().map(|name| (*name).into()).collect();
        Column { head: head.into(), csv, right: true, in_files: false, cell: Box::new(cell) }
    }

    /// Left out of the page, where the same is said elsewhere.
    pub(super) fn in_files(self) -> Self {
        Column { in_files: true, ..self }
    }
}

/// Head of a column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Head {
    pub shown: String,
    pub csv: Vec<String>,
    /// Whether it holds numbers.
    pub right: bool,
    /// Whether it is in the files alone.
    pub in_files: bool,
}

/// A table with all its numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    /// Name of its files.
    pub name: Cow<'static, str>,
    /// What it shows, on what.
    pub caption: String,
    pub heads: Vec<Head>,
    pub rows: Vec<Vec<Cell>>,
    /// Rows that a reader should see first, by position.
    pub marked: Vec<usize>,
}

impl Table {
    pub(super) fn new<R>(
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

    pub(super) fn markdown(&self) -> String {
        let cell = |text: &str| text.replace('\\', "\\\\").replace('|', "\\|").replace(['\n', '\r'], " ");
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let escaped = |text: &str| cell(text).replace('<', "&lt;");
        let rule = self.heads.iter().map(|h| if h.right { "---:" } else { "---" }.into()).collect();
        let mut text = format!("{}\n\n", escaped(&self.caption));
        text += &line(self.heads.iter().map(|head| escaped(&head.shown)).collect());
        text += &line(rule);
        for row in &self.rows {
            text += &line(row.iter().map(|field| escaped(&field.shown)).collect());
        }
        text
    }

    /// Full precision, units in the names of the columns, empty fields for what is not known.
    ///
    /// # Errors
    /// Never for tables of a report; rows of unequal length.
    pub(super) fn csv(&self) -> Result<Vec<u8>> {
        let refuse = |e: String| Error::Write { path: format!("tables/{}.csv", self.name), reason: e };
        let mut writer = csv::Writer::from_writer(vec![]);
        let put = |writer: &mut csv::Writer<Vec<u8>>, fields: Vec<&String>| {
            writer.write_record(fields).map_err(|e| refuse(e.to_string()))
        };
        put(&mut writer, self.heads.iter().flat_map(|head| &head.csv).collect())?;
        for row in &self.rows {
            put(&mut writer, row.iter().flat_map(|field| &field.values).collect())?;
        }
        writer.into_inner().map_err(|e| refuse(e.to_string()))
    }
}

/// Every table of a report that has rows.
pub(super) fn tables(judgement: &Judgement, choice: Option<&Choice>, claims: &[Claim]) -> Vec<Table> {
    let mut all = vec![networks(judgement, choice)];
    all.extend(choice.map(evidence::choice));
    all.extend([
        evidence::claims(claims),
        scores::published(judgement),
        costs::speed(judgement),
        costs::size(judgement),
        scores::attributes(judgement),
        scores::folds(judgement),
        scores::classes(judgement),
        scores::confusion(judgement),
        scores::few_samples(judgement),
        costs::training(judgement),
        costs::weight_changes(judgement),
        evidence::examples(judgement),
    ]);
    if let Some(stress) = &judgement.stress {
        all.extend([
            faults::breaking_points(stress),
            faults::losses(stress),
            faults::curves(stress),
            faults::kinds(stress),
        ]);
    }
    all.retain(|table| !table.rows.is_empty());
    all
}
