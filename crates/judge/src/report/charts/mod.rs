//! The charts of a report.

mod bars;
mod certainty;
mod confusion;
mod curves;
mod early;
mod errors;
mod faults;
mod importance;
mod learning;
mod look;
mod ranks;
mod survey;
mod tradeoff;

pub(super) use ranks::ranks;
pub(super) use survey::{CHANNELS, carrier, drift, lengths, ranges};

use taxel_report::chart::Chart;

use crate::values::{Choice, Judgement};

/// Returns every chart that there is something to draw for.
pub(super) fn charts<'a>(judgement: &'a Judgement, choice: Option<&'a Choice>) -> Vec<Chart<'a>> {
    let mut all = tradeoff::charts(judgement, choice);
    all.extend(bars::times(judgement));
    all.extend(faults::curves(judgement));
    all.extend(faults::heat(judgement));
    all.extend(bars::calibration(judgement));
    all.extend(early::shares(judgement));
    all.extend(certainty::reliability(judgement));
    all.extend(certainty::surest(judgement));
    all.extend(errors::scatters(judgement));
    all.extend(importance::parts(judgement));
    all.extend(curves::training(judgement));
    all.extend(curves::few_samples(judgement));
    all.extend(learning::curve(judgement));
    all.extend(confusion::charts(judgement));
    all.extend(bars::weight_changes(judgement));
    all
}
