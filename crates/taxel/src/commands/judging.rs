//! What commands that judge runs have in common: a run opened with its data, and a judgement of it.

use std::io::IsTerminal;
use std::path::Path;

use taxel::judge::{Case, EarlyOptions, Judgement, Options, StressOptions, judge};
use taxel::learn::{IndicatifProgress, Progress};
use taxel::{Registry, RunFolder};

/// A run folder with its samples, read or simulated again.
pub fn open(path: &Path) -> Result<Case, Box<dyn std::error::Error>> {
    let folder = RunFolder::open(path)?;
    let (_, dataset) = taxel::experiment::open(&folder, &Registry::built_in())?;
    Ok(Case::new(folder, dataset)?)
}

/// Default options on at most `threads` threads.
pub fn stress_options(threads: Option<usize>) -> StressOptions {
    StressOptions { threads: super::threads(threads), ..StressOptions::default() }
}

/// The judgement in the run folder, if it has the faults that are asked for.
pub fn before(case: &Case, stress: Option<&StressOptions>) -> Result<Option<Judgement>, taxel::judge::Error> {
    let has = |judgement: &Judgement| match (stress, &judgement.stress) {
        (None, _) => true,
        (Some(wanted), Some(had)) => !wanted.guard || had.networks.iter().any(|own| own.other.is_some()),
        (Some(_), None) => false,
    };
    Ok(Judgement::read(case)?.filter(has))
}

/// What is in the run folder already, or is measured now.
pub fn judgement(case: &Case, stress: Option<StressOptions>) -> Result<Judgement, taxel::judge::Error> {
    match before(case, stress.as_ref())? {
        Some(judgement) => Ok(judgement),
        None => now(case, stress),
    }
}

/// Measures with progress and keeps what was measured in the run folder, which no other process may write to.
pub fn now(case: &Case, stress: Option<StressOptions>) -> Result<Judgement, taxel::judge::Error> {
    let _lock = case.folder.lock()?;
    let progress = IndicatifProgress::default();
    let terminal = std::io::stderr().is_terminal();
    let limits = |own: &StressOptions| EarlyOptions { samples: own.samples, threads: own.threads };
    let options = Options {
        early: Some(stress.as_ref().map(limits).unwrap_or_default()),
        stress,
        say: &|what| {
            if terminal {
                progress.say(what);
            }
        },
        start: &|steps| progress.start(steps),
        tick: &|| progress.step(1),
        ..Options::default()
    };
    let judgement = judge(case, &options);
    progress.finish();
    let judgement = judgement?;
    judgement.write(&case.folder)?;
    Ok(judgement)
}
