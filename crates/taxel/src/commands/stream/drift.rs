//! Whether the latest decisions are like those that a model was fitted on.

use std::collections::VecDeque;

use serde_json::{Value, json};
use taxel::Card;

use crate::terminal::messages::warn;

/// Decisions that are looked at.
const LAST: usize = 100;
/// Unknown ones of them from which on the stream has drifted: of familiar windows 5 are, and 13 or more once in two thousand times.
const UNKNOWN: usize = 13;
/// How far the mean confidence may fall below that of held-out samples.
const LESS_SURE: f64 = 0.2;

/// The latest decisions. Early ones count too: what is left for whole windows is what was unlike the training from its beginning on.
pub struct Drift {
    /// Whether each was unknown, and how sure.
    last: VecDeque<(bool, f64)>,
    /// Mean probability of the answers that the model was fitted on; none of values, and of a model that is not calibrated.
    wanted: Option<f64>,
    /// Whether the model tells what is unknown, or how sure it has to be.
    is_watching: bool,
    is_said: bool,
}

impl Drift {
    pub fn new(card: &Card) -> Self {
        let wanted = card.certainty.as_ref().and_then(|certainty| certainty.confidence);
        let is_watching = wanted.is_some() || card.has_gate();
        Drift { last: VecDeque::with_capacity(LAST), wanted, is_watching, is_said: false }
    }

    /// Takes a decision, and warns once where the last hundred are unlike those that the model was fitted on.
    pub fn push(&mut self, is_unknown: bool, confidence: f64) {
        if !self.is_watching {
            return;
        }
        if self.last.len() == LAST {
            self.last.pop_front();
        }
        self.last.push_back((is_unknown, confidence));
        let words = if self.last.len() == LAST && !self.is_said { self.words() } else { None };
        if let Some(words) = words {
            self.is_said = true;
            warn(words);
        }
    }

    /// Says what is wrong with a hundred decisions.
    fn words(&self) -> Option<String> {
        let (unknown, sure) = self.means()?;
        let unknown = (unknown * LAST as f64).round() as usize;
        let why = match (unknown >= UNKNOWN, self.wanted.filter(|wanted| sure < wanted - LESS_SURE)) {
            (true, _) => format!(
                "{unknown} of the last {LAST} windows are unknown to the model, where 5 are to be expected of windows that begin as in training (--contact, --hop)"
            ),
            (false, Some(wanted)) => format!(
                "the last {LAST} answers are {:.0} % sure on average, and were {:.0} % on the samples that the model was fitted on",
                100.0 * sure,
                100.0 * wanted
            ),
            (false, None) => return None,
        };
        Some(format!(
            "the stream has drifted: {why}; look at the sensor, record again, and calibrate or fit anew. It is said once"
        ))
    }

    /// Returns the share that is unknown, and the mean confidence.
    fn means(&self) -> Option<(f64, f64)> {
        let count = self.last.len() as f64;
        let unknown = self.last.iter().filter(|(is_unknown, _)| *is_unknown).count() as f64;
        let sure: f64 = self.last.iter().map(|(_, sure)| sure).sum();
        (count > 0.0).then(|| (unknown / count, sure / count))
    }

    /// Returns the same for the summary.
    pub fn json(&self) -> Value {
        match self.means() {
            Some((unknown, sure)) => json!({
                "windows": self.last.len(), "unknown": unknown, "confidence": self.wanted.map(|_| sure),
                "confidence_when_fitted": self.wanted,
            }),
            None => Value::Null,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drift(decisions: impl Iterator<Item = (bool, f64)>) -> Option<String> {
        drift_of(Some(0.9), decisions)
    }

    fn drift_of(wanted: Option<f64>, decisions: impl Iterator<Item = (bool, f64)>) -> Option<String> {
        let mut drift = Drift { last: VecDeque::new(), wanted, is_watching: true, is_said: true };
        decisions.for_each(|(is_unknown, sure)| drift.push(is_unknown, sure));
        drift.words()
    }

    #[test]
    fn a_stream_drifts_where_too_much_is_unknown_or_unsure() {
        assert_eq!(drift((0..200).map(|i| (i % 10 == 0, 0.85))), None);
        // The last hundred count.
        assert!(
            drift((0..200).map(|i| (i > 180, 0.9))).is_some_and(|words| words.contains("19 of the last 100"))
        );
        assert_eq!(drift((0..200).map(|i| (i < 80, 0.9))), None);
        assert!(drift((0..100).map(|_| (false, 0.6))).is_some_and(|words| words.contains("60 % sure")));
        // Values have no confidence.
        assert_eq!(drift_of(None, (0..100).map(|i| (i > 90, 0.0))), None);
        assert!(
            drift_of(None, (0..100).map(|i| (i > 80, 0.0)))
                .is_some_and(|words| words.contains("19 of the last 100"))
        );
    }
}
