//! Whether a sample is like those that a model has learned from, by its logits and its readings.

use ndarray::{ArrayRef, IxDyn};
use taxel_data::Layout;

use crate::certainty::fitted::{Certainty, HeldOutParts};
use crate::certainty::held_out::HeldOut;
use crate::certainty::place::Place;
use crate::certainty::readings::Readings;
use crate::certainty::seen::{RANKS, Seen};
use crate::certainty::summary::Summary;
use crate::metrics::Levels;

/// Parts that samples or groups are divided into, each held out from the others.
const PARTS: u32 = 5;

/// Divides samples, positions in a data set, into parts: their `groups` stay together where there are several.
fn apart(rows: &[usize], groups: Option<&[u32]>) -> Vec<u32> {
    match groups.filter(|groups| groups.iter().any(|group| *group != groups[0])) {
        Some(groups) => groups.iter().map(|group| group % PARTS).collect(),
        None => rows.iter().map(|row| *row as u32 % PARTS).collect(),
    }
}

/// Both gates of a model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gates {
    /// Of logits; none of methods without any.
    pub seen: Option<Seen>,
    /// Of readings.
    pub readings: Option<Readings>,
}

impl Gates {
    /// Fits both to held-out samples, rows of the raw samples `x` `[n, ..]` of that layout; where a split keeps groups together,
    /// `keeps_groups`. What has too few samples is left out. Logits are measured from `own`, the places of the model that gets the gates, where
    /// logits of two trainings do not lie in the same place.
    pub fn fit(
        held: &HeldOut,
        raw: (Layout, &ArrayRef<f32, IxDyn>),
        levels: &Levels,
        keeps_groups: bool,
        own: Option<&Vec<Place>>,
    ) -> Self {
        let held = &held.divided();
        let seen = Seen::fit(held, levels);
        let readings = Self::readings(held, seen.as_ref(), raw, levels, keeps_groups);
        let placed = |seen: Seen| match (seen.places.is_empty(), own) {
            (true, own) => Some(Seen { places: own?.clone(), ..seen }),
            (false, _) => Some(seen),
        };
        Gates { seen: seen.and_then(placed), readings }
    }

    /// Fits the gate of readings alone to `rows` of the raw samples `x` `[n, ..]` of that layout, whose `groups` are kept together.
    pub fn of_readings(rows: &[usize], groups: Option<&[u32]>, raw: (Layout, &ArrayRef<f32, IxDyn>)) -> Self {
        let fitted = Readings::of_rows(rows, &apart(rows, groups), raw);
        Gates { seen: None, readings: fitted.map(|(gate, _)| gate) }
    }

    /// Fits the gate of readings beside that of logits.
    fn readings(
        held: &HeldOut,
        seen: Option<&Seen>,
        raw: (Layout, &ArrayRef<f32, IxDyn>),
        levels: &Levels,
        keeps_groups: bool,
    ) -> Option<Readings> {
        let groups = held.groups.as_deref().filter(|_| keeps_groups);
        let (gate, distances) = Readings::of_rows(&held.rows, &apart(&held.rows, groups), raw)?;
        let by_logits = seen.and_then(|seen| seen.ranks_of(held, levels));
        Some(match by_logits {
            Some(ranks) => gate.with_logits(&ranks, &distances),
            None => gate,
        })
    }

    /// Returns the familiarity of each of the raw samples `x` `[n, ..]` of that layout, whose `logits` `[n, outputs]` are those of a model;
    /// empty where it gives none. Nothing without a gate.
    pub fn familiarities(
        &self,
        logits: &[f32],
        (layout, x): (Layout, &ArrayRef<f32, IxDyn>),
    ) -> Option<Vec<f32>> {
        let x = x.as_standard_layout();
        let (shape, values) = (x.shape(), x.as_slice()?);
        let (n, each) = (*shape.first()?, shape[1..].iter().product::<usize>());
        let width = logits.len() / n.max(1);
        let mut summary = self.readings.as_ref().map(|gate| (Summary::new(layout, &shape[1..]), gate.range));
        let mut scratch = vec![];
        let mut of_sample = |at: usize| {
            let logits = logits.get(at * width..(at + 1) * width).filter(|logits| !logits.is_empty());
            let sample = &values[at * each..(at + 1) * each];
            let summary = summary.as_mut().map(|(summary, range)| summary.of(sample, *range));
            familiarity(self.seen.as_ref(), self.readings.as_ref(), logits, summary, 1.0, &mut scratch)
        };
        (0..n).map(&mut of_sample).collect()
    }
}

/// Returns the familiarity of a sample by both gates, as far as they are there, from its `logits`, none of methods without any, and the
/// summary of its readings: the share of held-out samples that are at least as unlike what was learned, 0.01..1. Of a beginning, of which
/// the `share` is there, logits alone tell. Nothing is allocated once `scratch` has room.
pub(crate) fn familiarity(
    seen: Option<&Seen>,
    readings: Option<&Readings>,
    logits: Option<&[f32]>,
    summary: Option<&[f32]>,
    share: f64,
    scratch: &mut Vec<f64>,
) -> Option<f32> {
    let rank = logits.and_then(|logits| seen?.rank(logits, share, scratch));
    match (readings, summary) {
        (Some(readings), Some(summary)) if share >= 1.0 => Some(readings.familiarity(rank, summary)),
        _ => rank.map(|rank| rank as f32 / RANKS as f32),
    }
}

impl Certainty {
    /// Fits the gate of readings to the held-out samples, rows of the raw samples `x` `[n, ..]` of that layout. What has too few
    /// samples is left out. Follows [`Certainty::with_logits`].
    pub fn with_readings(
        self,
        held: &HeldOut,
        raw: (Layout, &ArrayRef<f32, IxDyn>),
        levels: &Levels,
    ) -> Self {
        let keeps_groups = self.fitted_on.parts == HeldOutParts::Groups;
        let fitted = Gates::readings(&held.divided(), self.seen.as_ref(), raw, levels, keeps_groups);
        let Some(readings) = fitted else { return self };
        Certainty { readings: Some(readings), ..self }
    }

    /// Checks whether the model tells samples that are unlike those that it has learned.
    pub fn has_gate(&self) -> bool {
        self.seen.is_some() || self.readings.is_some()
    }
}
