//! What commands that judge runs have in common: threads, a bar on a terminal, what was measured before.

use std::io::IsTerminal;

use taxel::IndicatifProgress;
use taxel::judge::{Case, Judgement, StressOptions};
use taxel::learn::{Progress, Silent};
use taxel::reporting;

/// Default options on at most `threads` threads.
pub fn stress_options(threads: Option<usize>) -> StressOptions {
    StressOptions { threads: super::threads(threads), ..StressOptions::default() }
}

/// What is in the run folder already, or is measured now.
pub fn judgement(case: &Case, stress: Option<StressOptions>) -> taxel::Result<Judgement> {
    reporting::judgement(case, stress, &*bar())
}

/// Measures, with a bar on a terminal.
pub fn now(case: &Case, stress: Option<StressOptions>) -> taxel::Result<Judgement> {
    reporting::measure(case, stress, &*bar())
}

fn bar() -> Box<dyn Progress + Sync> {
    match std::io::stderr().is_terminal() {
        true => Box::<IndicatifProgress>::default(),
        false => Box::new(Silent),
    }
}
