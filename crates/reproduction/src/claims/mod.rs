//! Claims of the papers, tested on runs.

mod benchmark;
mod claim;
mod contrast;
mod finding;
mod palpation;
mod papers;
mod pooled;
mod questions;
mod sensors;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests_of_tables;
mod times;
mod transfer;
mod verdict;

use benchmark::Benchmark;
pub use claim::Claim;
pub use contrast::Contrast;
#[cfg(test)]
pub(crate) use papers::AROUND_CHANCE;
pub(crate) use papers::{CLAIMS, Definition, STITCHED};
pub(crate) use pooled::{Pooled, with_q};
pub use verdict::Verdict;

use taxel::judge::Case;
use taxel::judge::Judgement;
use taxel::judge::Result;

use crate::printed::Papers;

/// Tests every claim of the five papers on every run, in the order of the papers. Runs on the same samples, divided
/// alike, are one: Kaewrakmuk and Srinonchat 2026's tables share their networks so.
///
/// A claim over several networks ("the best") holds if it does against each: shown is the one that comes
/// nearest to refuting it. Runs on fresh worlds are looked at after a quarter, half and all of the worlds, and the first
/// look that decides stands; all looks together err in at most 5 % of cases ([`taxel::judge::statistics::looks`]).
///
/// # Errors
/// A statistic that is not finite.
pub fn claims(runs: &[(&Case, &Judgement)], printed: &Papers) -> Result<Vec<Claim>> {
    let all = runs.iter().map(|(case, judgement)| Benchmark::of(case, judgement, printed));
    settle(Benchmark::join(all.collect::<Result<_>>()?))
}

fn settle(all: Vec<Benchmark>) -> Result<Vec<Claim>> {
    let looks: Vec<Vec<Benchmark>> = all.iter().map(Benchmark::looks).collect();
    let mut claims = vec![];
    for definition in CLAIMS {
        for (run, looks) in all.iter().zip(&looks) {
            let others: Vec<&Benchmark> = all.iter().filter(|other| !std::ptr::eq(*other, run)).collect();
            claims.push(decide(definition, run, looks, &others)?);
        }
    }
    Ok(claims)
}

/// Tests a claim on a run: at the first look that decides, else at the last.
fn decide(
    definition: &Definition,
    run: &Benchmark,
    looks: &[Benchmark],
    others: &[&Benchmark],
) -> Result<Claim> {
    let mut claim = Claim {
        paper: definition.paper.into(),
        place: definition.place.into(),
        says: definition.says.into(),
        run: run.name.clone(),
        source: run.judgement.results.source.clone(),
        fresh: run.is_fresh(),
        least: 0.0,
        contrasts: vec![],
        lacks: Some("a quarter of its worlds".into()),
    };
    for look in looks {
        let finding = (definition.test)(look, others)?;
        (claim.least, claim.contrasts, claim.lacks) = (finding.least, finding.contrasts, finding.lacks);
        if ![Verdict::TooFewData, Verdict::CannotBeTested].contains(&claim.outcome()) {
            break;
        }
    }
    Ok(claim)
}
