//! The page that says how little of the sensing and of a network suffices.

use std::path::{Path, PathBuf};

use maud::{Markup, html};
use taxel_judge::{Contrast, Primary};
use taxel_report::chart::Chart;
use taxel_report::files::{slug, write_page};
use taxel_report::html::{chart, table};
use taxel_report::numbers::{between, bytes, digits, si, tick};
use taxel_report::table::{Cell, Column, Table};

use crate::chart::curve_chart;
use crate::error::Result;
use crate::shrunk::{Curve, CurveStep, ModelSummary, Shrunk, SmallSpeed};

/// Writes `index.html` below `folder`, with its tables and charts as files, the page last. The path of the page.
///
/// # Errors
/// A file that cannot be written.
pub fn shrunk_page(shrunk: &Shrunk, speed: Option<&SmallSpeed>, folder: &Path) -> Result<PathBuf> {
    let drawn: Vec<(Chart, Table)> =
        shrunk.curves.iter().map(|curve| (curve_chart(curve, shrunk), settings(curve, shrunk))).collect();
    let models = models(&shrunk.primary, &shrunk.models, speed);
    let title = format!("{}: what {} needs", shrunk.run, shrunk.network);
    let tables = drawn.iter().map(|(_, table)| table).chain([&models]);
    let charts = drawn.iter().map(|(chart, _)| chart);
    Ok(write_page(folder, (&title, &body(shrunk, &drawn, &models)), tables, charts)?)
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
                (format!("{title} {}", primary.value(whole)).trim_start()) (interval.map_or(String::new(), between(primary.show()))) " on " (shrunk.parts) " test parts."
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
                    (primary.margin(shrunk.margin)) ", both on " (shrunk.inner) " inner folds of each training part. The test parts are asked once for each \
                    setting and choose nothing: their numbers are what a user may expect."
                }
            }
            @if !models.rows.is_empty() {
                section id="model" {
                    h2 { "The smaller model" }
                    (table(models))
                    @if let Some(combined) = &shrunk.combined {
                        @for words in &combined.loosened { p { (words) } }
                    }
                    p {
                        code { "shrunk.safetensors" } " takes whole recordings and leaves aside what it does not read; "
                        code { "shrunk.toml" } " is its experiment."
                    }
                }
            }
            @for (curve, (drawn, numbers)) in shrunk.curves.iter().zip(drawn) {
                section id=(slug(&curve.axis)) {
                    h2 { (curve.title) }
                    p { (curve.words) }
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

/// Returns the columns of a contrast: `on` is where it was measured.
fn columns(
    primary: &Primary,
    on: &str,
    key: &str,
    get: fn(&CurveStep) -> Option<Contrast>,
) -> Vec<Column<'static, CurveStep>> {
    let field = |name: String| format!("{key}_{name}");
    let [score, low, high] = ["", "low", "high"].map(|what| field(primary.column(what)));
    let [difference, least, most] =
        ["difference", "difference_low", "difference_high"].map(|name| field(primary.column_of_loss(name)));
    let (head, show) = (primary.head_of(on), primary.show());
    vec![
        Column::number(&head, &[&score, &low, &high], move |step: &CurveStep| {
            let contrast = get(step);
            let interval = contrast.and_then(|contrast| contrast.score_interval);
            Cell::number(contrast.map(|contrast| contrast.score), show).interval(interval, between(show))
        }),
        Column::number("against the whole", &[&difference, &least, &most], move |step: &CurveStep| {
            let contrast = get(step);
            let interval = contrast.and_then(|contrast| contrast.interval);
            Cell::number(contrast.map(|contrast| contrast.difference), show).interval(interval, between(show))
        }),
    ]
}

fn settings(curve: &Curve, shrunk: &Shrunk) -> Table {
    let (primary, margin) = (&shrunk.primary, shrunk.margin);
    let mut all = vec![Column::text("left", "left", |step: &CurveStep| Cell::text(&step.label))];
    all.extend(columns(primary, "test parts", "test", |step| step.outer));
    all.extend(columns(primary, "inner folds", "inner", |step| step.inner));
    all.push(Column::value(
        "p (Holm), inner",
        "inner_p_holm",
        |p| {
            if p < 0.001 { "< 0.001".into() } else { format!("{p:.3}") }
        },
        |step: &CurveStep| step.inner.and_then(|contrast| contrast.p_holm),
    ));
    all.push(Column::text("", "verdict", move |step: &CurveStep| {
        Cell::text(match (&step.refused, step.inner) {
            (Some(reason), _) => reason.clone(),
            (None, Some(inner)) if inner.worse => "worse".into(),
            (None, Some(inner)) if inner.suffices(margin, primary) => "suffices".into(),
            (None, Some(_)) => "loses too much".into(),
            (None, None) => "not tried".into(),
        })
    }));
    all.push(Column::text("kept, by fold", "kept", |step: &CurveStep| Cell::text(step.kept.join(" | "))));
    let caption = format!("{}: {} by what is left", curve.title, primary.title());
    let mut table = Table::new(format!("curve-{}", slug(&curve.axis)), caption, all, &curve.steps);
    table.marked.extend(curve.knee);
    table
}

fn models(primary: &Primary, rows: &[ModelSummary], speed: Option<&SmallSpeed>) -> Table {
    let show = primary.show();
    let speed = speed.copied();
    let first = rows.first().map(|model| model.name.clone());
    let is_whole = move |model: &ModelSummary| first.as_ref() == Some(&model.name);
    let times = move |model: &ModelSummary| {
        speed.map(|speed| {
            if is_whole(model) {
                (speed.whole_p50_ms, speed.whole_p95_ms)
            } else {
                (speed.small_p50_ms, speed.small_p95_ms)
            }
        })
    };
    let columns = vec![
        Column::text("model", "model", |model: &ModelSummary| Cell::text(&model.name)),
        Column::text("reads", "reads", |model: &ModelSummary| Cell::text(&model.reads)),
        Column::count("values read", "values", |model: &ModelSummary| model.readings as u64),
        Column::number(
            &primary.head(),
            &["", "low", "high"].map(|what| primary.column(what)).each_ref().map(String::as_str),
            move |model: &ModelSummary| {
                Cell::number(Some(model.score), show).interval(model.score_interval, between(show))
            },
        ),
        Column::count("parameters", "parameters", |model: &ModelSummary| model.parameters),
        Column::value("MACs", "macs", si, |model: &ModelSummary| Some(model.macs as f64)),
        Column::value("size", "bytes", bytes, |model: &ModelSummary| Some(model.bytes as f64)),
        Column::number(
            "answer, ms (95 %)",
            &["latency_p50_ms", "latency_p95_ms"],
            move |model: &ModelSummary| {
                let time = times(model);
                let shown = time.map_or(String::new(), |(_, p95)| format!(" ({})", digits(p95)));
                Cell::number(time.map(|(p50, _)| p50), digits).and(shown, &[time.map(|(_, p95)| p95)])
            },
        ),
    ];
    let caption = "The whole and the smaller model; answers are timed on one thread, from recording to ";
    let caption = format!("{caption}{}", if primary.is_percent() { "probabilities" } else { "values" });
    Table::new("models", caption, columns, rows)
}
