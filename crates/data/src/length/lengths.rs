//! How long the recordings of a set are.

use crate::Error;
use crate::error::plural;
use crate::length::length::Length;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// The lengths of a set's recordings along time, before any rule, and what became of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lengths {
    /// Number of recordings.
    pub recordings: usize,
    /// Shortest and longest, in readings.
    pub range: [usize; 2],
    /// First quartile, median and third quartile; each the length of a recording (the lower of two).
    pub quartiles: [usize; 3],
    /// How many different lengths there are.
    pub distinct: usize,
    /// The rule that was used. None where recordings are unequal and nobody has said what to do: the card then
    /// shows them under the proposed one.
    pub rule: Option<Length>,
    /// What would do: all recordings at the median length.
    pub proposed: Length,
    /// Readings that are in no sample.
    pub unused: usize,
    /// Recordings that are shorter than a window.
    pub too_short: usize,
}

impl Lengths {
    pub(crate) fn of(lengths: &[usize], rule: Option<Length>) -> Self {
        let mut sorted = lengths.to_vec();
        sorted.sort_unstable();
        let at = |quarter: usize| sorted[(sorted.len() - 1) * quarter / 4];
        let (quartiles, range) = ([at(1), at(2), at(3)], [at(0), at(4)]);
        sorted.dedup();
        Self {
            recordings: lengths.len(),
            range,
            quartiles,
            distinct: sorted.len(),
            rule,
            proposed: Length::Resample { to: quartiles[1].max(2) },
            unused: 0,
            too_short: 0,
        }
    }
}

impl Lengths {
    /// What is said where recordings are unequal and there is no rule.
    pub(crate) fn refused(&self, file: &str) -> Error {
        let ([shortest, longest], proposed) = (self.range, self.proposed);
        Error::UnequalLengths { file: file.into(), shortest, longest, proposed }
    }
}

impl Lengths {
    /// What is in no sample; none where everything is.
    pub(crate) fn left_out(&self) -> Option<String> {
        let short = (self.too_short > 0)
            .then(|| format!("{} shorter than a window", plural(self.too_short, "recording")));
        match (self.unused, short) {
            (0, _) => None,
            (unused, None) => Some(format!("{} in no sample", plural(unused, "reading"))),
            (unused, Some(short)) => Some(format!("{} in no sample, {short}", plural(unused, "reading"))),
        }
    }
}

impl Display for Lengths {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [shortest, longest] = self.range;
        if self.distinct == 1 {
            return write!(f, "{shortest} readings each");
        }
        let [first, median, third] = self.quartiles;
        let distinct = plural(self.distinct, "length");
        write!(f, "{shortest} to {longest} readings, {distinct}; quartiles {first}, {median}, {third}")
    }
}
