//! Whether a sample is like those that a model has learned from, by what its card holds.

use crate::certainty::{Certainty, Readings, Seen};
use crate::model::card::Card;

impl Card {
    /// Checks whether the model tells samples that are unlike those that it has learned from.
    pub fn has_gate(&self) -> bool {
        self.certainty.as_ref().is_some_and(Certainty::has_gate) || self.readings_gate().is_some()
    }

    /// Returns the gate of logits; none of values, whose readings alone tell.
    pub(crate) fn logits_gate(&self) -> Option<&Seen> {
        self.certainty.as_ref()?.seen.as_ref()
    }

    /// Returns the gate of readings, of classes or of values.
    pub fn readings_gate(&self) -> Option<&Readings> {
        let of_classes = self.certainty.as_ref().and_then(|certainty| certainty.readings.as_ref());
        of_classes.or_else(|| self.intervals.as_ref()?.readings.as_ref())
    }

    /// Returns the distances by logits and by readings beyond which the familiarity of a sample is at most `share`, 0..1; none where no
    /// distance is enough, and without that gate.
    pub fn unknown_beyond(&self, share: f32) -> [Option<f32>; 2] {
        match (self.readings_gate(), self.logits_gate()) {
            (Some(gate), seen) => gate.limits(seen.map(|seen| seen.distances.as_slice()), share),
            (None, seen) => [seen.and_then(|seen| Seen::limit(seen, share)), None],
        }
    }
}
