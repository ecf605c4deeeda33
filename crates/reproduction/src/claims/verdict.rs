//! Outcomes of the test of a claim.

use serde::{Deserialize, Serialize};

/// Whether a claim holds. A claim over several networks ("the best") holds if it does against each, and
/// does not if it fails against one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The whole interval of the difference has the claimed sign (of a claim that something costs less
    /// than so many points: lies below that cost).
    Holds,
    /// The whole interval has the other sign (or lies above that cost).
    DoesNotHold,
    /// The whole interval lies within the margin of zero: the difference that the paper prints, or one point.
    NoDifference,
    /// The interval reaches to both sides: so few test samples, folds or groups cannot tell.
    TooFewData,
    /// The run lacks a network, an attribute or a protocol that the claim is about: the reason says
    /// which.
    CannotBeTested,
}

impl Verdict {
    /// All of them that say something, in the order of the page.
    pub(crate) const TESTED: [Verdict; 4] =
        [Verdict::Holds, Verdict::DoesNotHold, Verdict::NoDifference, Verdict::TooFewData];

    /// Returns the verdict in words, as tables have it.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::DoesNotHold => "does not hold",
            Verdict::NoDifference => "no difference worth naming",
            Verdict::TooFewData => "too few data",
            Verdict::CannotBeTested => "cannot be tested here",
        }
    }
}
