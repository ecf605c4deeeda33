//! The parts that decisions rest on, one by one.

use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::{Importance, Primary};

/// Returns a table with a row for each sensor and each part of the window, those first that cost most.
pub(super) fn parts(primary: &Primary, found: &Importance) -> Table {
    let of = |kind: &'static str, names: &[String], losses: &[f64]| {
        names
            .iter()
            .cloned()
            .zip(losses.iter().copied())
            .map(|(name, loss)| (kind, name, loss))
            .collect::<Vec<_>>()
    };
    let mut rows = of("sensor", &found.rows, &found.by_row);
    rows.extend(of("window", &found.columns, &found.by_column));
    rows.sort_by(|a, b| b.2.total_cmp(&a.2));
    type Row = (&'static str, String, f64);
    let unit = if primary.is_percent() { "probability_points".into() } else { primary.column("loss") };
    let head = if primary.is_percent() { "probability lost, points".into() } else { primary.head_of("lost") };
    let show = primary.show_signed();
    let columns = vec![
        Column::text("kind", "kind", |row: &Row| Cell::text(row.0)),
        Column::text("without", "without", |row: &Row| Cell::text(row.1.clone())),
        Column::number(&head, &[&unit], move |row: &Row| Cell::number(Some(row.2), show)),
    ];
    let caption = format!(
        "What the decisions of {} rest on: {} test samples with one part replaced by its mean over the training samples",
        found.network, found.samples
    );
    Table::new(table::IMPORTANCE, caption, columns, &rows)
}
