//! The page of a sweep: how far it is, what its axes do, ranks over data sets, what is missing.

use std::path::{Path, PathBuf};

use maud::{Markup, html};
use taxel_judge::{Primary, Ranked};
use taxel_report::chart::Chart;
use taxel_report::files::{slug, write_page};
use taxel_report::html::{chart, table};
use taxel_report::numbers::digits;
use taxel_report::table::{Cell, Column, Table};

use crate::chart::{axis, name_of};
use crate::collected::{KeyEffect, OpenTrial, ScoreSpread, Setting, Sweep};
use crate::error::Result;
use crate::record::sd_of;

/// Rows of the tables of a page; the files that a sweep writes beside it have all.
const MOST: usize = 200;
/// Rows up to which an axis is drawn.
const DRAWN: usize = 60;

/// Writes `index.html` below `folder`, with its tables and charts as files. The path of the page.
///
/// # Errors
/// A file that cannot be written.
pub fn sweep_page(sweep: &Sweep, folder: &Path) -> Result<PathBuf> {
    let tables = PageTables {
        best: settings(&sweep.settings[..sweep.settings.len().min(MOST)]),
        axes: sweep.axes.iter().map(|axis| (drawn(axis), effect(axis))).collect(),
        ranked: sweep.across.as_ref().map(Ranked::new),
        open: open(&sweep.open[..sweep.open.len().min(MOST)]),
    };
    let axes = tables.axes.iter().map(|(_, numbers)| numbers);
    let ranked = tables.ranked.iter().map(|ranked| &ranked.numbers);
    let all = tables.best.iter().chain([&tables.open]).chain(axes).chain(ranked);
    let drawn = tables.axes.iter().filter_map(|(drawn, _)| drawn.as_ref());
    let charts = drawn.chain(tables.ranked.iter().map(|ranked| &ranked.drawn));
    Ok(write_page(folder, (&format!("{}: sweep", sweep.name), &body(sweep, &tables)), all, charts)?)
}

struct PageTables<'a> {
    /// One for each metric.
    best: Vec<Table>,
    axes: Vec<(Option<Chart<'a>>, Table)>,
    ranked: Option<Ranked<'a>>,
    open: Table,
}

fn body(sweep: &Sweep, tables: &PageTables) -> Markup {
    let progress = &sweep.progress;
    html! {
        header {
            p.kicker { "taxel sweep" }
            h1 { (sweep.name) ": " (progress.finished) " of " (progress.planned) " trials" }
        }
        main id="main" {
            section {
                p {
                    (progress.finished) " finished, " (progress.failed) " failed, " (progress.begun) " begun, "
                    (progress.missing) " missing; " (digits(progress.seconds / 3600.0)) " h of work so far."
                }
                @for note in &sweep.notes { p { (note) } }
            }
            @if !sweep.settings.is_empty() {
                section {
                    h2 { "Networks and settings" }
                    @if sweep.settings.len() > MOST {
                        p { "The first " (MOST) " of " (sweep.settings.len()) "; all are in scores.csv." }
                    }
                    @for best in &tables.best { (table(best)) }
                }
            }
            @if !tables.axes.is_empty() {
                section {
                    h2 { "What each key does" }
                    p { (scores(sweep)) " for each value of one key, over all trials that have it." }
                    @for (drawn, numbers) in &tables.axes {
                        @if let Some(drawn) = drawn { (chart(drawn, &numbers.name)) }
                        (table(numbers))
                    }
                }
            }
            @if let Some(ranked) = &tables.ranked { (ranked.section()) }
            @if !tables.open.rows.is_empty() {
                section {
                    h2 { "Without a result" }
                    @if progress.open() > tables.open.rows.len() {
                        p {
                            "The first " (tables.open.rows.len()) " of " (progress.open())
                            ", failed ones before others; all are in trials.csv."
                        }
                    }
                    (table(&tables.open))
                }
            }
        }
    }
}

/// Returns the name of the metric that the charts show, at the beginning of a sentence.
fn scores(sweep: &Sweep) -> String {
    let first = sweep.axes.first().map(|axis| axis.primary.heading()).unwrap_or_default();
    let is_one = sweep.axes.iter().all(|axis| axis.primary.heading() == first);
    if is_one { first } else { "The primary metric".into() }
}

fn spread<R>(
    primary: &Primary,
    get: impl Fn(&R) -> &ScoreSpread + Copy + 'static,
) -> [Column<'static, R>; 4] {
    let (show, name) = (primary.show(), primary.column(""));
    [
        Column::count("trials", "trials", move |row| get(row).count as u64),
        Column::value(&primary.head(), &name, show, move |row| Some(get(row).mean)),
        Column::value(
            &primary.head_of_loss("SD"),
            &primary.column_of_loss(&sd_of(primary)),
            show,
            move |row| get(row).sd,
        ),
        Column::number(
            &primary.head_of("least to most"),
            &[&format!("least_{name}"), &format!("most_{name}")],
            move |row| {
                let score = get(row);
                let shown = format!(" to {}", show(score.most));
                Cell::number(Some(score.least), show).and(shown, &[Some(score.most)])
            },
        ),
    ]
}

/// Returns one table for each metric, in the order of the rows.
fn settings(rows: &[Setting]) -> Vec<Table> {
    let mut primaries: Vec<&Primary> = vec![];
    for row in rows {
        if !primaries.contains(&&row.primary) {
            primaries.push(&row.primary);
        }
    }
    let of =
        |primary: &&Primary| rows.iter().filter(|row| row.primary == **primary).cloned().collect::<Vec<_>>();
    match primaries.as_slice() {
        [] => vec![settings_of(&Primary::default(), &[])],
        some => some.iter().map(|primary| settings_of(primary, &of(primary))).collect(),
    }
}

fn settings_of(primary: &Primary, rows: &[Setting]) -> Table {
    let mut columns = vec![
        Column::text("on", "source", |setting: &Setting| Cell::text(&setting.source)),
        Column::text("network", "network", |setting: &Setting| Cell::text(&setting.network)),
        Column::text("with", "settings", |setting: &Setting| Cell::text(&setting.set)),
    ];
    columns.extend(spread(primary, |setting: &Setting| &setting.score));
    let caption = format!("Mean {} over seeds, the best of each data set first", primary.title());
    let name =
        if primary.is_accuracy() { "settings".into() } else { format!("settings-{}", slug(&primary.head())) };
    Table::new(name, caption, columns, rows)
}

fn effect(axis: &KeyEffect) -> Table {
    type Row = (String, String, ScoreSpread);
    let mut columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(&row.0)),
        Column::text(&axis.key, "value", |row: &Row| Cell::text(&row.1)),
    ];
    columns.extend(spread(&axis.primary, |row: &Row| &row.2));
    let caption = format!("{} by {}", axis.primary.heading(), axis.key);
    Table::new(name_of(axis), caption, columns, &axis.rows)
}

fn drawn(varied: &KeyEffect) -> Option<Chart<'_>> {
    (varied.rows.len() <= DRAWN).then(|| axis(varied))
}

fn open(rows: &[OpenTrial]) -> Table {
    let columns = vec![
        Column::count("trial", "trial", |open: &OpenTrial| open.number as u64),
        Column::text("what", "what", |open: &OpenTrial| Cell::text(&open.trial)),
        Column::text("state", "state", |open: &OpenTrial| Cell::text(&open.state)),
        Column::text("because", "reason", |open: &OpenTrial| Cell::text(&open.reason)),
    ];
    Table::new("open", "Trials without a result".into(), columns, rows)
}
