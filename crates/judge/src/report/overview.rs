//! Several runs side by side.

use std::path::{Path, PathBuf};

use maud::{Markup, html};
use taxel_data::SourceKind;
use taxel_report::files::write_page;
use taxel_report::html::table;
use taxel_report::numbers::digits;
use taxel_report::table::{Cell, Column, Table};

use super::names::table as names;
use super::page::badge;
use super::ranked::Ranked;
use super::words::kind;
use crate::error::Result;
use crate::values::{Across, Choice, Judgement, Primary};

/// One run of an overview.
pub struct OverviewRun {
    /// Where its page is, relative to the overview or absolute.
    pub page: String,
    /// Its judgement.
    pub judgement: Judgement,
    /// Its recommendation.
    pub choice: Option<Choice>,
}

impl OverviewRun {
    /// Returns the most accurate network: name, primary metric, latency in ms.
    fn best(&self) -> Option<(&str, f64, Option<f64>)> {
        let scored =
            self.judgement.networks.iter().filter_map(|n| {
                Some((n.results.network.as_str(), n.score()?, n.speed.map(|s| s.whole.p50_ms)))
            });
        let primary = self.judgement.primary();
        scored.max_by(|a, b| primary.order(a.1, b.1))
    }

    fn chosen(&self) -> Option<&str> {
        self.choice.as_ref()?.chosen.as_deref()
    }
}

/// Writes `index.html` below `folder`: one row per run, simulated and real ones apart, and the ranks over data sets, where there are enough. The path of the page.
///
/// # Errors
/// A file that cannot be written.
pub fn overview(entries: &[OverviewRun], across: Option<&Across>, folder: &Path) -> Result<PathBuf> {
    let tables = OverviewTables {
        side: [SourceKind::Simulated, SourceKind::Real]
            .into_iter()
            .map(|kind| (kind, side_by_side(entries, kind)))
            .filter(|(_, table)| !table.rows.is_empty())
            .collect(),
        again: again(entries),
        ranked: across.map(Ranked::new),
    };
    let side = tables.side.iter().map(|(_, numbers)| numbers);
    let ranked = tables.ranked.iter().map(|ranked| &ranked.numbers);
    let every = side.chain(ranked).chain(&tables.again);
    let charts = tables.ranked.iter().map(|ranked| &ranked.drawn);
    Ok(write_page(folder, ("taxel reports", &body(entries, &tables)), every, charts)?)
}

/// Tables of an overview.
struct OverviewTables<'a> {
    /// Runs of one kind side by side.
    side: Vec<(SourceKind, Table)>,
    /// The same readings, divided or seeded otherwise.
    again: Vec<Table>,
    ranked: Option<Ranked<'a>>,
}

fn body(entries: &[OverviewRun], tables: &OverviewTables) -> Markup {
    html! {
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
                            a href=(entry.page) { (entry.judgement.results.name) } " "
                            (badge(entry.judgement.kind()))
                            @if let Some(title) = &entry.judgement.results.title { " " (title) }
                        }
                    }
                }
            }
            @for (source, numbers) in &tables.side {
                section {
                    h2 { "On " (kind(*source)) " readings" }
                    (table(numbers))
                }
            }
            @if !tables.again.is_empty() {
                section {
                    h2 { "The same readings, divided or seeded otherwise" }
                    p {
                        "What " (scores(entries)) " owes to the split (random folds put grasps of one session or object into training "
                        "and test alike) and to the seed."
                    }
                    @for numbers in &tables.again { (table(numbers)) }
                }
            }
            @if let Some(ranked) = &tables.ranked { (ranked.section()) }
        }
    }
}

