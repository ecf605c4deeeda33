//! Networks ranked over data sets: what pages of several runs and of sweeps say of it.

use maud::{Markup, html};

use super::charts::{Chart, ranks};
use super::html::{chart, table};
use super::names::table as names;
use super::numbers::digits;
use super::tables::{Cell, Column, Table};
use crate::values::Across;

/// Ranks over data sets.
pub(super) struct Ranked<'a> {
    /// The critical-difference diagram.
    pub drawn: Chart<'a>,
    /// Mean ranks and tests against the best.
    pub numbers: Table,
    words: &'a [String],
}

impl<'a> Ranked<'a> {
    pub fn new(across: &'a Across) -> Self {
        Ranked { drawn: ranks(across), numbers: numbers(across), words: &across.words }
    }

    pub fn section(&self) -> Markup {
        html! {
            section {
                h2 { "Over all data sets" }
                @for line in self.words { p { (line) } }
                (chart(&self.drawn, &self.numbers.name))
                (table(&self.numbers))
            }
        }
    }
}

fn numbers(across: &Across) -> Table {
    let rows: Vec<usize> = (0..across.networks.len()).collect();
    let columns = vec![
        Column::text("network", "network", |&i: &usize| Cell::text(&across.networks[i])),
        Column::number("mean rank", &["mean_rank"], |&i: &usize| {
            Cell::number(across.friedman.ranks.get(i).copied(), digits)
        }),
        Column::number("p against the first (Wilcoxon, Holm)", &["p_holm"], |&i: &usize| {
            Cell::number(across.p_holm.get(i).copied().flatten(), digits)
        }),
    ];
    let caption = format!("Mean ranks over {} data sets", across.runs.len());
    Table::new(names::RANKS, caption, columns, &rows)
}
