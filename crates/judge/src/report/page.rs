//! The page of one run: what to take first, how it was found last.

use maud::{Markup, html};

use super::charts::Chart;
use super::html::{LONG, chart, folded, frame, picture, small_chart, table};
use super::palette::Paint;
use super::pictures;
use super::tables::Table;
use super::words::{runs, stress_basis};
use crate::choice::Choice;
use crate::judgement::{Example, Judgement, Kind, Picture, PictureKind};

/// Everything that a page is made of.
struct Parts<'a> {
    judgement: &'a Judgement,
    choice: Option<&'a Choice>,
    tables: &'a [Table],
    charts: &'a [Chart<'a>],
}

pub(super) fn page(
    judgement: &Judgement,
    choice: Option<&Choice>,
    tables: &[Table],
    charts: &[Chart],
) -> Markup {
    let parts = Parts { judgement, choice, tables, charts };
    let sections: Vec<(&str, &str, Markup)> = [
        ("recommendation", "Recommendation", Some(parts.recommendation())),
        ("speed", "Accuracy against speed", Some(parts.speed())),
        ("breaking", "Where they break", Some(parts.breaking())),
        ("evidence", "Evidence", parts.evidence()),
        ("claims", "Claims", parts.claims()),
        ("details", "Details", Some(parts.details())),
        ("examples", "Examples", parts.examples()),
        ("how", "How it was measured", Some(parts.how())),
    ]
    .into_iter()
    .filter_map(|(id, title, content)| content.map(|content| (id, title, content)))
    .collect();
    let body = html! {
        (parts.header())
        nav aria-label="Sections" {
            ul { @for (id, title, _) in &sections { li { a href={ "#" (id) } { (title) } } } }
        }
        main id="main" {
            @for (id, title, content) in &sections {
                section id=(id) aria-labelledby={ (id) "-title" } {
                    h2 id={ (id) "-title" } { (title) }
                    (content)
                }
            }
        }
    };
    frame(&format!("{}: taxel report", judgement.results.name), &body)
}

/// The badge that says what was measured on.
pub(super) fn badge(kind: Kind) -> Markup {
    match kind {
        Kind::Simulated => html! { span.badge.simulated { "simulated readings" } },
        Kind::Real => html! { span.badge.real { "real readings" } },
    }
}

