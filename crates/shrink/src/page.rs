//! The page that says how little of the sensing and of a network suffices.

use std::path::{Path, PathBuf};

use maud::{Markup, html};
use taxel_judge::{Contrast, Primary};
use taxel_report::chart::Chart;
use taxel_report::files::{make, of_chart, of_table, slug, write};
use taxel_report::html::{chart, frame, table};
use taxel_report::numbers::{bytes, digits, si, tick};
use taxel_report::table::{Cell, Column, Table};

use crate::chart::{between, curve};
use crate::error::Result;
use crate::shrunk::{Curve, Rung, Shrunk, Small, SmallSpeed};
use crate::words::margin_words;

/// Writes `index.html` below `folder`, with its tables and charts as files, the page last. The path of the page.
///
/// # Errors
/// A file that cannot be written.
pub fn shrunk_page(shrunk: &Shrunk, speed: Option<&SmallSpeed>, folder: &Path) -> Result<PathBuf> {
    let drawn: Vec<(Chart, Table)> =
        shrunk.curves.iter().map(|own| (curve(own, shrunk), settings(own, shrunk))).collect();
    let models = models(&shrunk.primary, &shrunk.models, speed);
    for part in ["tables", "charts"] {
        make(&folder.join(part))?;
    }
    for (chart, table) in &drawn {
        of_chart(chart)?.iter().try_for_each(|file| write(folder, file))?;
        of_table(table).iter().try_for_each(|file| write(folder, file))?;
    }
    of_table(&models).iter().try_for_each(|file| write(folder, file))?;
    let title = format!("{}: what {} needs", shrunk.run, shrunk.network);
    let page = frame(&title, &body(shrunk, &drawn, &models)).into_string();
    write(folder, &("index.html".into(), page.into_bytes()))?;
    Ok(folder.join("index.html"))
}

fn body(shrunk: &Shrunk, drawn: &[(Chart, Table)], models: &Table) -> Markup {
    let (primary, (whole, interval)) = (&shrunk.primary, shrunk.whole);
    let title = if primary.is_percent() { "" } else { primary.title() };
    html! {
        header {
            p.kicker { "taxel shrink" }
            h1 { (shrunk.run) ": how little " (shrunk.network) " needs" }
            p {
                (shrunk.source) ", " (shrunk.samples) " samples, " (shrunk.protocol) ". The whole has "
                (format!("{title} {}", primary.value(whole)).trim_start()) (between(primary, interval)) " on " (shrunk.parts) " test parts."
            }
            @for note in &shrunk.notes { p.warning role="note" { (note) } }
        }
        main id="main" {
            section id="result" {
                h2 { "The result" }
                ul { @for words in &shrunk.words { li { (words) } } }
                p.reading {
                    "A setting suffices if it is not significantly worse than the whole at " (tick(shrunk.alpha))
                    " (corrected for the settings of its curve) and seems to lose no more than "
                    (margin_words(primary, shrunk.margin)) ", both on " (shrunk.inner) " inner folds of each training part. The test parts are asked once for each \
                    setting and choose nothing: their numbers are what a user may expect."
                }
            }
            @if !models.rows.is_empty() {
                section id="model" {
                    h2 { "The smaller model" }
                    (table(models))
                    @if let Some(own) = &shrunk.combined {
                        @for words in &own.loosened { p { (words) } }
                    }
                    p {
                        code { "shrunk.safetensors" } " takes whole recordings and leaves aside what it does not read; "
                        code { "shrunk.toml" } " is its experiment."
                    }
                }
            }
            @for (own, (drawn, numbers)) in shrunk.curves.iter().zip(drawn) {
                section id=(slug(&own.axis)) {
                    h2 { (own.title) }
                    p { (own.words) }
                    (chart(drawn, &numbers.name))
                    (table(numbers))
                }
            }
            @if !shrunk.left_out.is_empty() {
                section id="left-out" {
                    h2 { "Left out" }
                    ul { @for (axis, reason) in &shrunk.left_out { li { (axis) ": " (reason) } } }
                }
            }
        }
    }
}

/// The bounds of an interval, for a table's file.
fn ends(own: Option<[f64; 2]>) -> [Option<f64>; 2] {
    own.map_or([None, None], |both| both.map(Some))
}

