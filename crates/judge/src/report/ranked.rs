//! Networks ranked over data sets: what pages of several runs and of sweeps say of it.

use maud::{Markup, html};
use taxel_report::chart::Chart;
use taxel_report::html::{chart, table};
use taxel_report::numbers::digits;
use taxel_report::table::{Cell, Column, Table};

use super::charts::ranks;
use super::names::table as names;
use crate::values::Across;

/// Ranks over data sets.
pub struct Ranked<'a> {
    /// The critical-difference diagram.
    pub drawn: Chart<'a>,
    /// Mean ranks and tests against the best.
    pub numbers: Table,
    words: &'a [String],
}

impl<'a> Ranked<'a> {
    /// Draws the ranks and lists them.
    pub fn new(across: &'a Across) -> Self {
        Ranked { drawn: ranks(across), numbers: numbers(across), words: &across.words }
    }

    /// Returns the section of a page.
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
        Column::value("mean rank", "mean_rank", digits, |&i: &usize| across.friedman.ranks.get(i).copied()),
        Column::value("p against the first (Wilcoxon, Holm)", "p_holm", digits, |&i: &usize| {
            across.p_holm.get(i).copied().flatten()
        }),
    ];
    let caption = format!("Mean ranks over {} data sets", across.runs.len());
    Table::new(names::RANKS, caption, columns, &rows)
}
