//! What the papers claim, and what of it holds here.

use serde::{Deserialize, Serialize};

use crate::judgement::Kind;

/// Whether a claim holds on one run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The difference has the claimed sign, and its interval excludes 0.
    Holds,
    /// It has the other sign, or its interval includes 0.
    DoesNotHold,
    /// The run lacks a network, an attribute or a protocol that the claim is about.
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
    /// What was compared, and the size of the effect; `-` where nothing could be.
    pub effect: String,
    /// Size of the effect, in the unit that `effect` names.
    pub size: Option<f64>,
    /// 95 % interval of it.
    pub interval: Option<[f64; 2]>,
}
