//! Training under faults beside training on clean samples; faults that training never met.

use taxel_report::numbers::{digits, tenth};
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::{Change, Hardened, Unmet};

fn points(value: f64) -> Cell {
    Cell::number(Some(value), tenth)
}

/// A difference with its interval.
fn change(own: Change) -> Cell {
    let shown = own.interval.map_or(String::new(), |[low, high]| format!(" ({low:+.1} to {high:+.1})"));
    let bounds = own.interval.map_or([None, None], |bounds| bounds.map(Some));
    Cell::number(Some(own.mean), |v| format!("{v:+.1}")).and(shown, &bounds)
}

pub(super) fn hardening(rows: &[Hardened]) -> Table {
    let met = |h: &Hardened| match h.unmet.len() {
        0 => Cell::text("–"),
        all => Cell::text(format!("{} of {all}", h.helped())),
    };
    let columns = vec![
        Column::text("network", "network", |h: &Hardened| Cell::text(&h.clean)),
        Column::number("clean %, trained clean", &["accuracy_trained_clean_percent"], |h: &Hardened| {
            points(h.accuracy[0])
        }),
        Column::number("under faults", &["accuracy_hardened_percent"], |h: &Hardened| points(h.accuracy[1])),
        Column::number(
            "difference, pp",
            &["accuracy_change_points", "accuracy_change_low", "accuracy_change_high"],
            |h: &Hardened| change(h.accuracy_change),
        ),
        Column::number(
            "lost to faults, trained clean, pp",
            &["loss_trained_clean_points"],
            |h: &Hardened| points(h.loss[0]),
        ),
        Column::number("under faults, pp", &["loss_hardened_points"], |h: &Hardened| points(h.loss[1])),
        Column::number(
            "difference in loss, pp",
            &["loss_change_points", "loss_change_low", "loss_change_high"],
            |h: &Hardened| change(h.loss_change),
        ),
        Column::number("s a fold, trained clean", &["train_seconds_clean"], |h: &Hardened| {
            Cell::number(Some(h.train_seconds[0]), digits)
        }),
        Column::number("s a fold, under faults", &["train_seconds_hardened"], |h: &Hardened| {
            Cell::number(Some(h.train_seconds[1]), digits)
        }),
        Column::text("unknown faults that cost less", "unmet_helped", met),
    ];
    let caption = "Trained on clean samples and under faults: accuracy on unbroken samples, and what faults cost, \
                   percentage points, mean over faults and severities; differences over folds with their 95 % \
                   interval (corrected resampled t-test)";
    Table::new(table::HARDENING, caption.into(), columns, rows)
}

/// One row for each network and fault that one of its trainings was spared.
pub(super) fn unmet(rows: &[Hardened]) -> Table {
    let each: Vec<(&str, Unmet)> =
        rows.iter().flat_map(|h| h.unmet.iter().map(|own| (h.clean.as_str(), *own))).collect();
    let columns = vec![
        Column::text("network", "network", |row: &(&str, Unmet)| Cell::text(row.0)),
        Column::text("fault", "fault", |row: &(&str, Unmet)| Cell::text(row.1.fault.name())),
        Column::number("trained clean, pp", &["loss_clean_points"], |row: &(&str, Unmet)| {
            points(row.1.clean)
        }),
        Column::number("without this fault, pp", &["loss_unmet_points"], |row: &(&str, Unmet)| {
            points(row.1.unmet)
        }),
        Column::number("under all faults, pp", &["loss_met_points"], |row: &(&str, Unmet)| points(row.1.met)),
        Column::text("helps unknown", "helps", |row: &(&str, Unmet)| {
            Cell::yes(row.1.unmet < row.1.clean, "yes")
        }),
    ];
    let caption = "Faults that training never met: accuracy lost, percentage points, mean over severities, after a \
                   clean training, one under all faults but this one, and one under all";
    Table::new(table::UNMET, caption.into(), columns, &each)
}