fn side_by_side(entries: &[OverviewRun], of: SourceKind) -> Table {
    let rows: Vec<&OverviewRun> = entries.iter().filter(|entry| entry.judgement.kind() == of).collect();
    let primaries: Vec<Primary> = rows.iter().map(|entry| entry.judgement.primary()).collect();
    // One column for runs of one metric; of several each number names its own.
    let shared = primaries.first().cloned().filter(|first| primaries.iter().all(|primary| primary == first));
    let (chance, best) = match &shared {
        Some(primary) => (primary.head_of(primary.chance()), format!("its {}", primary.head())),
        None => ("chance".into(), "its score".into()),
    };
    let fields = match &shared {
        Some(primary) if primary.is_percent() => {
            ["chance_percent".into(), format!("best_{}", primary.column(""))]
        }
        Some(primary) => ["chance".into(), format!("best_{}", primary.column(""))],
        None => ["chance".into(), "best_score".into()],
    };
    let is_shared = shared.is_some();
    let scored = move |entry: &OverviewRun, score: Option<f64>| {
        let primary = entry.judgement.primary();
        Cell::number(score, |v| if is_shared { primary.show()(v) } else { primary.named_value(v) })
    };
    let columns = vec![
        Column::text("run", "run", |e: &&OverviewRun| Cell::text(&e.judgement.results.name)),
        Column::text("readings", "source", |e: &&OverviewRun| {
            Cell::text(e.judgement.results.source.to_string())
        }),
        Column::text("protocol", "protocol", |e: &&OverviewRun| Cell::text(&e.judgement.protocol)),
        Column::count("samples", "samples", |e: &&OverviewRun| e.judgement.results.samples as u64),
        Column::number(&chance, &[&fields[0]], move |e: &&OverviewRun| scored(e, Some(e.judgement.chance))),
        Column::text("recommended", "recommended", |e: &&OverviewRun| Cell::text(e.chosen().unwrap_or("–"))),
        Column::text("most accurate", "best", |e: &&OverviewRun| {
            Cell::text(e.best().map_or("–", |best| best.0))
        }),
        Column::number(&best, &[&fields[1]], move |e: &&OverviewRun| scored(e, e.best().map(|best| best.1))),
        Column::value("its latency p50, ms", "best_latency_p50_ms", digits, |e: &&OverviewRun| {
            e.best().and_then(|best| best.2)
        }),
    ];
    let name = match of {
        SourceKind::Simulated => names::OVERVIEW_SIMULATED,
        SourceKind::Real => names::OVERVIEW_REAL,
    };
    Table::new(name, format!("Runs on {} readings", kind(of)), columns, &rows)
}

/// Returns the name of the metric that the tables show, within a sentence.
fn scores(entries: &[OverviewRun]) -> &'static str {
    let mut titles = entries.iter().map(|entry| entry.judgement.primary().title());
    let first = titles.next().unwrap_or("accuracy");
    if titles.all(|title| title == first) { first } else { "the score" }
}

/// Returns one table for all runs on the same readings: the score of each network in each, and how far they lie apart.
fn again(entries: &[OverviewRun]) -> Vec<Table> {
    let mut groups: Vec<Vec<&Judgement>> = vec![];
    for judgement in entries.iter().map(|entry| &entry.judgement) {
        // Simulated readings differ with the seed; the scene and the number of samples are the same.
        let same = |group: &&mut Vec<&Judgement>| {
            let (a, b) = (&group[0].results, &judgement.results);
            (&a.source, a.samples, &a.task.output_names()) == (&b.source, b.samples, &b.task.output_names())
                && group[0].primary() == judgement.primary()
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(judgement),
            None => groups.push(vec![judgement]),
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
    let score = |run: &Judgement, name: &str| run.network(name)?.score();
    let primary = group[0].primary();
    let show = primary.show();
    let mut names: Vec<&str> = vec![];
    for network in group.iter().flat_map(|run| &run.networks) {
        let name = network.results.network.as_str();
        if !names.contains(&name) && group.iter().filter(|run| score(run, name).is_some()).count() > 1 {
            names.push(name);
        }
    }
    let mut columns: Vec<Column<&str>> =
        vec![Column::text("network", "network", |name: &&str| Cell::text(*name))];
    for (i, run) in group.iter().enumerate() {
        let unit = primary.unit();
        let head = format!("{}: {}, seed {}, {unit}", run.results.name, run.protocol, run.results.seed);
        let field = format!("run_{}_{}", i + 1, primary.column(""));
        columns.push(Column::value(&head, &field, show, move |name: &&str| score(run, name)));
    }
    let apart = if primary.is_percent() { "apart_pp" } else { "apart" };
    columns.push(Column::number(&primary.head_of_loss("apart"), &[apart], move |name: &&str| {
        let all = || group.iter().filter_map(|run| score(run, name));
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        Cell::number(Some(high - low), show)
    }));
    let results = &group[0].results;
    let (heading, samples) = (primary.heading(), results.samples);
    let caption = format!("{heading} on {} ({samples} samples), run by run", results.source);
    let name = format!("same-readings-{}", number + 1);
    let table = Table::new(name, caption, columns, &names);
    (!names.is_empty()).then_some(table)
}
