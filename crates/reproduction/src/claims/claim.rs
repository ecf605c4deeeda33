//! A claim of a paper and its result on a run.

use serde::{Deserialize, Serialize};
use taxel::data::Source;

/// Whether a claim holds on one run. A claim over several networks ("the best") holds if it does against each, and
/// does not if it fails against one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The whole 95 % interval of the difference has the claimed sign (of a claim that something costs less
    /// than so many points: lies below that cost).
    Holds,
    /// The whole interval has the other sign (or lies above that cost).
    DoesNotHold,
    /// The interval reaches to both sides: so few test samples, folds or groups cannot tell.
    TooFewData,
    /// The run lacks a network, an attribute or a protocol that the claim is about: [`Claim::effect`] says
    /// which.
    CannotBeTested,
}

impl Verdict {
    /// Returns the verdict in words, as tables have it.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::DoesNotHold => "does not hold",
            Verdict::TooFewData => "too few data",
            Verdict::CannotBeTested => "cannot be tested here",
        }
    }
}

/// A claim of a paper, tested on one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// `000` to `004`.
    pub paper: String,
    /// Where it is printed.
    pub place: String,
    /// The claim in words.
    pub says: String,
    /// Name of the run.
    pub run: String,
    /// Source of the samples.
    pub source: Source,
    /// Holds, does not, cannot be tested.
    pub outcome: Verdict,
    /// The comparison and its unit; where there is none, the network or attribute that the run lacks.
    pub effect: String,
    /// Size of the effect, in the unit that `effect` names.
    pub size: Option<f64>,
    /// 95 % interval of it.
    pub interval: Option<[f64; 2]>,
}
