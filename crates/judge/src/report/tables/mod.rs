//! The tables of a report.

mod certainty;
mod costs;
mod early;
mod eight_bits;
mod errors;
mod evidence;
mod faults;
mod guard;
mod hardening;
mod importance;
mod scores;

pub(super) use scores::networks;

use taxel_report::table::Table;

use crate::error::Result;
use crate::values::{Choice, Judgement};

/// Returns every table of a report that has rows.
///
/// # Errors
/// Losses that are not finite.
pub(super) fn tables(judgement: &Judgement, choice: Option<&Choice>) -> Result<Vec<Table>> {
    let mut all = vec![networks(judgement, choice)];
    all.extend(choice.map(evidence::choice));
    all.extend([
        scores::published(judgement),
        costs::speed(judgement),
        costs::size(judgement),
        scores::attributes(judgement),
        scores::folds(judgement),
        scores::classes(judgement),
        scores::confusion(judgement),
        scores::few_samples(judgement),
        costs::training(judgement),
        costs::weight_changes(judgement),
        evidence::examples(judgement),
    ]);
    if let Some(stress) = &judgement.stress {
        all.extend([
            faults::breaking_points(stress),
            faults::losses(stress),
            faults::curves(stress),
            faults::kinds(stress),
            guard::guard(stress),
            certainty::unknown(stress),
            certainty::sure(stress),
        ]);
    }
    let primary = judgement.primary();
    all.push(eight_bits::eight_bits(&primary, &crate::decide::eight_bits(judgement)));
    let hardened = crate::decide::hardening(judgement)?;
    all.extend([hardening::hardening(&primary, &hardened), hardening::unseen(&primary, &hardened)]);
    if let Some(early) = &judgement.early {
        all.extend([early::shares(&primary, early), early::decisions(early)]);
    }
    all.extend(judgement.importance.as_ref().map(|found| importance::parts(&primary, found)));
    all.push(certainty::certainty(&judgement.certainty));
    let groups = judgement.networks.iter().filter_map(|network| network.results.interval_groups).max();
    all.push(errors::errors(&judgement.errors, groups));
    all.retain(|table| !table.rows.is_empty());
    Ok(all)
}
