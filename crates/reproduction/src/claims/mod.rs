//! Claims of the papers, tested on runs.

mod benchmark;
mod claim;
mod finding;
mod palpation;
mod papers;
mod questions;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
mod transfer;

use benchmark::Benchmark;
pub use claim::{Claim, Verdict};
pub(crate) use papers::CLAIMS;

use taxel::judge::Case;
use taxel::judge::Judgement;
use taxel::judge::Result;

/// Tests every claim of the five papers on every run, in the order of the papers. Runs on the same samples, divided
/// alike, are one: Kaewrakmuk and Srinonchat 2026's tables share their networks so.
///
/// A claim over several networks ("the best") holds if it does against each: shown is the one that comes
/// nearest to refuting it. Differences of accuracy are tested as by [`taxel::judge::choose`], each at 95 %.
///
/// # Errors
/// A statistic that is not finite.
pub fn claims(runs: &[(&Case, &Judgement)]) -> Result<Vec<Claim>> {
    let all = runs.iter().map(|(case, judgement)| Benchmark::of(case, judgement)).collect();
    settle(Benchmark::join(all))
}

fn settle(all: Vec<Benchmark>) -> Result<Vec<Claim>> {
    let mut claims = vec![];
    for definition in CLAIMS {
        for run in &all {
            let others: Vec<&Benchmark> = all.iter().filter(|other| !std::ptr::eq(*other, run)).collect();
            let finding = (definition.test)(run, &others)?;
            claims.push(Claim {
                paper: definition.paper.into(),
                place: definition.place.into(),
                says: definition.says.into(),
                run: run.name.clone(),
                source: run.judgement.results.source.clone(),
                outcome: finding.outcome,
                effect: finding.effect,
                size: finding.size,
                interval: finding.interval,
            });
        }
    }
    Ok(claims)
}
