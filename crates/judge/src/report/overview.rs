//! Several runs side by side.

use std::path::{Path, PathBuf};

use maud::html;

use super::charts;
use super::html::{frame, table};
use super::page::badge;
use super::palette::Paint;
use super::tables::{self, Cell, Column, Table};
use super::{refuse, write};
use crate::across::Across;
use crate::choice::Choice;
use crate::claims::{Claim, Outcome};
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

/// Writes `index.html` below `folder`: one row per run, simulated and real ones apart, every claim of the
/// papers that some run can test, and the ranks over data sets, where there are enough. The path of the page.
///
/// # Errors
/// A file that cannot be written.
pub fn overview(
    entries: &[Entry],
    claims: &[Claim],
    across: Option<&Across>,
    folder: &Path,
) -> Result<PathBuf> {
    std::fs::create_dir_all(folder).map_err(|e| refuse(folder, &e))?;
    let side: Vec<(Kind, Table)> = [Kind::Simulated, Kind::Real]
        .into_iter()
        .map(|kind| (kind, side_by_side(entries, kind)))
        .filter(|(_, table)| !table.rows.is_empty())
        .collect();
    let ranks = across.map(|across| (charts::ranks(across), ranked(across), &across.words));
    let asked = asked(claims);
    let again = again(entries);
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
            @for (kind, own) in &side {
                section {
                    h2 { (match kind { Kind::Simulated => "On simulated readings", Kind::Real => "On real readings" }) }
                    (table(own))
                }
            }
            @if !again.is_empty() {
                section {
                    h2 { "The same readings, divided or seeded otherwise" }
                    p {
                        "What accuracy owes to the split (random folds put grasps of one session or object into training "
                        "and test alike) and to the seed."
                    }
                    @for own in &again { (table(own)) }
                }
            }
            @if let Some((chart, numbers, words)) = &ranks {
                section {
                    h2 { "Over all data sets" }
                    @for line in *words { p { (line) } }
                    (super::html::chart(chart, &numbers.name))
                    (table(numbers))
                }
            }
            @if let Some(asked) = &asked {
                section {
                    h2 { "Claims of the papers" }
                    p { "Only claims that some run here can test; effect sizes stand in the pages of the runs and in the file." }
                    (table(asked))
                }
            }
        }
    };
    let mut files: Vec<&Table> = side.iter().map(|(_, own)| own).collect();
    let all = tables::claims(claims);
    files.push(&all);
    files.extend(ranks.as_ref().map(|(_, numbers, _)| numbers));
    files.extend(&asked);
    files.extend(&again);
    if let Some((chart, ..)) = &ranks {
        let below = folder.join("charts");
        std::fs::create_dir_all(&below).map_err(|e| refuse(&below, &e))?;
        let label = format!("{}. {}", chart.title, chart.reading);
        for (name, bytes) in
            super::drawing(&format!("charts/{}", chart.name), &chart.canvas(Paint::Print), &label)?
        {
            write(&folder.join(name), &bytes)?;
        }
    }
    for own in files {
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

/// Claims that some run can test: what each run says.
fn asked(claims: &[Claim]) -> Option<Table> {
    let mut runs: Vec<(&str, Kind)> = vec![];
    let mut rows: Vec<Vec<&Claim>> = vec![];
    for claim in claims {
        if !runs.contains(&(&claim.run, claim.kind)) {
            runs.push((&claim.run, claim.kind));
        }
        let same = |row: &&mut Vec<&Claim>| {
            (&row[0].paper, &row[0].place, &row[0].says) == (&claim.paper, &claim.place, &claim.says)
        };
        match rows.iter_mut().find(same) {
            Some(row) => row.push(claim),
            None => rows.push(vec![claim]),
        }
    }
    rows.retain(|row| row.iter().any(|claim| claim.outcome != Outcome::CannotBeTested));
    if rows.is_empty() {
        return None;
    }
    let mut columns: Vec<Column<Vec<&Claim>>> = vec![
        Column::text("claim", "claim", |row: &Vec<&Claim>| Cell::text(&row[0].says)),
        Column::text("paper", "paper", |row: &Vec<&Claim>| Cell::text(&row[0].paper)),
        Column::text("printed in", "place", |row: &Vec<&Claim>| Cell::text(&row[0].place)),
    ];
    for (run, kind) in runs {
        let kind = match kind {
            Kind::Simulated => "simulated",
            Kind::Real => "real",
        };
        let name = run.to_string();
        columns.push(Column::text(&format!("{run} ({kind})"), run, move |row: &Vec<&Claim>| {
            let own = row.iter().find(|claim| claim.run == name);
            Cell::text(match own.map(|claim| claim.outcome) {
                Some(Outcome::Holds) => "holds",
                Some(Outcome::DoesNotHold) => "does not hold",
                Some(Outcome::CannotBeTested) | None => "–",
            })
        }));
    }
    Some(Table::new("claims-by-run", "What the papers claim, run by run".into(), columns, &rows))
}

/// Mean ranks and tests against the best.
fn ranked(across: &Across) -> Table {
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
    Table::new("ranks", caption, columns, &rows)
}

/// One table for all runs on the same readings: accuracy of each network in each, and how far they lie apart.
fn again(entries: &[Entry]) -> Vec<Table> {
    let mut groups: Vec<Vec<&Judgement>> = vec![];
    for own in entries.iter().map(|entry| &entry.judgement) {
        // Simulated readings differ with the seed; the scene and the number of samples are the same.
        let same = |group: &&mut Vec<&Judgement>| {
            let (a, b) = (&group[0].results, &own.results);
            (&a.source, a.samples, &a.classes) == (&b.source, b.samples, &b.classes)
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(own),
            None => groups.push(vec![own]),
        }
    }
    groups
        .iter()
        .filter(|group| group.len() > 1)
        .enumerate()
        .filter_map(|(i, group)| beside(i, group))
        .collect()
}

fn beside(number: usize, group: &[&Judgement]) -> Option<Table> {
    let accuracy = |run: &Judgement, name: &str| {
        let own = run.networks.iter().find(|n| n.results.network == name)?;
        own.results.mean.map(|mean| mean.accuracy)
    };
    let mut names: Vec<&str> = vec![];
    for network in group.iter().flat_map(|run| &run.networks) {
        let name = network.results.network.as_str();
        if !names.contains(&name) && group.iter().filter(|run| accuracy(run, name).is_some()).count() > 1 {
            names.push(name);
        }
    }
    let mut columns: Vec<Column<&str>> =
        vec![Column::text("network", "network", |name: &&str| Cell::text(*name))];
    for (i, run) in group.iter().enumerate() {
        let head = format!("{}: {}, seed {}, %", run.results.name, run.protocol, run.results.seed);
        let field = format!("run_{}_accuracy_percent", i + 1);
        columns.push(Column::number(&head, &[&field], move |name: &&str| {
            Cell::number(accuracy(run, name), tenth)
        }));
    }
    columns.push(Column::number("apart, pp", &["apart_pp"], |name: &&str| {
        let all = || group.iter().filter_map(|run| accuracy(run, name));
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        Cell::number(Some(high - low), tenth)
    }));
    let results = &group[0].results;
    let caption = format!("Accuracy on {} ({} samples), run by run", results.source, results.samples);
    let name = format!("same-readings-{}", number + 1);
    let table = Table::new(name, caption, columns, &names);
    (!names.is_empty()).then_some(table)
}
