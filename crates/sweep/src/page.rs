//! The page of a sweep: how far it is, what its axes do, ranks over data sets, what is missing.

use std::path::{Path, PathBuf};

use maud::{Markup, html};
use taxel_judge::{Primary, Ranked};
use taxel_report::chart::Chart;
use taxel_report::files::{make, of_chart, of_table, slug, write};
use taxel_report::html::{chart, frame, table};
use taxel_report::numbers::digits;
use taxel_report::table::{Cell, Column, Table};

use crate::chart::{axis, name_of};
use crate::collected::{Axis, OpenTrial, Setting, Spread, Sweep};
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
    let tables = Tables {
        best: settings(&sweep.settings[..sweep.settings.len().min(MOST)]),
        axes: sweep.axes.iter().map(|own| (drawn(own), effect(own))).collect(),
        ranked: sweep.across.as_ref().map(Ranked::new),
        open: open(&sweep.open[..sweep.open.len().min(MOST)]),
    };
    make(&folder.join("tables"))?;
    make(&folder.join("charts"))?;
    let axes = tables.axes.iter().map(|(_, own)| own);
    let ranked = tables.ranked.iter().map(|own| &own.numbers);
    let all = tables.best.iter().chain([&tables.open]).chain(axes).chain(ranked);
    all.flat_map(of_table).try_for_each(|file| write(folder, &file))?;
    let charts = tables.axes.iter().filter_map(|(drawn, _)| drawn.as_ref());
    for own in charts.chain(tables.ranked.iter().map(|own| &own.drawn)) {
        of_chart(own)?.iter().try_for_each(|file| write(folder, file))?;
    }
    let page = "index.html";
    let html = frame(&format!("{}: sweep", sweep.name), &body(sweep, &tables)).into_string();
    write(folder, &(page.into(), html.into_bytes()))?;
    Ok(folder.join(page))
}

struct Tables<'a> {
    /// One for each metric.
    best: Vec<Table>,
    axes: Vec<(Option<Chart<'a>>, Table)>,
    ranked: Option<Ranked<'a>>,
    open: Table,
}

fn body(sweep: &Sweep, tables: &Tables) -> Markup {
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
            @if let Some(own) = &tables.ranked { (own.section()) }
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

/// What the axes show, at the beginning of a sentence.
fn scores(sweep: &Sweep) -> String {
    let first = sweep.axes.first().map(|axis| axis.primary.heading()).unwrap_or_default();
    let is_one = sweep.axes.iter().all(|axis| axis.primary.heading() == first);
    if is_one { first } else { "The primary metric".into() }
}

fn spread<R>(primary: &Primary, get: impl Fn(&R) -> &Spread + Copy + 'static) -> [Column<'static, R>; 4] {
    let (show, name) = (primary.show(), primary.column(""));
    [
        Column::number("trials", &["trials"], move |row| Cell::count(get(row).count as u64)),
        Column::number(&primary.head(), &[&name], move |row| Cell::number(Some(get(row).mean), show)),
        Column::number(
            &primary.head_of_loss("SD"),
            &[&primary.column_of_loss(&sd_of(primary))],
            move |row| Cell::number(get(row).sd, show),
        ),
        Column::number(
            &primary.head_of("least to most"),
            &[&format!("least_{name}"), &format!("most_{name}")],
            move |row| {
                let own = get(row);
                let shown = format!(" to {}", show(own.most));
                Cell::number(Some(own.least), show).and(shown, &[Some(own.most)])
            },
        ),
    ]
}

/// One table for each metric, in the order of the rows.
fn settings(rows: &[Setting]) -> Vec<Table> {
    let mut primaries: Vec<&Primary> = vec![];
    for own in rows {
        if !primaries.contains(&&own.primary) {
            primaries.push(&own.primary);
        }
    }
    let of =
        |primary: &&Primary| rows.iter().filter(|own| own.primary == **primary).cloned().collect::<Vec<_>>();
    match primaries.as_slice() {
        [] => vec![settings_of(&Primary::default(), &[])],
        some => some.iter().map(|primary| settings_of(primary, &of(primary))).collect(),
    }
}

fn settings_of(primary: &Primary, rows: &[Setting]) -> Table {
    let mut columns = vec![
        Column::text("on", "source", |own: &Setting| Cell::text(&own.source)),
        Column::text("network", "network", |own: &Setting| Cell::text(&own.network)),
        Column::text("with", "settings", |own: &Setting| Cell::text(&own.set)),
    ];
    columns.extend(spread(primary, |own: &Setting| &own.score));
    let caption = format!("Mean {} over seeds, the best of each data set first", primary.title());
    let name = match primary.is_accuracy() {
        true => "settings".into(),
        false => format!("settings-{}", slug(&primary.head())),
    };
    Table::new(name, caption, columns, rows)
}

fn effect(own: &Axis) -> Table {
    type Row = (String, String, Spread);
    let mut columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(&row.0)),
        Column::text(&own.key, "value", |row: &Row| Cell::text(&row.1)),
    ];
    columns.extend(spread(&own.primary, |row: &Row| &row.2));
    let caption = format!("{} by {}", own.primary.heading(), own.key);
    Table::new(name_of(own), caption, columns, &own.rows)
}

fn drawn(own: &Axis) -> Option<Chart<'_>> {
    (own.rows.len() <= DRAWN).then(|| axis(own))
}

fn open(rows: &[OpenTrial]) -> Table {
    let columns = vec![
        Column::number("trial", &["trial"], |own: &OpenTrial| Cell::count(own.number as u64)),
        Column::text("what", "what", |own: &OpenTrial| Cell::text(&own.trial)),
        Column::text("state", "state", |own: &OpenTrial| Cell::text(&own.state)),
        Column::text("because", "reason", |own: &OpenTrial| Cell::text(&own.reason)),
    ];
    Table::new("open", "Trials without a result".into(), columns, rows)
}
