//! A claim of a paper and its result on a run.

use taxel::data::Source;

use super::contrast::{Contrast, weakest};
use super::verdict::Verdict;

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
