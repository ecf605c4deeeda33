//! Networks in eight bits beside the same in floats.

use taxel_report::numbers::{digits, tenth};
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::EightBits;

/// A value in floats and in eight bits.
fn both(values: Option<[f64; 2]>, show: fn(f64) -> String) -> Cell {
    let shown = values.map_or(String::new(), |[_, after]| format!(" → {}", show(after)));
    Cell::number(values.map(|[before, _]| before), show).and(shown, &[values.map(|[_, after]| after)])
}

pub(super) fn eight_bits(rows: &[EightBits]) -> Table {
    let hundredth = |value: f64| format!("{value:.2}");
    let columns = vec![
        Column::text("network", "network", |own: &EightBits| Cell::text(&own.network)),
        Column::number(
            "accuracy %",
            &["accuracy_floats_percent", "accuracy_int8_percent"],
            move |own: &EightBits| both(Some(own.accuracy), hundredth),
        ),
        Column::number("answers that differ", &["answers_differ", "samples"], |own: &EightBits| {
            let of = own.changed.samples;
            Cell::count(own.changed.differ).and(format!(" of {of}"), &[Some(of as f64)])
        }),
        Column::number(
            "right in floats only, in eight bits only",
            &["only_floats_right", "only_int8_right"],
            |own: &EightBits| {
                let [floats, bytes] = own.changed.only;
                Cell::count(floats).and(format!(", {bytes}"), &[Some(bytes as f64)])
            },
        ),
        Column::number("McNemar's p", &["mcnemar_p"], |own: &EightBits| Cell::number(Some(own.p), digits)),
        Column::number(
            "lost to faults, pp",
            &["mean_loss_floats_points", "mean_loss_int8_points"],
            |own: &EightBits| both(own.loss, tenth),
        ),
        Column::number("latency ms", &["latency_floats_ms", "latency_int8_ms"], |own: &EightBits| {
            both(own.latency, digits)
        }),
        Column::number("kB", &["floats_kb", "int8_kb"], |own: &EightBits| {
            both(Some(own.bytes.map(|bytes| bytes as f64 / 1e3)), digits)
        }),
    ];
    let caption = "In floats → in eight bits, each fold calibrated on its own training samples: accuracy, single test \
                   samples of the first repetition with the exact McNemar test, accuracy lost to faults in percentage \
                   points (mean over faults and severities), median time of an answer, and size";
    Table::new(table::EIGHT_BITS, caption.into(), columns, rows)
}