impl Parts<'_> {
    fn table(&self, name: &str) -> Option<Markup> {
        self.tables.iter().find(|own| own.name == name).map(table)
    }

    /// A table that is long, or said elsewhere.
    fn folded(&self, name: &str) -> Markup {
        match self.tables.iter().find(|own| own.name == name) {
            Some(own) if own.rows.len() <= LONG => folded(&own.caption, &table(own)),
            Some(own) => table(own),
            None => html! {},
        }
    }

    fn chart(&self, name: &str, numbers: &str) -> Option<Markup> {
        self.charts.iter().find(|own| own.name == name).map(|own| chart(own, numbers))
    }

    fn header(&self) -> Markup {
        let results = &self.judgement.results;
        let what = if results.attributes.is_empty() { "classes" } else { "levels" };
        html! {
            header {
                p.kicker { "taxel report " (badge(self.judgement.kind)) }
                h1 { (results.name) }
                @if let Some(title) = &results.title { p.lead { (title) } }
                p {
                    (results.source) ", " (results.samples) " samples, " (results.classes.len()) " " (what) ". "
                    (self.judgement.protocol) ", seed " (results.seed) "."
                }
                @if !results.complete {
                    p.warning role="note" {
                        "Incomplete: " (results.missing.len()) " folds are missing. Go on with "
                        code { "taxel run --resume" } "."
                    }
                }
                @if !self.judgement.judged_on.optimised {
                    p.warning role="note" { "Speeds were measured with a debug build; they mean nothing." }
                }
            }
        }
    }

    fn recommendation(&self) -> Markup {
        match self.choice {
            Some(choice) => html! {
                div.answer {
                    @match &choice.chosen {
                        Some(name) => p.chosen { "Take " strong { (name) } "." },
                        None => p.chosen { "No network suffices." },
                    }
                    @for sentence in &choice.words { p { (sentence) } }
                    @if !choice.enough_data {
                        p.warning role="note" {
                            "Too few data to tell: a network may be worse than the best by "
                            (choice.wish.margin) " points or more without this table seeing it."
                        }
                    }
                }
            },
            None => html! {
                div.answer {
                    p { "No recommendation was asked for. " (self.front()) }
                }
            },
        }
    }

    /// The ends of the front in words.
    fn front(&self) -> String {
        let scored = |n: &&crate::Judged| n.on_front && n.results.mean.is_some() && n.speed.is_some();
        let mut front: Vec<_> = self.judgement.networks.iter().filter(scored).collect();
        let accuracy = |n: &crate::Judged| n.results.mean.map_or(0.0, |mean| mean.accuracy);
        front.sort_by(|a, b| accuracy(b).total_cmp(&accuracy(a)));
        let said = |n: &&crate::Judged| format!("{} ({:.1} %)", n.results.network, accuracy(n));
        let names: Vec<String> = front.iter().map(said).collect();
        format!("Nothing is both faster and more accurate than: {}.", names.join(", "))
    }

    fn speed(&self) -> Markup {
        html! {
            (self.chart("accuracy-latency", "networks").unwrap_or_default())
            (self.table("networks").unwrap_or_default())
            @if let Some(published) = self.table("published") {
                h3 { "What the papers print" }
                (published)
            }
        }
    }

    fn breaking(&self) -> Markup {
        let Some(stress) = &self.judgement.stress else {
            return html! {
                p { "Not tested. " code { "taxel report --again" } " without " code { "--no-stress" } " does it." }
            };
        };
        html! {
            p { "Test samples were broken on purpose before any encoding: " (stress_basis(stress)) "." }
            ul.verdicts {
                @for network in &stress.networks {
                    li { strong { (network.network) } ": " (network.verdict) }
                }
            }
            (self.chart("fault-losses", "fault-losses").unwrap_or_default())
            (self.table("breaking-points").unwrap_or_default())
            (self.chart("fault-curves", "fault-curves").unwrap_or_default())
            (self.folded("fault-losses"))
            (self.folded("fault-curves"))
            (self.chart("calibration", "breaking-points").unwrap_or_default())
            (self.folded("faults"))
            @if !stress.left_out.is_empty() {
                h3 { "Left out" }
                ul { @for (fault, reason) in &stress.left_out { li { (fault) ": " (reason) } } }
            }
        }
    }

    fn evidence(&self) -> Option<Markup> {
        self.table("evidence")
    }

    fn claims(&self) -> Option<Markup> {
        self.table("claims")
    }

    fn details(&self) -> Markup {
        let matrices: Vec<&Chart> = self.charts.iter().filter(|c| c.name.starts_with("confusion-")).collect();
        let numbers = if self.judgement.results.attributes.is_empty() { "confusion" } else { "attributes" };
        html! {
            (self.chart("accuracy-size", "costs").unwrap_or_default())
            (self.chart("accuracy-macs", "costs").unwrap_or_default())
            (self.table("costs").unwrap_or_default())
            (self.chart("where-time-goes", "speed").unwrap_or_default())
            (self.table("speed").unwrap_or_default())
            @if let Some(chart) = self.chart("few-samples", "few-samples") {
                (chart)
                (self.table("few-samples").unwrap_or_default())
            }
            @if let Some(chart) = self.chart("training", "training") {
                (chart)
                (self.folded("training"))
            }
            @if let Some(chart) = self.chart("weight-changes", "weight-changes") {
                (chart)
                (self.table("weight-changes").unwrap_or_default())
            }
            @if let Some(first) = matrices.first() {
                h3 { "What is taken for what" }
                p.reading { (first.reading) " Numbers: " a href={ "#table-" (numbers) } { "table" } "." }
                div.grid { @for own in &matrices { (small_chart(own)) } }
            }
            (self.folded("confusion"))
            (self.table("attributes").unwrap_or_default())
            (self.folded("classes"))
            (self.folded("folds"))
        }
    }

    fn examples(&self) -> Option<Markup> {
        if self.judgement.examples.is_empty() {
            return None;
        }
        Some(html! {
            p {
                "Test samples of the first fold: those that divide the networks most, and one that all get right. "
                "Images are scaled from their least to their largest value."
            }
            @for (i, own) in self.judgement.examples.iter().enumerate() { (example(i + 1, own)) }
            (self.folded("examples"))
        })
    }

    fn how(&self) -> Markup {
        let judgement = self.judgement;
        let (then, now) = (&judgement.environment, &judgement.judged_on);
        let machine = |own: &taxel_trainer::Environment| {
            let cpu = own.cpu.as_deref().unwrap_or("unknown processor");
            let build = if own.optimised { "release build" } else { "debug build" };
            let commit = own.commit.as_deref().unwrap_or("unknown commit");
            format!("{cpu}, {}, taxel {} ({commit}, {build})", own.platform, own.taxel)
        };
        let facts: Vec<(&str, String)> = vec![
            ("Readings", judgement.results.source.clone()),
            ("Digest of the readings", judgement.results.data_digest.clone()),
            ("Protocol", format!("{}, seed {}", judgement.protocol, judgement.results.seed)),
            (
                "Accuracy",
                "mean over test parts; interval: 95 % bootstrap over groups where there are some, over samples \
                 elsewhere"
                    .into(),
            ),
            ("Chance", format!("{:.1} %: always naming the commonest class", judgement.chance)),
            (
                "Latency",
                format!(
                    "one test sample at a time on one thread, from raw reading to probabilities, encoding \
                     included; {} timed runs after up to 50 to warm up",
                    runs(judgement)
                ),
            ),
            ("Trained on", format!("{}, {} threads", machine(then), then.threads)),
            ("Timed on", machine(now)),
            (
                "Faults",
                judgement.stress.as_ref().map_or("not tested".into(), |stress| {
                    format!("{}; seed {}", stress_basis(stress), stress.seed)
                }),
            ),
        ];
        html! {
            dl { @for (name, text) in &facts { dt { (name) } dd { (text) } } }
            @for line in judgement.results.batch_norm_words() { p { "The same weights: " (line) "." } }
            @if !judgement.results.left_out.is_empty() {
                h3 { "Baselines that were left out" }
                ul { @for (name, reason) in &judgement.results.left_out { li { (name) ": " (reason) } } }
            }
            p {
                "All of this is in " code { "judgement.json" } "; nothing was trained for this page. "
                "Simulated, real and published numbers never share a column."
            }
        }
    }
}

