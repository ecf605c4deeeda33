//! What commands that judge runs have in common: threads, a bar on a terminal, what was measured before.

use std::io::IsTerminal;

use taxel::judge::{Case, Judgement, StressOptions};
use taxel::learn::{IndicatifProgress, Progress, Silent};
use taxel::reporting;

/// Default options on at most `threads` threads.
pub fn stress_options(threads: Option<usize>) -> StressOptions {
    StressOptions { threads: super::threads(threads), ..StressOptions::default() }
}

/// What is in the run folder already, or is measured now.
pub fn judgement(case: &Case, stress: Option<StressOptions>) -> taxel::Result<Judgement> {
    match reporting::before(case, stress.as_ref())? {
        Some(judgement) => Ok(judgement),
        None => now(case, stress),
    }
}

/// Measures, with a bar on a terminal.
pub fn now(case: &Case, stress: Option<StressOptions>) -> taxel::Result<Judgement> {
    let bar = IndicatifProgress::default();
    let progress: &(dyn Progress + Sync) = if std::io::stderr().is_terminal() { &bar } else { &Silent };
    reporting::measure(case, stress, progress)
}
