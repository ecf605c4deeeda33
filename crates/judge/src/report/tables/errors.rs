//! How far values lie from the true ones.

use taxel_report::numbers::tenth;
use taxel_report::table::{Cell, Column, Table};

use super::certainty::few_groups;
use crate::report::names::table;
use crate::values::{QuantityErrors, RowErrors};

/// A row of the table: a network and one of its quantities.
type Row = (String, QuantityErrors);

/// Returns a table with a row per network and quantity: errors in the unit and as a share of the range, intervals. Of samples in
/// `groups` it says how many of these intervals need.
pub(super) fn errors(rows: &[RowErrors], groups: Option<usize>) -> Table {
    let third = |value: f64| format!("{value:.3}");
    let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
    let rows: Vec<Row> = rows
        .iter()
        .flat_map(|row| row.quantities.iter().map(|of| (row.network.clone(), of.clone())))
        .collect();
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(&row.0)),
        Column::text("quantity", "quantity", |row: &Row| Cell::text(&row.1.name)),
        Column::text("unit", "unit", |row: &Row| Cell::text(row.1.unit.as_deref().unwrap_or("–"))),
        Column::value("MAE", "mae", third, |row: &Row| Some(row.1.mae)),
        Column::value("RMSE", "rmse", third, |row: &Row| Some(row.1.rmse)),
        Column::value("R²", "r2", third, |row: &Row| Some(row.1.r2)),
        Column::value("median error", "median_error", third, |row: &Row| Some(row.1.median)),
        Column::value("95 % of errors within", "p95_error", third, |row: &Row| Some(row.1.p95)),
        Column::value("MAE, % of range", "relative_mae_percent", tenth, |row: &Row| Some(row.1.relative_mae)),
        Column::value("MAE of the mean", "mae_of_mean", third, |row: &Row| Some(row.1.of_mean)),
        Column::value("90 % intervals cover %", "interval_90_covered_percent", tenth, move |row: &Row| {
            percent(row.1.interval.map(|interval| interval.covered))
        }),
        Column::value("worst group", "interval_90_worst_group_percent", tenth, move |row: &Row| {
            percent(row.1.interval.and_then(|interval| interval.worst_group))
        }),
        Column::value("mean width", "interval_90_width", third, |row: &Row| {
            row.1.interval.map(|interval| interval.width)
        }),
    ];
    let caption = "Errors of the test parts together, in the unit of each quantity. Intervals are fitted to the errors of the \
                   other parts; what they covered was seen, and is no promise for a new group";
    Table::new(table::ERRORS, format!("{caption}{}", few_groups(groups)), columns, &rows)
}
