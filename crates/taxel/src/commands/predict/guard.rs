//! Broken channels and taxels that a model's guard replaced, in words and as JSON.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use taxel::base::thousands;
use taxel::learn::guard::{Guard, ReplacedElement};

/// Channels that a summary names.
const NAMED: usize = 5;

/// The broken channels and taxels of each sample.
pub struct Replaced {
    guard: Guard,
    found: Vec<Vec<ReplacedElement>>,
}

impl Replaced {
    pub fn new(guard: Guard, found: Vec<Vec<ReplacedElement>>) -> Self {
        Replaced { guard, found }
    }

    /// Counts the replaced channels or taxels of a sample.
    pub fn count(&self, sample: usize) -> usize {
        self.found[sample].len()
    }

    /// Returns those of a sample by number and name, and the sign by which each was found.
    pub fn json(&self, sample: usize) -> Value {
        let one = |found: &ReplacedElement| json!({"element": found.element, "name": self.guard.name(found.element), "how": found.kind});
        self.found[sample].iter().map(one).collect()
    }

    /// Returns the same in words: `channel 3 (at full scale)`.
    pub fn words(&self, sample: usize) -> String {
        let one =
            |found: &ReplacedElement| format!("{} ({})", self.guard.name(found.element), found.kind.words());
        self.found[sample].iter().map(one).collect::<Vec<_>>().join(", ")
    }

    /// Sums up all samples; none where nothing was replaced.
    pub fn summary(&self) -> Option<String> {
        let samples = self.found.iter().filter(|found| !found.is_empty()).count();
        if samples == 0 {
            return None;
        }
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        self.found.iter().flatten().for_each(|found| *counts.entry(found.element).or_default() += 1);
        let mut named: Vec<(usize, usize)> = counts.into_iter().collect();
        named.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let more = named.len().saturating_sub(NAMED);
        let times = |(element, count): &(usize, usize)| format!("{} in {count}", self.guard.name(*element));
        let mut words: Vec<String> = named.iter().take(NAMED).map(times).collect();
        words.extend((more > 0).then(|| format!("{more} more")));
        let [samples, all] = [samples, self.found.len()].map(|count| thousands(count as u64));
        Some(format!(
            "the guard replaced values in {samples} of {all} samples: {}; --no-guard leaves them",
            words.join(", ")
        ))
    }
}