fn example(number: usize, own: &Example) -> Markup {
    let label = |picture: &Picture| {
        let shape: Vec<String> = picture.shape.iter().map(usize::to_string).collect();
        let kind = match picture.kind {
            PictureKind::Lines => "channels by readings",
            PictureKind::Grey => "rows by columns",
            PictureKind::Colour => "colours by rows by columns",
            PictureKind::Frames => "frames by rows by columns",
        };
        format!("{}, {} {kind}", picture.name, shape.join("×"))
    };
    html! {
        article.example {
            h3 { "Example " (number) ": " (own.truth) }
            p.reading { (own.origin) }
            div.pictures {
                @for own in &own.pictures {
                    @if let Some(shown) = pictures::show(own, Paint::Page) {
                        figure { (picture(&shown, &label(own))) figcaption { (label(own)) } }
                    }
                }
            }
            ul.answers {
                @for verdict in &own.verdicts {
                    li class=(if verdict.right { "right" } else { "wrong" }) {
                        span.mark aria-hidden="true" { (if verdict.right { "✓" } else { "✕" }) }
                        strong { (verdict.network) } ": " (verdict.predicted)
                        " (" (format!("{:.0} %", 100.0 * verdict.probability)) ")"
                        span.unseen { (if verdict.right { ", right" } else { ", wrong" }) }
                    }
                }
            }
        }
    }
}
