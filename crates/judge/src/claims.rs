//! What the papers claim, and what of it holds here.

mod field;
mod papers;
mod questions;

use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::error::Result;
use crate::judgement::{Judgement, Kind};
use field::Field;
use papers::CLAIMS;

/// Whether a claim holds on one run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The difference has the claimed sign, and its interval excludes 0 (of a claim that something costs
    /// less than so many points: excludes a larger cost).
    Holds,
    /// It has the other sign, or its interval includes 0 (or a larger cost).
    DoesNotHold,
    /// The run lacks a network, an attribute or a protocol that the claim is about: [`Claim::effect`] says
    /// which.
    CannotBeTested,
}

/// A claim of a paper, tested on one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// `000` to `004`.
    pub paper: String,
    /// Where it is printed.
    pub place: String,
    /// What it says.
    pub says: String,
    /// Name of the run.
    pub run: String,
    /// What the run measured on.
    pub source: String,
    /// Simulated or real.
    pub kind: Kind,
    /// Holds, does not, cannot be tested.
    pub outcome: Outcome,
    /// What was compared, in which unit; where nothing could be, what the run lacks.
    pub effect: String,
    /// Size of the effect, in the unit that `effect` names.
    pub size: Option<f64>,
    /// 95 % interval of it.
    pub interval: Option<[f64; 2]>,
}

/// Every claim of papers 000 to 004 on every run, in the order of the papers. Runs on the same samples,
/// divided alike, are one: paper 000's tables share their networks so.
///
/// A claim over several networks ("the best") holds if it does against each: shown is the one that comes
/// nearest to refuting it. Differences of accuracy are tested as by [`crate::choose`], each at 95 %.
///
/// # Errors
/// Damaged records.
pub fn claims(runs: &[(&Case, &Judgement)]) -> Result<Vec<Claim>> {
    let fields =
        runs.iter().map(|(case, judgement)| Field::of(case, judgement)).collect::<Result<Vec<_>>>()?;
    settle(Field::join(fields))
}

fn settle(fields: Vec<Field>) -> Result<Vec<Claim>> {
    let mut claims = vec![];
    for definition in CLAIMS {
        for field in &fields {
            let others: Vec<&Field> = fields.iter().filter(|other| !std::ptr::eq(*other, field)).collect();
            let answer = (definition.ask)(field, &others)?;
            claims.push(Claim {
                paper: definition.paper.into(),
                place: definition.place.into(),
                says: definition.says.into(),
                run: field.name.clone(),
                source: field.judgement.results.source.clone(),
                kind: field.judgement.kind,
                outcome: answer.outcome,
                effect: answer.effect,
                size: answer.size,
                interval: answer.interval,
            });
        }
    }
    Ok(claims)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
