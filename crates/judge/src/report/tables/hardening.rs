//! Training under faults beside training on clean samples; faults unseen in training.

use taxel_report::numbers::{between, digits};
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::{Change, Hardened, Primary, UnseenFault};

/// Returns a difference with its interval.
fn change(change: Change, signed: fn(f64) -> String) -> Cell {
    Cell::number(Some(change.mean), signed).interval(change.interval, between(signed))
}

pub(super) fn hardening(primary: &Primary, rows: &[Hardened]) -> Table {
    let (show, signed) = (primary.show(), primary.show_signed());
    let (loss, name) = (|name: &str| primary.column_of_loss(name), primary.name());
    let helped = |h: &Hardened| match h.unseen.len() {
        0 => Cell::text("–"),
        all => Cell::text(format!("{} of {all}", h.helped())),
    };
    let columns = vec![
        Column::text("network", "network", |h: &Hardened| Cell::text(&h.clean)),
        Column::value(
            &format!("{}, trained clean", primary.head_of("clean")),
            &primary.column("trained_clean"),
            show,
            |h: &Hardened| Some(h.scores[0]),
        ),
        Column::value("under faults", &primary.column("hardened"), show, |h: &Hardened| Some(h.scores[1])),
        Column::number(
            &primary.head_of_loss("difference"),
            &[
                &loss(&format!("{name}_change")),
                &format!("{name}_change_low"),
                &format!("{name}_change_high"),
            ],
            move |h: &Hardened| change(h.score_change, signed),
        ),
        Column::value(
            &primary.head_of_loss("lost to faults, trained clean"),
            &loss("loss_trained_clean"),
            show,
            |h: &Hardened| Some(h.loss[0]),
        ),
        Column::value(&primary.head_of_loss("under faults"), &loss("loss_hardened"), show, |h: &Hardened| {
            Some(h.loss[1])
        }),
        Column::number(
            &primary.head_of_loss("difference in loss"),
            &[&loss("loss_change"), "loss_change_low", "loss_change_high"],
            move |h: &Hardened| change(h.loss_change, signed),
        ),
        Column::value("s a fold, trained clean", "train_seconds_clean", digits, |h: &Hardened| {
            Some(h.train_seconds[0])
        }),
        Column::value("s a fold, under faults", "train_seconds_hardened", digits, |h: &Hardened| {
            Some(h.train_seconds[1])
        }),
        Column::text("unknown faults that cost less", "unmet_helped", helped),
    ];
    let (title, points) = (primary.title(), primary.in_points());
    let caption = format!(
        "Trained on clean samples and under faults: {title} on unbroken samples, and what faults cost, {points}, mean \
         over faults and severities; differences over folds with their 95 % interval (corrected resampled t-test)"
    );
    Table::new(table::HARDENING, caption, columns, rows)
}

/// Returns a table with a row for each network and each fault that was left out of one of its trainings.
pub(super) fn unseen(primary: &Primary, rows: &[Hardened]) -> Table {
    let show = primary.show();
    let column = |head: &str, field: &str, loss: fn(&UnseenFault) -> f64| {
        let (head, field) = (primary.head_of_loss(head), primary.column_of_loss(field));
        Column::value(&head, &field, show, move |row: &(&str, UnseenFault)| Some(loss(&row.1)))
    };
    let each: Vec<(&str, UnseenFault)> =
        rows.iter().flat_map(|h| h.unseen.iter().map(|probe| (h.clean.as_str(), *probe))).collect();
    let columns = vec![
        Column::text("network", "network", |row: &(&str, UnseenFault)| Cell::text(row.0)),
        Column::text("fault", "fault", |row: &(&str, UnseenFault)| Cell::text(row.1.fault.name())),
        column("trained clean", "loss_clean", |probe| probe.clean),
        column("without this fault", "loss_unmet", |probe| probe.unseen),
        column("under all faults", "loss_met", |probe| probe.seen),
        Column::text("helps unknown", "helps", |row: &(&str, UnseenFault)| {
            Cell::yes(row.1.unseen < row.1.clean, "yes")
        }),
    ];
    let (lost, points) = (primary.lost(false), primary.in_points());
    let caption = format!(
        "Faults that training never met: {lost}, {points}, mean over severities, after a clean training, one under all \
         faults but this one, and one under all"
    );
    Table::new(table::UNSEEN, caption, columns, &each)
}
