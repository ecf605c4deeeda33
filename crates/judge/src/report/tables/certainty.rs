//! How far probabilities can be believed, and what gates find unknown.

use taxel_learn::certainty::groups_needed;
use taxel_report::numbers::tenth;
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::{NetworkStress, RowCertainty, Score, Stress};

/// Area under the ROC curve, 0..1, below which a gate tells nothing.
const CHANCE: f64 = 0.55;

fn percent(share: Option<f64>) -> Option<f64> {
    share.map(|share| 100.0 * share)
}

/// Returns a table with a row per network: temperature, calibration errors, sets, unknown classes.
pub(super) fn certainty(rows: &[RowCertainty]) -> Table {
    let third = |value: f64| format!("{value:.3}");
    let second = |value: f64| format!("{value:.2}");
    let set = |row: &RowCertainty| row.certainty.sets_at(0.9).cloned();
    let mut columns = vec![
        Column::text("network", "network", |row: &RowCertainty| Cell::text(&row.network)),
        Column::value("temperature", "temperature", third, |row: &RowCertainty| {
            Some(row.certainty.temperature)
        }),
        Column::value(
            "error by itself %",
            "calibration_error_before_percent",
            tenth,
            |row: &RowCertainty| Some(100.0 * row.certainty.calibration_error.before),
        ),
        Column::value("calibrated %", "calibration_error_after_percent", tenth, |row: &RowCertainty| {
            Some(100.0 * row.certainty.calibration_error.after)
        }),
        Column::value("to expect %", "calibration_error_floor_percent", tenth, |row: &RowCertainty| {
            Some(100.0 * row.certainty.calibration_error.floor)
        }),
        Column::value("worst group %", "worst_group_gap_percent", tenth, |row: &RowCertainty| {
            percent(row.certainty.worst_group_gap)
        }),
        Column::value("90 % sets cover %", "set_90_covered_percent", tenth, move |row: &RowCertainty| {
            percent(set(row).map(|set| set.covered))
        }),
        Column::value("worst group", "set_90_worst_group_percent", tenth, move |row: &RowCertainty| {
            percent(set(row).and_then(|set| set.worst_group))
        }),
        Column::value("classes in a set", "set_90_size", second, move |row: &RowCertainty| {
            set(row).map(|set| set.size)
        }),
    ];
    if rows.iter().any(|row| row.unknown.is_some()) {
        columns.extend([
            Column::value("unknown: AUROC %", "unknown_auroc_percent", tenth, |row: &RowCertainty| {
                percent(row.unknown.map(|unknown| unknown.auroc))
            }),
            Column::value("refused %", "unknown_refused_percent", tenth, |row: &RowCertainty| {
                percent(row.unknown.map(|unknown| unknown.refused))
            }),
            Column::value("false alarms %", "unknown_false_alarms_percent", tenth, |row: &RowCertainty| {
                percent(row.unknown.map(|unknown| unknown.false_alarms))
            }),
        ]);
    }
    let mut few = few_groups(rows.iter().find_map(|row| row.certainty.fitted_on.groups));
    if !few.is_empty() {
        few += ": what sets covered is what was seen";
    }
    let caption = format!(
        "Expected calibration error in 15 bins, each part at the temperature of the others; to expect: that of a model whose \
         probabilities are right, with as many samples{few}{}",
        blind(rows)
    );
    Table::new(table::CERTAINTY, caption, columns, rows)
}

/// Says that there are too few groups for a promise, and how many that needs; empty where there are enough, or none.
pub(super) fn few_groups(groups: Option<usize>) -> String {
    let needed = groups_needed(0.9);
    groups.filter(|groups| *groups < needed).map_or(String::new(), |few| {
        format!(". With {few} groups nothing can be promised at 90 % for a new one, which needs {needed}")
    })
}

/// Lists the rows whose gates do not tell classes that nobody learned; empty where there are none.
fn blind(rows: &[RowCertainty]) -> String {
    let is_blind = |row: &&RowCertainty| row.unknown.is_some_and(|unknown| unknown.auroc < CHANCE);
    let names: Vec<&str> = rows.iter().filter(is_blind).map(|row| row.network.as_str()).collect();
    if names.is_empty() {
        return String::new();
    }
    let (names, chance) = (names.join(", "), 100.0 * CHANCE);
    format!(
        ". The logits of {names} do not tell classes that nobody learned: an AUROC below {chance:.0} % is chance"
    )
}

/// Returns a table with a row per network and a column per fault: what gates find unknown.
pub(super) fn unknown(stress: &Stress) -> Table {
    let mut columns = vec![
        Column::text("network", "network", |n: &NetworkStress| Cell::text(&n.network)),
        Column::value("clean", "clean_unknown_percent", tenth, |n: &NetworkStress| percent(n.clean.unknown)),
    ];
    for (i, info) in stress.faults.iter().enumerate() {
        let name = info.fault.name();
        columns.push(Column::value(
            name,
            &format!("{name}_unknown_percent"),
            tenth,
            move |n: &NetworkStress| {
                let mean = |score: &Score| score.unknown.unwrap_or(0.0);
                percent(n.curves.get(i).filter(|_| n.clean.unknown.is_some()).map(|curve| curve.mean(mean)))
            },
        ));
    }
    let caption = "Samples that are answered as unknown, %, by the gate of the other folds: clean ones, which are false alarms, \
                   and under each fault, mean over severities";
    let with_gates: Vec<&NetworkStress> =
        stress.networks.iter().filter(|n| n.clean.unknown.is_some()).collect();
    let rows: Vec<NetworkStress> = with_gates.into_iter().cloned().collect();
    Table::new(table::UNKNOWN, caption.into(), columns, &rows)
}

/// Returns a table of the answers that are 90 % sure, clean and broken.
pub(super) fn sure(stress: &Stress) -> Table {
    let rows: Vec<NetworkStress> = stress.networks.iter().filter(|n| n.sure.is_some()).cloned().collect();
    let columns = vec![
        Column::text("network", "network", |n: &NetworkStress| Cell::text(&n.network)),
        Column::value("clean: 90 % sure, %", "clean_sure_percent", tenth, |n: &NetworkStress| {
            percent(n.sure.map(|sure| sure.share))
        }),
        Column::value("of these right, %", "clean_sure_right_percent", tenth, |n: &NetworkStress| {
            percent(n.sure.filter(|sure| sure.share > 0.0).map(|sure| sure.right))
        }),
        Column::value("under faults: 90 % sure, %", "broken_sure_percent", tenth, |n: &NetworkStress| {
            percent(n.sure_when_broken.map(|sure| sure.share))
        }),
        Column::value(
            "of these right under faults, %",
            "broken_sure_right_percent",
            tenth,
            |n: &NetworkStress| {
                percent(n.sure_when_broken.filter(|sure| sure.share > 0.0).map(|sure| sure.right))
            },
        ),
    ];
    let caption = "Answers that are 90 % sure or more at the temperature of the other folds, and how many of them are right. No \
                   temperature makes a network honest under faults that was trained on clean samples; training under faults does";
    Table::new(table::SURE, caption.into(), columns, &rows)
}
