//! The tables of a report.

mod costs;
mod evidence;
mod faults;
mod scores;
mod table;

pub(super) use evidence::claims;
pub(super) use scores::networks;
pub(super) use table::{Cell, Column, Table};

use crate::values::{Choice, Claim, Judgement};

/// Every table of a report that has rows.
pub(super) fn tables(judgement: &Judgement, choice: Option<&Choice>, claims: &[Claim]) -> Vec<Table> {
    let mut all = vec![networks(judgement, choice)];
    all.extend(choice.map(evidence::choice));
    all.extend([
        evidence::claims(claims),
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
        ]);
    }
    all.retain(|table| !table.rows.is_empty());
    all
}
