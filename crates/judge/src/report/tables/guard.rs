//! Networks with a guard before them and without one, side by side.

use taxel_report::numbers::tenth;
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::report::words::alarms;
use crate::values::{NetworkStress, Stress};

/// A value without the guard and with it.
fn both(values: Option<[f64; 2]>) -> Cell {
    let shown = values.map_or(String::new(), |[_, on]| format!(" → {}", tenth(on)));
    Cell::number(values.map(|[off, _]| off), tenth).and(shown, &[values.map(|[_, on]| on)])
}

/// One row per network, one column per fault; no rows where only one way was tried.
pub(super) fn guard(stress: &Stress) -> Table {
    let mut columns = vec![
        Column::text("network", "network", |n: &&NetworkStress| Cell::text(&n.network)),
        Column::number(
            "clean %",
            &["accuracy_without_percent", "accuracy_with_percent"],
            |n: &&NetworkStress| both(n.sides().map(|sides| sides.map(|(clean, _, _)| clean.accuracy))),
        ),
        Column::number(
            "mean loss, pp",
            &["mean_loss_without_points", "mean_loss_with_points"],
            |n: &&NetworkStress| both(n.sides().map(|sides| sides.map(|(_, _, loss)| loss))),
        ),
    ];
    for (i, info) in stress.faults.iter().enumerate() {
        let name = info.fault.name();
        let fields = ["without", "with"].map(|way| format!("{name}_loss_{way}_points"));
        columns.push(Column::number(name, &[&fields[0], &fields[1]], move |n: &&NetworkStress| {
            let loss = |curves: &[crate::values::FaultCurve]| curves.get(i).map(|curve| curve.loss(n.clean));
            let sides = n.sides().map(|sides| sides.map(|(_, curves, _)| loss(curves)));
            both(match sides {
                Some([Some(off), Some(on)]) => Some([off, on]),
                _ => None,
            })
        }));
    }
    let caption = format!(
        "Without a guard → with one before the network: accuracy on unbroken samples, and what each fault costs of \
         what the network has as it was saved, percentage points, mean over severities; {}",
        alarms(stress)
    );
    let rows: Vec<&NetworkStress> = stress.networks.iter().filter(|n| n.other.is_some()).collect();
    Table::new(table::GUARD, caption, columns, &rows)
}
