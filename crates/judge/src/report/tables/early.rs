//! Scores on the starts of samples.

use taxel_report::numbers::tenth;
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::report::words::early_basis;
use crate::values::{Early, EarlyDecisions, EarlyNetwork, Primary};

/// Returns a table with a row per network and a column per share that is there.
pub(super) fn shares(primary: &Primary, early: &Early) -> Table {
    let show = primary.show();
    let mut columns = vec![Column::text("network", "network", |n: &EarlyNetwork| Cell::text(&n.network))];
    let shares = early.networks.first().map_or(&[][..], |first| &first.points);
    for (at, point) in shares.iter().enumerate() {
        let seen = point.seen;
        let (score, refused) = (primary.column(&format!("at_{seen}")), format!("refused_at_{seen}"));
        columns.push(Column::number(&format!("{seen} %"), &[&score, &refused], move |n: &EarlyNetwork| {
            let point = n.points.get(at);
            let refused = point.map(|point| point.refused as f64);
            Cell::number(point.map(|point| point.score), show).and(String::new(), &[refused])
        }));
    }
    let (head, basis) = (primary.head_of(&primary.heading()), early_basis(early));
    let caption = format!("{head} by the share of a sample that is there: {basis}");
    Table::new(table::EARLY, caption, columns, &early.networks)
}

/// Returns a table with a row per network and confidence.
pub(super) fn decisions(early: &Early) -> Table {
    type Row<'a> = (&'a str, EarlyDecisions);
    let of = |n: &'_ EarlyNetwork| n.decisions.clone();
    let rows: Vec<Row> =
        early.networks.iter().flat_map(|n| of(n).into_iter().map(|row| (n.network.as_str(), row))).collect();
    let percent = |value: f64| Cell::number(Some(value), tenth);
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::value("confidence", "confidence", |v| v.to_string(), |row: &Row| Some(row.1.confidence)),
        Column::number("accuracy %", &["accuracy_percent"], move |row: &Row| percent(row.1.score)),
        Column::number("seen %", &["seen_percent"], move |row: &Row| percent(row.1.seen)),
        Column::number("decided early %", &["early_percent"], move |row: &Row| percent(row.1.early)),
    ];
    let caption = format!(
        "Decisions as soon as the likeliest class is so probable, looked at in tenths: {}. With a calibrated model taxel stream --early waits \
         until so many were right in the run",
        early_basis(early)
    );
    Table::new(table::EARLY_DECISIONS, caption, columns, &rows)
}
