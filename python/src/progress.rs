//! A bar on a terminal, lines where somebody asks for them, or nothing.

use std::io::{IsTerminal, Write};
use std::sync::Mutex;

use taxel::IndicatifProgress;
use taxel::learn::{FoldKey, Progress, Silent};

/// Returns the progress of long work: `None` a bar on a terminal, `Some(true)` also lines elsewhere, `Some(false)` nothing.
pub fn progress(verbose: Option<bool>) -> Box<dyn Progress + Sync> {
    match (verbose, std::io::stderr().is_terminal()) {
        (Some(false), _) | (None, false) => Box::new(Silent),
        (_, true) => Box::<IndicatifProgress>::default(),
        (Some(true), false) => Box::<Lines>::default(),
    }
}

/// A line on standard error for every tenth of the work.
#[derive(Default)]
struct Lines {
    state: Mutex<StepCounts>,
}

#[derive(Default)]
struct StepCounts {
    work: u64,
    done: u64,
    tenths: u64,
}

impl Progress for Lines {
    fn start(&self, work: u64) {
        if let Ok(mut counts) = self.state.lock() {
            *counts = StepCounts { work, ..StepCounts::default() };
        }
    }

    fn fold(&self, key: &FoldKey, number: usize, total: usize) {
        print(&format!("{} fold {} ({number} of {total})", key.network, key.fold));
    }

    fn step(&self, work: u64) {
        if let Ok(mut counts) = self.state.lock() {
            counts.done += work;
            let tenths = 10 * counts.done / counts.work.max(1);
            if tenths > counts.tenths && counts.work > 0 {
                counts.tenths = tenths;
                print(&format!("{} %", 10 * tenths.min(10)));
            }
        }
    }

    fn finish(&self) {}

    fn say(&self, line: &str) {
        print(line);
    }
}

/// Prints a line on standard error. Where nobody reads it, the work goes on.
fn print(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
