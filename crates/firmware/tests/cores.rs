//! Estimates of instructions and flash, held against what QEMU counted.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::collections::BTreeMap;

use common::{Case, classes, z_score};
use taxel_firmware::{Core, Library};

/// The page of what was measured.
const PAGE: &str = include_str!("../../../docs/benchmarks/2026-11-29-firmware.md");
/// How far an estimate may be off: instructions, and flash above and below.
const INSTRUCTIONS: f64 = 0.1;
const FLASH: std::ops::RangeInclusive<f64> = 0.0..=0.08;

/// A measured row: network, core, instructions, flash.
fn rows() -> Vec<(String, Core, f64, f64)> {
    let core = |name: &str| {
        let name = name.trim_end_matches(" with FPU").to_lowercase();
        Core::ALL.into_iter().find(|core| core.name().trim_end_matches('f') == name.trim_end_matches('f'))
    };
    let exact =
        |name: &str| Core::ALL.into_iter().find(|core| core.name() == name.to_lowercase()).or(core(name));
    let number = |cell: &str| cell.replace(',', "").parse::<f64>().ok();
    let row = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [network, core, instructions, _, flash, _, _] = cells[..] else { return None };
        Some((network.replace('_', "-"), exact(core)?, number(instructions)?, number(flash)?))
    };
    // Rows of linear models and of other answers have no estimate of their own.
    let of_zoo = |row: &(String, Core, f64, f64)| taxel_zoo::find(row.0.trim_end_matches("-f32")).is_ok();
    PAGE.lines().filter_map(row).filter(of_zoo).collect()
}

#[test]
fn estimates_are_near_what_was_counted() {
    let rows = rows();
    assert!(rows.len() >= 40, "{} rows", rows.len());
    assert!(Core::ALL.iter().all(|core| rows.iter().filter(|row| row.1 == *core).count() >= 4), "{rows:?}");
    let mut cases: BTreeMap<String, Case> = BTreeMap::new();
    let mut wrong = vec![];
    for (network, core, instructions, flash) in rows {
        let case = cases.entry(network.clone()).or_insert_with_key(|name| match name.strip_suffix("-f32") {
            Some(name) => Case::floats(name, z_score(), classes(None)),
            None => Case::new(name, z_score(), classes(None)),
        });
        let library: Library = case.library();
        let estimated = library.instructions(core).unwrap().unwrap() as f64;
        let bytes = library.flash(core).unwrap() as f64;
        let (off, larger) = (estimated / instructions - 1.0, bytes / flash - 1.0);
        println!(
            "{network} {core}: {estimated} of {instructions} ({off:+.3}), {bytes} of {flash} ({larger:+.3})"
        );
        if off.abs() > INSTRUCTIONS || !FLASH.contains(&larger) {
            wrong.push(format!("{network} on {core}: {off:+.3}, {larger:+.3}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