/// Columns of a contrast: `on` is where it was measured.
fn columns(
    primary: &Primary,
    on: &str,
    key: &str,
    get: fn(&Rung) -> Option<Contrast>,
) -> Vec<Column<'static, Rung>> {
    let field = |name: String| format!("{key}_{name}");
    let [score, low, high] = ["", "low", "high"].map(|what| field(primary.column(what)));
    let [difference, least, most] =
        ["difference", "difference_low", "difference_high"].map(|name| field(primary.column_of_loss(name)));
    let (head, show, primary) = (primary.head_of(on), primary.show(), primary.clone());
    let shown = move |interval| between(&primary, interval);
    let also = shown.clone();
    vec![
        Column::number(&head, &[&score, &low, &high], move |rung: &Rung| {
            let own = get(rung);
            let interval = own.and_then(|own| own.score_interval);
            Cell::number(own.map(|own| own.score), show).and(shown(interval), &ends(interval))
        }),
        Column::number("against the whole", &[&difference, &least, &most], move |rung: &Rung| {
            let own = get(rung);
            let interval = own.and_then(|own| own.interval);
            Cell::number(own.map(|own| own.difference), show).and(also(interval), &ends(interval))
        }),
    ]
}

fn settings(own: &Curve, shrunk: &Shrunk) -> Table {
    let (primary, margin) = (&shrunk.primary, shrunk.margin);
    let mut all = vec![Column::text("left", "left", |rung: &Rung| Cell::text(&rung.label))];
    all.extend(columns(primary, "test parts", "test", |rung| rung.outer));
    all.extend(columns(primary, "inner folds", "inner", |rung| rung.inner));
    all.push(Column::number("p (Holm), inner", &["inner_p_holm"], |rung: &Rung| {
        Cell::number(rung.inner.and_then(|own| own.p_holm), |p| {
            if p < 0.001 { "< 0.001".into() } else { format!("{p:.3}") }
        })
    }));
    all.push(Column::text("", "verdict", move |rung: &Rung| {
        Cell::text(match (&rung.refused, rung.inner) {
            (Some(reason), _) => reason.clone(),
            (None, Some(inner)) if inner.worse => "worse".into(),
            (None, Some(inner)) if inner.suffices(margin, primary) => "suffices".into(),
            (None, Some(_)) => "loses too much".into(),
            (None, None) => "not tried".into(),
        })
    }));
    all.push(Column::text("kept, by fold", "kept", |rung: &Rung| Cell::text(rung.kept.join(" | "))));
    let caption = format!("{}: {} by what is left", own.title, primary.title());
    let mut table = Table::new(format!("curve-{}", slug(&own.axis)), caption, all, &own.rungs);
    table.marked.extend(own.knee);
    table
}

fn models(primary: &Primary, rows: &[Small], speed: Option<&SmallSpeed>) -> Table {
    let show = primary.show();
    let speed = speed.copied();
    let first = rows.first().map(|own| own.name.clone());
    let is_whole = move |own: &Small| first.as_ref() == Some(&own.name);
    let times = move |own: &Small| {
        speed.map(|speed| match is_whole(own) {
            true => (speed.whole_p50_ms, speed.whole_p95_ms),
            false => (speed.small_p50_ms, speed.small_p95_ms),
        })
    };
    let columns = vec![
        Column::text("model", "model", |own: &Small| Cell::text(&own.name)),
        Column::text("reads", "reads", |own: &Small| Cell::text(&own.reads)),
        Column::number("values read", &["values"], |own: &Small| Cell::count(own.readings as u64)),
        Column::number(
            &primary.head(),
            &["", "low", "high"].map(|what| primary.column(what)).each_ref().map(String::as_str),
            move |own: &Small| {
                let interval = own.score_interval;
                Cell::number(Some(own.score), show).and(between(primary, interval), &ends(interval))
            },
        ),
        Column::number("parameters", &["parameters"], |own: &Small| Cell::count(own.parameters)),
        Column::number("MACs", &["macs"], |own: &Small| Cell::number(Some(own.macs as f64), si)),
        Column::number("size", &["bytes"], |own: &Small| Cell::number(Some(own.bytes as f64), bytes)),
        Column::number("answer, ms (95 %)", &["latency_p50_ms", "latency_p95_ms"], move |own: &Small| {
            let own = times(own);
            let shown = own.map_or(String::new(), |(_, p95)| format!(" ({})", digits(p95)));
            Cell::number(own.map(|(p50, _)| p50), digits).and(shown, &[own.map(|(_, p95)| p95)])
        }),
    ];
    let caption = "The whole and the smaller model; answers are timed on one thread, from recording to ";
    let caption = format!("{caption}{}", if primary.is_percent() { "probabilities" } else { "values" });
    Table::new("models", caption, columns, rows)
}
