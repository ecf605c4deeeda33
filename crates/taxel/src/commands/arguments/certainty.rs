//! Options for the certainty of a model: samples that are unknown to it, and sets of classes.

use clap::Args;
use taxel::Card;
use taxel::learn::certainty::{AnswerSet, FALSE_ALARMS};
use taxel::learn::metrics::Levels;

use crate::terminal::messages::warn;

/// The class of a sample that is unlike those that the model has learned from.
pub const UNKNOWN: &str = "unknown";
/// Share of cases in which an interval is to hold the true value.
pub const USUAL: f64 = 0.9;

/// Returns the set of classes of each attribute for a sample's `outputs`. That of an unknown sample is empty: no set of learned
/// classes can be believed to hold its own.
pub fn set_of(sets: &AnswerSet, outputs: &[f32], levels: &Levels, is_unknown: bool) -> Vec<Vec<usize>> {
    let mut classes = sets.classes(outputs, levels);
    if is_unknown {
        classes.iter_mut().for_each(Vec::clear);
    }
    classes
}

/// Says that sets or intervals of a share of samples cannot be promised for a new group; none where they can, or where there are none.
pub fn unpromised(card: &Card, share: f64) -> Option<String> {
    let of_sets = card.certainty.as_ref().map(|certainty| &certainty.fitted_on);
    let of_intervals = card.intervals.as_ref().map(|intervals| &intervals.fitted_on);
    let (kind, fitted_on) =
        if card.task.quantities().is_empty() { ("sets", of_sets) } else { ("intervals", of_intervals) };
    let words = fitted_on?.unpromised(share)?;
    Some(format!(
        "{} of {}: {words}; what they covered on the groups there are is what was seen",
        kind, card.name
    ))
}

/// `--unknown` and `--set`.
#[derive(Args, Clone, Copy)]
pub struct CertaintyOptions {
    /// Says `unknown` for samples that are less familiar than this share of held-out samples, in place of their likeliest class; 0
    /// never does [default: 0.05 where the model knows what is familiar].
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    unknown: Option<f32>,
    /// Adds the set of classes that holds the true one in this share of cases: 0.8, 0.9, 0.95 or 0.99. Of values, the share of
    /// cases in which their interval holds the true one [default: 0.9].
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    set: Option<f64>,
}

impl CertaintyOptions {
    /// Returns the familiarity up to which a sample is unknown, and the sets; refuses what the model does not have.
    pub fn of(&self, card: &Card) -> Result<(f32, Option<AnswerSet>), String> {
        self.set.and_then(|share| unpromised(card, share)).iter().for_each(warn);
        let certainty = card.certainty.as_ref();
        let has_gate = card.has_gate();
        let how = "fit it from a run folder, or calibrate it on own recordings (taxel calibrate)";
        let limit = match self.unknown {
            Some(share) if !(0.0..1.0).contains(&share) => {
                return Err(format!("--unknown {share}: is a share from 0 and below 1, as 0.05"));
            }
            Some(share) if share > 0.0 && !has_gate => {
                return Err(format!(
                    "--unknown {share}: {} does not know which samples are familiar; {how}",
                    card.name
                ));
            }
            Some(share) => share,
            None if has_gate => FALSE_ALARMS,
            None => 0.0,
        };
        let sets = match self.set.filter(|_| card.task.quantities().is_empty()) {
            None => None,
            Some(share) => match certainty.map(|certainty| (certainty, certainty.sets_at(share))) {
                Some((_, Some(sets))) => Some(sets.clone()),
                Some((certainty, None)) if !certainty.sets.is_empty() => {
                    return Err(format!("--set {share}: sets are made for 0.8, 0.9, 0.95 and 0.99"));
                }
                _ => return Err(format!("--set {share}: {} is not calibrated; {how}", card.name)),
            },
        };
        Ok((limit, sets))
    }

    /// Returns the share of cases in which the intervals of values are to hold the true one; none of classes, and of a model
    /// without intervals. Refuses a share that the model does not have.
    pub fn interval(&self, card: &Card) -> Result<Option<f64>, String> {
        if card.task.quantities().is_empty() {
            return Ok(None);
        }
        let shares: Vec<f64> = card.intervals.iter().flat_map(|all| &all.at).map(|at| at.share).collect();
        match self.set {
            None => Ok(shares.contains(&USUAL).then_some(USUAL)),
            Some(share) if shares.contains(&share) => Ok(Some(share)),
            Some(share) if shares.is_empty() => Err(format!(
                "--set {share}: {} has no intervals; fit it from a run folder (taxel fit RUN)",
                card.name
            )),
            Some(share) => {
                let shares: Vec<String> = shares.iter().map(f64::to_string).collect();
                Err(format!("--set {share}: {} has intervals for {}", card.name, shares.join(", ")))
            }
        }
    }
}
