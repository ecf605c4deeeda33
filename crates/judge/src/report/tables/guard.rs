//! Networks with a guard before them and without one, side by side.

use taxel_report::table::{Cell, Column, Table};

use super::eight_bits::both;
use crate::report::names::table;
use crate::report::words::alarms;
use crate::values::{NetworkStress, Stress};

/// Returns a table with a row per network and a column per fault; no rows where only one way was tried.
pub(super) fn guard(stress: &Stress) -> Table {
    let primary = &stress.primary;
    let show = primary.show();
    let mut columns = vec![
        Column::text("network", "network", |n: &&NetworkStress| Cell::text(&n.network)),
        Column::number(
            &primary.head_of("clean"),
            &[&primary.column("without"), &primary.column("with")],
            move |n: &&NetworkStress| {
                both(n.sides().map(|sides| sides.map(|(clean, _, _)| clean.score)), show)
            },
        ),
        Column::number(
            &primary.head_of_loss("mean loss"),
            &["without", "with"]
                .map(|way| primary.column_of_loss(&format!("mean_loss_{way}")))
                .each_ref()
                .map(String::as_str),
            move |n: &&NetworkStress| both(n.sides().map(|sides| sides.map(|(_, _, loss)| loss)), show),
        ),
    ];
    for (i, info) in stress.faults.iter().enumerate() {
        let name = info.fault.name();
        let fields = ["without", "with"].map(|way| primary.column_of_loss(&format!("{name}_loss_{way}")));
        columns.push(Column::number(name, &[&fields[0], &fields[1]], move |n: &&NetworkStress| {
            let loss = |curves: &[crate::values::FaultCurve]| {
                curves.get(i).map(|curve| curve.loss(n.clean, primary))
            };
            let sides = n.sides().map(|sides| sides.map(|(_, curves, _)| loss(curves)));
            let known = match sides {
                Some([Some(off), Some(on)]) => Some([off, on]),
                _ => None,
            };
            both(known, show)
        }));
    }
    let caption = format!(
        "Without a guard → with one before the network: {} on unbroken samples, and what each fault costs of what the \
         network has as it was saved, {}, mean over severities; {}",
        primary.title(),
        primary.in_points(),
        alarms(stress)
    );
    let rows: Vec<&NetworkStress> = stress.networks.iter().filter(|n| n.other.is_some()).collect();
    Table::new(table::GUARD, caption, columns, &rows)
}
