//! What a model's guard found in recordings, in words and as JSON.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use taxel::base::thousands;
use taxel::learn::guard::{Found, Guard};

/// Channels that a summary names.
const NAMED: usize = 5;

/// What a guard found in each sample.
pub struct Mended {
    guard: Guard,
    found: Vec<Vec<Found>>,
}

impl Mended {
    pub fn new(guard: Guard, found: Vec<Vec<Found>>) -> Self {
        Mended { guard, found }
    }

    /// How many channels or taxels of a sample were replaced.
    pub fn count(&self, sample: usize) -> usize {
        self.found[sample].len()
    }

    /// Those of a sample by number and name, and how each was known to be broken.
    pub fn json(&self, sample: usize) -> Value {
        let one = |own: &Found| json!({"element": own.element, "name": self.guard.name(own.element), "how": own.kind});
        self.found[sample].iter().map(one).collect()
    }

    /// The same in words: `channel 3 (at full scale)`.
    pub fn words(&self, sample: usize) -> String {
        let one = |own: &Found| format!("{} ({})", self.guard.name(own.element), own.kind.words());
        self.found[sample].iter().map(one).collect::<Vec<_>>().join(", ")
    }

    /// What was replaced in all samples; none where nothing was.
    pub fn summary(&self) -> Option<String> {
        let samples = self.found.iter().filter(|own| !own.is_empty()).count();
        if samples == 0 {
            return None;
        }
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        self.found.iter().flatten().for_each(|own| *counts.entry(own.element).or_default() += 1);
        let mut named: Vec<(usize, usize)> = counts.into_iter().collect();
        named.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let more = named.len().saturating_sub(NAMED);
        let times = |(element, count): &(usize, usize)| format!("{} in {count}", self.guard.name(*element));
        let mut words: Vec<String> = named.iter().take(NAMED).map(times).collect();
        words.extend((more > 0).then(|| format!("{more} more")));
        let [samples, all] = [samples, self.found.len()].map(|count| thousands(count as u64));
        Some(format!(
            "the guard replaced readings in {samples} of {all} samples: {}; --no-guard leaves them",
            words.join(", ")
        ))
    }
}
