//! Scores under faults: breaking points, losses, all curves.

use taxel_report::numbers::tenth;
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::report::words::stress_basis;
use crate::values::{FaultInfo, NetworkStress, Score, Stress};

fn percent(share: Option<f64>) -> Option<f64> {
    share.map(|share| 100.0 * share)
}

pub(super) fn breaking_points(stress: &Stress) -> Table {
    let (primary, show) = (&stress.primary, stress.primary.show());
    let loss = |name: &str| primary.column_of_loss(name);
    let reference = stress.reference.as_deref().unwrap_or("none");
    let whole = |value: f64| format!("{value:.0}");
    let broken = |n: &NetworkStress| n.curves.iter().filter(|c| c.breaks_at.is_some()).count();
    let columns = vec![
        Column::text("network", "network", |n: &NetworkStress| Cell::text(&n.network)),
        Column::value(
            &primary.head_of("clean"),
            &format!("clean_{}", primary.column("")),
            show,
            |n: &NetworkStress| Some(n.clean.score),
        ),
        Column::value(&primary.head_of_loss("mean loss"), &loss("mean_loss"), show, |n: &NetworkStress| {
            Some(n.mean_loss)
        }),
        Column::value(
            &primary.head_of_loss("worst fault"),
            &loss("worst_loss"),
            show,
            |n: &NetworkStress| Some(n.worst_loss),
        ),
        Column::count("faults that break it", "broken_faults", move |n: &NetworkStress| broken(n) as u64),
        Column::value("mCE %", "corruption_error_percent", whole, |n: &NetworkStress| n.corruption_error),
        Column::value("relative mCE %", "relative_corruption_error_percent", whole, |n: &NetworkStress| {
            n.relative_corruption_error
        }),
        Column::value("ECE clean %", "calibration_error_clean_percent", tenth, |n: &NetworkStress| {
            percent(n.clean.calibration_error)
        }),
        Column::value("ECE broken %", "calibration_error_broken_percent", tenth, |n: &NetworkStress| {
            percent(n.calibration_error)
        }),
        Column::text("in words", "verdict", |n: &NetworkStress| Cell::text(&n.verdict)).in_files(),
    ];
    let caption = format!(
        "Where networks break: {}; losses in {}, mean over faults and severities; mCE: errors relative to \
         {reference}'s, below 100 is steadier; ECE: expected calibration error",
        stress_basis(stress),
        primary.in_points()
    );
    Table::new(table::BREAKING_POINTS, caption, columns, &stress.networks)
}

/// Returns a table with a row per network and a column per fault.
pub(super) fn losses(stress: &Stress) -> Table {
    let (primary, show) = (&stress.primary, stress.primary.show());
    let mut columns = vec![Column::text("network", "network", |n: &NetworkStress| Cell::text(&n.network))];
    for (i, info) in stress.faults.iter().enumerate() {
        let name = info.fault.name();
        let (loss, at) = (primary.column_of_loss(&format!("{name}_loss")), format!("{name}_breaks_at"));
        columns.push(Column::number(name, &[&loss, &at], move |n: &NetworkStress| match n.curves.get(i) {
            Some(curve) => {
                let at = curve.breaks_at;
                let shown = at.map_or(String::new(), |at| format!(" ✕{at}"));
                Cell::number(Some(curve.loss(n.clean, primary)), show).and(shown, &[at.map(f64::from)])
            }
            None => Cell::number(None, show).and(String::new(), &[None]),
        }));
    }
    let (lost, points, margin) = (primary.lost(true), primary.in_points(), primary.margin_of_chance());
    let caption = format!(
        "{lost} under each fault, {points}, mean over severities; ✕3: from severity 3 on half of the {margin} is gone"
    );
    Table::new(table::FAULT_LOSSES, caption, columns, &stress.networks)
}

pub(super) fn curves(stress: &Stress) -> Table {
    type Row<'a> = (&'a str, &'a FaultInfo, u8, Score, Option<u8>);
    let mut rows: Vec<Row> = vec![];
    for network in &stress.networks {
        for (info, curve) in stress.faults.iter().zip(&network.curves) {
            let row = |&(severity, score): &(u8, Score)| {
                (network.network.as_str(), info, severity, score, curve.breaks_at)
            };
            rows.extend(curve.points.iter().map(row));
        }
    }
    let (primary, show) = (&stress.primary, stress.primary.show());
    let level = |row: &Row| f64::from(row.1.level(row.2));
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::text("fault", "fault", |row: &Row| Cell::text(row.1.fault.name())),
        Column::count("severity", "severity", |row: &Row| row.2.into()),
        Column::value("level", "level", |v| v.to_string(), move |row: &Row| Some(level(row))),
        Column::text("unit", "unit", |row: &Row| Cell::text(&row.1.unit)),
        Column::value(&primary.head(), &primary.column(""), show, move |row: &Row| Some(row.3.score)),
        Column::value("calibration error %", "calibration_error_percent", tenth, |row: &Row| {
            percent(row.3.calibration_error)
        }),
        Column::count("refused samples", "refused", |row: &Row| row.3.refused as u64),
        Column::text("broken", "broken", |row: &Row| {
            Cell::yes(row.4.is_some_and(|at| row.2 >= at), "broken")
        }),
    ];
    let caption = format!("{} under every fault and severity: {}", primary.heading(), stress_basis(stress));
    Table::new(table::FAULT_CURVES, caption, columns, &rows)
}

pub(super) fn kinds(stress: &Stress) -> Table {
    let levels = |info: &FaultInfo| info.levels.map(|v| v.to_string()).join(", ");
    let columns = vec![
        Column::text("fault", "fault", |info: &FaultInfo| Cell::text(info.fault.name())),
        Column::text("what happens", "what", |info: &FaultInfo| Cell::text(&info.what)),
        Column::text("severities 1 to 5", "levels", move |info: &FaultInfo| Cell::text(levels(info))),
        Column::text("unit", "unit", |info: &FaultInfo| Cell::text(&info.unit)),
    ];
    Table::new(table::FAULTS, "The faults that were tried".into(), columns, &stress.faults)
}
