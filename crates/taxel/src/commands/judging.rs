//! The judgement of a run, for all commands that need one, and the network that it chooses.

use taxel::judge::{Case, Choice, Criteria, Judgement, StressOptions, choose};
use taxel::reporting;

use crate::terminal::progress::bar;

/// Returns default options on at most `threads` threads.
pub fn stress_options(threads: usize) -> StressOptions {
    StressOptions { threads, ..StressOptions::default() }
}

/// Chooses by the default criteria, for commands that need one network of a run.
pub fn choice(case: &Case) -> taxel::Result<Choice> {
    Ok(choose(case, &judgement(case, None)?, &Criteria::default())?)
}

/// Reads what was measured before, or measures now.
pub fn judgement(case: &Case, stress: Option<StressOptions>) -> taxel::Result<Judgement> {
    reporting::judgement(case, stress, &*bar())
}

/// Measures now, with a bar on a terminal.
pub fn now(case: &Case, stress: Option<StressOptions>) -> taxel::Result<Judgement> {
    reporting::measure(case, stress, &*bar())
}
