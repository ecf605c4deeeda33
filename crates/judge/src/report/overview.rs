//! Several runs side by side.

use std::path::{Path, PathBuf};

use maud::html;

use super::html::{frame, table};
use super::page::badge;
use super::tables::{Cell, Column, Table};
use super::{refuse, write};
use crate::choice::Choice;
use crate::error::Result;
use crate::judgement::{Judgement, Kind};
use crate::report::numbers::{digits, tenth};

/// One run of an overview.
pub struct Entry {
    /// Where its page is, relative to the overview or absolute.
    pub page: String,
    /// What is known about it.
    pub judgement: Judgement,
    /// Its recommendation.
    pub choice: Option<Choice>,
}

impl Entry {
    /// The most accurate contestant: name, accuracy in %, latency in ms.
    fn best(&self) -> Option<(&str, f64, Option<f64>)> {
        let scored = self.judgement.networks.iter().filter_map(|n| {
            let accuracy = n.results.mean?.accuracy;
            Some((n.results.network.as_str(), accuracy, n.speed.map(|s| s.whole_p50_ms)))
        });
        scored.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn chosen(&self) -> Option<&str> {
        self.choice.as_ref()?.chosen.as_deref()
    }
}

/// Writes `index.html` below `folder`: one row per run, simulated and real ones apart. The path of the page.
///
/// # Errors
/// A file that cannot be written.
pub fn overview(entries: &[Entry], folder: &Path) -> Result<PathBuf> {
    std::fs::create_dir_all(folder).map_err(|e| refuse(folder, &e))?;
    let tables: Vec<(Kind, Table)> = [Kind::Simulated, Kind::Real]
        .into_iter()
        .map(|kind| (kind, side_by_side(entries, kind)))
        .filter(|(_, table)| !table.rows.is_empty())
        .collect();
    let body = html! {
        header {
            p.kicker { "taxel reports" }
            h1 { (entries.len()) " runs side by side" }
        }
        main id="main" {
            section aria-labelledby="pages-title" {
                h2 id="pages-title" { "Pages" }
                ul {
                    @for entry in entries {
                        li {
                            a href=(entry.page) { (entry.judgement.results.name) } " " (badge(entry.judgement.kind))
                            @if let Some(title) = &entry.judgement.results.title { " " (title) }
                        }
                    }
                }
            }
            @for (kind, own) in &tables {
                section {
                    h2 { (match kind { Kind::Simulated => "On simulated readings", Kind::Real => "On real readings" }) }
                    (table(own))
                }
            }
        }
    };
    for (_, own) in &tables {
        let below = folder.join("tables");
        std::fs::create_dir_all(&below).map_err(|e| refuse(&below, &e))?;
        write(&below.join(format!("{}.md", own.name)), own.markdown().as_bytes())?;
        write(&below.join(format!("{}.csv", own.name)), &own.csv()?)?;
    }
    let page = folder.join("index.html");
    write(&page, frame("taxel reports", &body).into_string().as_bytes())?;
    Ok(page)
}

fn side_by_side(entries: &[Entry], kind: Kind) -> Table {
    let rows: Vec<&Entry> = entries.iter().filter(|entry| entry.judgement.kind == kind).collect();
    let columns = vec![
        Column::text("run", "run", |e: &&Entry| Cell::text(&e.judgement.results.name)),
        Column::text("readings", "source", |e: &&Entry| Cell::text(&e.judgement.results.source)),
        Column::text("protocol", "protocol", |e: &&Entry| Cell::text(&e.judgement.protocol)),
        Column::number("samples", &["samples"], |e: &&Entry| Cell::count(e.judgement.results.samples as u64)),
        Column::number("chance %", &["chance_percent"], |e: &&Entry| {
            Cell::number(Some(e.judgement.chance), tenth)
        }),
        Column::text("recommended", "recommended", |e: &&Entry| Cell::text(e.chosen().unwrap_or("–"))),
        Column::text("most accurate", "best", |e: &&Entry| Cell::text(e.best().map_or("–", |best| best.0))),
        Column::number("its accuracy %", &["best_accuracy_percent"], |e: &&Entry| {
            Cell::number(e.best().map(|best| best.1), tenth)
        }),
        Column::number("its latency p50, ms", &["best_latency_p50_ms"], |e: &&Entry| {
            Cell::number(e.best().and_then(|best| best.2), digits)
        }),
    ];
    let (name, caption) = match kind {
        Kind::Simulated => ("overview-simulated", "Runs on simulated readings"),
        Kind::Real => ("overview-real", "Runs on real readings"),
    };
    Table::new(name, caption.into(), columns, &rows)
}
