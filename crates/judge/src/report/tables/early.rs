//! Accuracy on the starts of samples.

use taxel_report::numbers::tenth;
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::report::words::early_basis;
use crate::values::{Early, EarlyDecisions, EarlyNetwork};

/// One row per network, one column per share that is there.
pub(super) fn shares(early: &Early) -> Table {
    let mut columns = vec![Column::text("network", "network", |n: &EarlyNetwork| Cell::text(&n.network))];
    let shares = early.networks.first().map_or(&[][..], |first| &first.points);
    for (at, point) in shares.iter().enumerate() {
        let seen = point.seen;
        let (accuracy, refused) = (format!("accuracy_at_{seen}_percent"), format!("refused_at_{seen}"));
        columns.push(Column::number(
            &format!("{seen} %"),
            &[&accuracy, &refused],
            move |n: &EarlyNetwork| {
                let own = n.points.get(at);
                let refused = own.map(|own| own.refused as f64);
                Cell::number(own.map(|own| own.accuracy), tenth).and(String::new(), &[refused])
            },
        ));
    }
    let caption = format!("Accuracy % by the share of a sample that is there: {}", early_basis(early));
    Table::new(table::EARLY, caption, columns, &early.networks)
}

/// One row per network and confidence.
pub(super) fn decisions(early: &Early) -> Table {
    type Row<'a> = (&'a str, EarlyDecisions);
    let of = |n: &'_ EarlyNetwork| n.decisions.clone();
    let rows: Vec<Row> =
        early.networks.iter().flat_map(|n| of(n).into_iter().map(|own| (n.network.as_str(), own))).collect();
    let percent = |value: f64| Cell::number(Some(value), tenth);
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::number("confidence", &["confidence"], |row: &Row| {
            Cell::number(Some(row.1.confidence), |v| v.to_string())
        }),
        Column::number("accuracy %", &["accuracy_percent"], move |row: &Row| percent(row.1.accuracy)),
        Column::number("seen %", &["seen_percent"], move |row: &Row| percent(row.1.seen)),
        Column::number("decided early %", &["early_percent"], move |row: &Row| percent(row.1.early)),
    ];
    let caption = format!(
        "Decisions as soon as the likeliest class is so probable (taxel stream --early), looked at in tenths: {}",
        early_basis(early)
    );
    Table::new(table::EARLY_DECISIONS, caption, columns, &rows)
}
