//! Pieces of a page: its frame, tables, charts. The templates escape every text.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::canvas::Canvas;
use crate::chart::Chart;
use crate::palette::{Paint, variables};
use crate::pictures::Shown;
use crate::table::{Cell, Table};

/// Rows up to which a table is shown as it is.
pub const LONG: usize = 30;

/// Returns a page that needs no other file.
pub fn frame(title: &str, body: &Markup) -> Markup {
    let style = format!(
        ":root{{color-scheme:light dark;{}}}@media (prefers-color-scheme:dark){{:root{{{}}}}}\
         @media print{{:root{{color-scheme:light;{}}}}}{}",
        variables(false),
        variables(true),
        variables(false),
        include_str!("page.css")
    );
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content=(concat!("taxel ", env!("CARGO_PKG_VERSION")));
                title { (title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(style)) }
            }
            body {
                a.skip href="#main" { "Skip to the report" }
                (body)
                script { (PreEscaped(include_str!("page.js"))) }
            }
        }
    }
}

/// Returns a table that scrolls in its own box and can be sorted by its heads.
pub fn table(table: &Table) -> Markup {
    let scroll = html! {
        (scroll(table))
        p.files { "As files: " code { "tables/" (table.name) ".csv" } ", " code { "tables/" (table.name) ".md" } }
    };
    if table.rows.len() > LONG {
        folded(&format!("{} ({} rows)", table.caption, table.rows.len()), &scroll)
    } else {
        scroll
    }
}

/// Returns the table alone, of a page that has no files beside it.
pub fn scroll(table: &Table) -> Markup {
    let id = format!("table-{}", table.name);
    // What is not known of any row is no column of the page.
    let known = |k: usize| table.rows.iter().any(|row| !["", "–"].contains(&row[k].shown.as_str()));
    let kept: Vec<usize> =
        (0..table.heads.len()).filter(|&k| k == 0 || (!table.heads[k].in_files && known(k))).collect();
    html! {
        div.scroll role="region" tabindex="0" aria-labelledby=(id) {
            table.sortable {
                caption id=(id) { span { (table.caption) } }
                thead {
                    tr {
                        @for head in kept.iter().map(|&k| &table.heads[k]) {
                            th scope="col" class=[head.right.then_some("number")] { (head.shown) }
                        }
                    }
                }
                tbody {
                    @for (i, row) in table.rows.iter().enumerate() {
                        tr class=[table.marked.contains(&i).then_some("marked")] {
                            @for &k in &kept { (field(&row[k], k == 0, table.heads[k].right)) }
                        }
                    }
                }
            }
        }
    }
}

fn field(cell: &Cell, first: bool, right: bool) -> Markup {
    let order = cell.order.map(|value| value.to_string());
    // Long text gets room to breathe, numbers stay on one line.
    let class = match (right, cell.shown.chars().count() > 40) {
        (true, _) => Some("number"),
        (false, true) => Some("long"),
        (false, false) => None,
    };
    html! {
        @if first { th scope="row" data-order=[order] { (cell.shown) } }
        @else { td class=[class] data-order=[order] { (cell.shown) } }
    }
}

/// Returns content that is shown on demand.
pub fn folded(summary: &str, content: &Markup) -> Markup {
    html! { details { summary { (summary) } (content) } }
}

/// Returns a chart with a text on how to read it, and its numbers as a table for those who cannot see it.
pub fn chart(chart: &Chart, numbers: &str) -> Markup {
    html! {
        figure {
            figcaption { h3 { (chart.title) } }
            (drawing(&chart.canvas(Paint::Page), &chart.label()))
            p.reading {
                (chart.reading) " Numbers: " a href=(format!("#table-{numbers}")) { "table" } "; files: "
                code { "charts/" (chart.name) ".svg" } ", " code { ".png" }
            }
        }
    }
}

/// Returns a chart beside others that are read alike.
pub fn small_chart(chart: &Chart) -> Markup {
    html! {
        figure {
            figcaption { h4 { (chart.title) } }
            (drawing(&chart.canvas(Paint::Page), &chart.label()))
        }
    }
}

/// Returns an SVG in a box of its own, which scrolls on a narrow screen.
pub fn drawing(canvas: &Canvas, label: &str) -> Markup {
    html! { div.drawing tabindex="0" role="group" aria-label="chart" { (PreEscaped(canvas.svg(label))) } }
}

/// Returns a picture of a reading or of an encoding.
pub fn picture(shown: &Shown, label: &str) -> Markup {
    match shown {
        Shown::Drawing(canvas) => drawing(canvas, label),
        Shown::Pixels(width, height, png) => {
            let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
            // Whole pixels, some 200 units high or 360 wide.
            let scale = (200.0 / *height as f64).min(360.0 / *width as f64).max(1.0).floor();
            let (w, h) = (*width as f64 * scale, *height as f64 * scale);
            html! { img.pixels src=(source) width=(w) height=(h) alt=(label); }
        }
    }
}
