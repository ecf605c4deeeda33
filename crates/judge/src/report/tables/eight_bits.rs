//! Networks in eight bits beside the same in floats.

use taxel_report::numbers::digits;
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::{EightBits, Primary};

/// Returns a value before and after, such as in floats and in eight bits: `91.2 → 90.8`.
pub(super) fn both(values: Option<[f64; 2]>, show: fn(f64) -> String) -> Cell {
    let shown = values.map_or(String::new(), |[_, after]| format!(" → {}", show(after)));
    Cell::number(values.map(|[before, _]| before), show).and(shown, &[values.map(|[_, after]| after)])
}

pub(super) fn eight_bits(primary: &Primary, rows: &[EightBits]) -> Table {
    let (longer, show) = (primary.show_longer(), primary.show());
    // Of values nothing is right or wrong: one of the two comes nearer, and McNemar's test is the sign test.
    let (only, p, p_column) = if primary.is_percent() {
        ("right in floats only, in eight bits only", "McNemar's p", "mcnemar_p")
    } else {
        ("nearer in floats, in eight bits", "p of the sign test", "sign_test_p")
    };
    let fields = if primary.is_percent() {
        ["only_floats_right", "only_int8_right"]
    } else {
        ["floats_nearer", "int8_nearer"]
    };
    let columns = vec![
        Column::text("network", "network", |row: &EightBits| Cell::text(&row.network)),
        Column::number(
            &primary.head(),
            &[&primary.column("floats"), &primary.column("int8")],
            move |row: &EightBits| both(Some(row.scores), longer),
        ),
        Column::number("answers that differ", &["answers_differ", "samples"], |row: &EightBits| {
            let of = row.changed.samples;
            Cell::count(row.changed.differ).and(format!(" of {of}"), &[Some(of as f64)])
        }),
        Column::number(only, &fields, |row: &EightBits| {
            let [floats, bytes] = row.changed.only;
            Cell::count(floats).and(format!(", {bytes}"), &[Some(bytes as f64)])
        }),
        Column::value(p, p_column, digits, |row: &EightBits| Some(row.p)),
        Column::number(
            &primary.head_of_loss("lost to faults"),
            &[&primary.column_of_loss("mean_loss_floats"), &primary.column_of_loss("mean_loss_int8")],
            move |row: &EightBits| both(row.loss, show),
        ),
        Column::number("latency ms", &["latency_floats_ms", "latency_int8_ms"], |row: &EightBits| {
            both(row.latency, digits)
        }),
        Column::number("kB", &["floats_kb", "int8_kb"], |row: &EightBits| {
            both(Some(row.bytes.map(|bytes| bytes as f64 / 1e3)), digits)
        }),
    ];
    let title = primary.title();
    let test = if primary.is_percent() { "exact McNemar test" } else { "exact sign test" };
    let lost = if primary.is_percent() {
        format!("{title} lost to faults in percentage points")
    } else {
        format!("what faults add to it in {}", primary.unit())
    };
    let caption = format!(
        "In floats → in eight bits, each fold calibrated on its own training samples: {title}, single test samples of \
         the first repetition with the {test}, {lost} (mean over faults and severities), median time of an answer, and \
         size"
    );
    Table::new(table::EIGHT_BITS, caption, columns, rows)
}
