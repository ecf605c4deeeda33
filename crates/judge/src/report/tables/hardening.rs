//! Training under faults beside training on clean samples; faults that training never met.

use taxel_report::numbers::digits;
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::{Change, Hardened, Primary, Unmet};

/// A difference with its interval.
fn change(own: Change, signed: fn(f64) -> String) -> Cell {
    let shown =
        own.interval.map_or(String::new(), |[low, high]| format!(" ({} to {})", signed(low), signed(high)));
    let bounds = own.interval.map_or([None, None], |bounds| bounds.map(Some));
    Cell::number(Some(own.mean), signed).and(shown, &bounds)
}

pub(super) fn hardening(primary: &Primary, rows: &[Hardened]) -> Table {
    let (show, signed) = (primary.show(), primary.show_signed());
    let points = move |value: f64| Cell::number(Some(value), show);
    let (loss, name) = (|name: &str| primary.column_of_loss(name), primary.name());
    let met = |h: &Hardened| match h.unmet.len() {
        0 => Cell::text("–"),
        all => Cell::text(format!("{} of {all}", h.helped())),
    };
    let columns = vec![
        Column::text("network", "network", |h: &Hardened| Cell::text(&h.clean)),
        Column::number(
            &format!("{}, trained clean", primary.head_of("clean")),
            &[&primary.column("trained_clean")],
            move |h: &Hardened| points(h.scores[0]),
        ),
        Column::number("under faults", &[&primary.column("hardened")], move |h: &Hardened| {
            points(h.scores[1])
        }),
        Column::number(
            &primary.head_of_loss("difference"),
            &[
                &loss(&format!("{name}_change")),
                &format!("{name}_change_low"),
                &format!("{name}_change_high"),
            ],
            move |h: &Hardened| change(h.score_change, signed),
        ),
        Column::number(
            &primary.head_of_loss("lost to faults, trained clean"),
            &[&loss("loss_trained_clean")],
            move |h: &Hardened| points(h.loss[0]),
        ),
        Column::number(
            &primary.head_of_loss("under faults"),
            &[&loss("loss_hardened")],
            move |h: &Hardened| points(h.loss[1]),
        ),
        Column::number(
            &primary.head_of_loss("difference in loss"),
            &[&loss("loss_change"), "loss_change_low", "loss_change_high"],
            move |h: &Hardened| change(h.loss_change, signed),
        ),
        Column::number("s a fold, trained clean", &["train_seconds_clean"], |h: &Hardened| {
            Cell::number(Some(h.train_seconds[0]), digits)
        }),
        Column::number("s a fold, under faults", &["train_seconds_hardened"], |h: &Hardened| {
            Cell::number(Some(h.train_seconds[1]), digits)
        }),
        Column::text("unknown faults that cost less", "unmet_helped", met),
    ];
    let (title, points) = (primary.title(), primary.in_points());
    let caption = format!(
        "Trained on clean samples and under faults: {title} on unbroken samples, and what faults cost, {points}, mean \
         over faults and severities; differences over folds with their 95 % interval (corrected resampled t-test)"
    );
    Table::new(table::HARDENING, caption, columns, rows)
}

/// One row for each network and fault that one of its trainings was spared.
pub(super) fn unmet(primary: &Primary, rows: &[Hardened]) -> Table {
    let show = primary.show();
    let column = |head: &str, field: &str, loss: fn(&Unmet) -> f64| {
        let (head, field) = (primary.head_of_loss(head), primary.column_of_loss(field));
        Column::number(&head, &[&field], move |row: &(&str, Unmet)| Cell::number(Some(loss(&row.1)), show))
    };
    let each: Vec<(&str, Unmet)> =
        rows.iter().flat_map(|h| h.unmet.iter().map(|own| (h.clean.as_str(), *own))).collect();
    let columns = vec![
        Column::text("network", "network", |row: &(&str, Unmet)| Cell::text(row.0)),
        Column::text("fault", "fault", |row: &(&str, Unmet)| Cell::text(row.1.fault.name())),
        column("trained clean", "loss_clean", |own| own.clean),
        column("without this fault", "loss_unmet", |own| own.unmet),
        column("under all faults", "loss_met", |own| own.met),
        Column::text("helps unknown", "helps", |row: &(&str, Unmet)| {
            Cell::yes(row.1.unmet < row.1.clean, "yes")
        }),
    ];
    let (lost, points) = (primary.lost(false), primary.in_points());
    let caption = format!(
        "Faults that training never met: {lost}, {points}, mean over severities, after a clean training, one under all \
         faults but this one, and one under all"
    );
    Table::new(table::UNMET, caption, columns, &each)
}
