//! A claim of a paper and its result on a run.

use serde::{Deserialize, Serialize};
use taxel::data::Source;

use super::contrast::{Contrast, weakest};

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
    /// The run lacks a network, an attribute or a protocol that the claim is about: [`Claim::lacks`] says
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

/// A claim of a paper, tested on one run.
#[derive(Debug, Clone, PartialEq)]
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
    /// Whether each repetition of the run simulated a world of its own.
    pub fresh: bool,
    /// Bound above which a contrast supports the claim, in its unit: 0 where something is to be larger.
    pub least: f64,
    /// Its comparisons; none where the run lacks something.
    pub contrasts: Vec<Contrast>,
    /// The network, attribute or protocol that the run lacks.
    pub lacks: Option<String>,
}

impl Claim {
    /// Returns the contrast that decides, the one nearest to refuting the claim.
    pub fn weakest(&self) -> Option<&Contrast> {
        weakest(self.least, &self.contrasts)
    }

    /// Returns the verdict.
    pub fn outcome(&self) -> Verdict {
        self.weakest().map_or(Verdict::CannotBeTested, |contrast| contrast.verdict(self.least))
    }

    /// Describes the comparison and its unit; where there is none, what the run lacks.
    pub fn effect(&self) -> String {
        match (self.weakest(), &self.lacks) {
            (Some(contrast), _) => contrast.words(self.least, self.contrasts.len()),
            (None, Some(lacks)) => format!("the run lacks {lacks}"),
            (None, None) => "the run lacks test parts that the networks share".into(),
        }
    }
}
