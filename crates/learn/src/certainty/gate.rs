//! Whether a sample is like those that a model has learned from, by its logits and its readings.

use ndarray::{ArrayRef, IxDyn};
use taxel_data::Layout;

use crate::certainty::fitted::{Certainty, HeldOutParts};
use crate::certainty::held_out::HeldOut;
use crate::certainty::readings::{HeldReadings, Readings};
use crate::certainty::seen::RANKS;
use crate::metrics::Levels;

/// Parts that samples or groups are divided into, each held out from the others.
const PARTS: u32 = 5;

impl Certainty {
    /// Fits the gate of readings to the held-out samples, rows of the raw samples `x` `[n, ..]` of that layout. What has too few samples is left out.
    /// Follows [`Certainty::with_logits`].
    pub fn with_readings(
        self,
        held: &HeldOut,
        (layout, x): (Layout, &ArrayRef<f32, IxDyn>),
        levels: &Levels,
    ) -> Self {
        let held = &held.divided();
        let x = x.as_standard_layout();
        let (shape, values) = (x.shape().get(1..).unwrap_or_default(), x.as_slice().unwrap_or_default());
        let each = shape.iter().product::<usize>();
        let samples = held.rows.iter().map(|row| values.get(row * each..(row + 1) * each));
        let Some(samples) = samples.collect::<Option<Vec<_>>>().filter(|_| each > 0) else { return self };
        let keeps_groups = self.fitted_on.parts == HeldOutParts::Groups;
        let groups = held.groups.clone().filter(|_| keeps_groups);
        let apart = match groups.filter(|groups| groups.iter().any(|group| *group != groups[0])) {
            Some(groups) => groups.iter().map(|group| group % PARTS).collect(),
            None => held.rows.iter().map(|row| *row as u32 % PARTS).collect(),
        };
        let fitted = Readings::fit(&HeldReadings { of: (layout, shape), samples, apart });
        let Some((gate, distances)) = fitted else { return self };
        let by_logits = self.seen.as_ref().and_then(|seen| seen.ranks_of(held, levels));
        let readings = match by_logits {
            Some(ranks) => gate.with_logits(&ranks, &distances),
            None => gate,
        };
        Certainty { readings: Some(readings), ..self }
    }

    /// Checks whether the model tells samples that are unlike those that it has learned.
    pub fn has_gate(&self) -> bool {
        self.seen.is_some() || self.readings.is_some()
    }

    /// Returns the familiarity of a sample by its `logits`, none of methods without any, and the summary of its readings: the share
    /// of held-out samples that are at least as unlike what was learned, 0.01..1. Of a beginning, of which the share `seen` is
    /// there, logits alone tell. None where nothing was fitted. Nothing is allocated once `scratch` has room.
    pub(crate) fn familiarity(
        &self,
        logits: Option<&[f32]>,
        summary: Option<&[f64]>,
        seen: f64,
        scratch: &mut Vec<f64>,
    ) -> Option<f32> {
        let rank = logits.and_then(|logits| self.seen.as_ref()?.rank(logits, seen, scratch));
        match (&self.readings, summary) {
            (Some(readings), Some(summary)) if seen >= 1.0 => Some(readings.familiarity(rank, summary)),
            _ => rank.map(|rank| rank as f32 / RANKS as f32),
        }
    }
}
