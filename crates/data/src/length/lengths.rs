//! The lengths of the recordings of a set.

use crate::Error;
use crate::error::plural;
use crate::length::length::Length;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// The lengths of a set's recordings along time, before any rule, and the rule for them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lengths {
    /// Number of recordings.
    pub recordings: usize,
    /// Shortest and longest, in time steps.
    pub range: [usize; 2],
    /// First quartile, median and third quartile; each the length of a recording (the lower of two).
    pub quartiles: [usize; 3],
    /// Number of different lengths.
    pub distinct: usize,
    /// The rule that was used; none where recordings are unequal and no rule is given. The card then shows them under the
    /// proposed one.
    pub rule: Option<Length>,
    /// A rule that would do: all recordings at the median length.
    pub proposed: Length,
    /// Time steps that are in no sample.
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

    /// Refuses unequal recordings without a rule.
    pub(crate) fn refused(&self, file: &str) -> Error {
        let ([shortest, longest], proposed) = (self.range, self.proposed);
        Error::UnequalLengths { file: file.into(), shortest, longest, proposed }
    }

    /// Says what is in no sample; none where everything is.
    pub(crate) fn left_out(&self) -> Option<String> {
        let short = match self.too_short {
            0 => String::new(),
            count => format!(", {} shorter than a window", plural(count, "recording")),
        };
        (self.unused > 0).then(|| format!("{} in no sample{short}", plural(self.unused, "reading")))
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
