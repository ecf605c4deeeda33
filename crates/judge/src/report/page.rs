//! The page of one run: what to take first, how it was found last.

use maud::{Markup, html};
use taxel_data::{SourceKind, Task};
use taxel_learn::Environment;
use taxel_report::chart::Chart;
use taxel_report::html::{LONG, chart, folded, frame, picture, small_chart, table};
use taxel_report::palette::Paint;
use taxel_report::pictures::{ArrayPicture, PictureKind, Shown, show};
use taxel_report::table::Table;

use super::curve_words::curve_words;
use super::names::{chart as charts, table as tables};
use super::words::{interval_words, kind, runs, stress_basis};
use crate::error::Result;
use crate::values::{Choice, Example, Judged, Judgement};

/// Everything that a page is made of.
struct PageParts<'a> {
    judgement: &'a Judgement,
    choice: Option<&'a Choice>,
    tables: &'a [Table],
    charts: &'a [Chart<'a>],
}

/// Returns the page of a run.
///
/// # Errors
/// A picture of the judgement that is not what it says.
pub(super) fn page(
    judgement: &Judgement,
    choice: Option<&Choice>,
    tables: &[Table],
    charts: &[Chart],
) -> Result<Markup> {
    let parts = PageParts { judgement, choice, tables, charts };
    let against_speed = format!("{} against speed", judgement.primary().heading());
    let sections: Vec<(&str, &str, Markup)> = [
        ("recommendation", "Recommendation", Some(parts.recommendation())),
        ("speed", &against_speed, Some(parts.speed())),
        ("breaking", "Where they break", Some(parts.breaking())),
        ("errors", "How far off they are", parts.errors()),
        ("certainty", "How sure they may be", parts.certainty()),
        ("early", "Early decisions", parts.early()),
        ("mattered", "What mattered", parts.mattered()),
        ("recordings", "More recordings", parts.recordings()),
        ("evidence", "Evidence", parts.evidence()),
        ("details", "Details", Some(parts.details())),
        ("examples", "Examples", parts.examples()?),
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
    let title = format!("{}, {}: taxel report", parts.heading(), judgement.results.source);
    Ok(frame(&title, &body))
}

/// Returns the badge that says what was measured on.
pub(super) fn badge(of: SourceKind) -> Markup {
    html! { span class={ "badge " (kind(of)) } { (kind(of)) " readings" } }
}

impl PageParts<'_> {
    fn table(&self, name: &str) -> Option<Markup> {
        self.tables.iter().find(|shown| shown.name == name).map(table)
    }

    /// Returns a table that is long, or repeats what stands elsewhere, folded.
    fn folded(&self, name: &str) -> Markup {
        match self.tables.iter().find(|shown| shown.name == name) {
            Some(short) if short.rows.len() <= LONG => folded(&short.caption, &table(short)),
            Some(long) => table(long),
            None => html! {},
        }
    }

    fn chart(&self, name: &str, numbers: &str) -> Option<Markup> {
        self.charts.iter().find(|drawn| drawn.name == name).map(|drawn| chart(drawn, numbers))
    }

    /// Returns the chart of the primary metric against a cost.
    fn against(&self, cost: &str, numbers: &str) -> Markup {
        let name = charts::against(self.judgement.primary().name(), cost);
        self.chart(&name, numbers).unwrap_or_default()
    }

    /// Returns the title of the run, or its name.
    fn heading(&self) -> &str {
        let results = &self.judgement.results;
        results.title.as_deref().unwrap_or(&results.name)
    }

    fn header(&self) -> Markup {
        let results = &self.judgement.results;
        let unfinished = self.judgement.unfinished();
        html! {
            header {
                p.kicker { "taxel report of " (results.name) " " (badge(self.judgement.kind())) }
                h1 { (self.heading()) " " span.source { (results.source) } }
                p {
                    (results.samples) " samples, " (results.task.counted()) ". "
                    (self.judgement.protocol) ", seed " (results.seed) "."
                }
                @if let Some(words) = self.diverged() {
                    p.warning role="note" {
                        "Diverged: " (words) "; scores of such a training say nothing about the network."
                    }
                }
                @for leak in &results.leaks {
                    p.warning role="note" { "Mind: " (leak) "." }
                }
                @if let Some(shortcut) = &results.shortcut {
                    p.warning role="note" { "Mind: " (shortcut) ": confounded?" }
                }
                @if unfinished > 0 {
                    p.warning role="note" { "Incomplete: " (unfinished) " folds are missing; resume the run." }
                }
                @if !self.judgement.judged_on.optimised {
                    p.warning role="note" { "Speeds were measured with a debug build; they mean nothing." }
                }
            }
        }
    }

    /// Returns the networks that diverged: `wild in 2 of 5 folds`.
    fn diverged(&self) -> Option<String> {
        let diverged = self.judgement.networks.iter().map(|n| &n.results).filter(|n| n.diverged > 0);
        let words: Vec<String> =
            diverged.map(|n| format!("{} in {}", n.network, n.diverged_folds())).collect();
        (!words.is_empty()).then(|| words.join(", "))
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
                            (choice.primary.margin(choice.margin())) " or more without this table seeing it."
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

    /// Returns the front in words, the most accurate first.
    fn front(&self) -> String {
        fn scored(n: &Judged) -> Option<(f64, &str)> {
            Some((n.score()?, n.results.network.as_str()))
        }
        let on_front = self.judgement.networks.iter().filter(|n| n.on_front);
        let mut front: Vec<(f64, &str)> = on_front.filter_map(scored).collect();
        let primary = self.judgement.primary();
        front.sort_by(|a, b| primary.order(b.0, a.0));
        let names: Vec<String> =
            front.iter().map(|(score, name)| format!("{name} ({})", primary.value(*score))).collect();
        format!("Nothing is both faster and more accurate than: {}.", names.join(", "))
    }

    fn speed(&self) -> Markup {
        html! {
            (self.against(charts::LATENCY, tables::NETWORKS))
            (self.table(tables::NETWORKS).unwrap_or_default())
            @if let Some(eight_bits) = self.table(tables::EIGHT_BITS) {
                h3 { "In eight bits" }
                (eight_bits)
            }
            @if let Some(published) = self.table(tables::PUBLISHED) {
                h3 { "What the papers print" }
                (published)
            }
        }
    }

    fn breaking(&self) -> Markup {
        let Some(stress) = &self.judgement.stress else {
            return html! {
                p { "Not tested." }
            };
        };
        html! {
            p { "Test samples were broken on purpose before any encoding: " (stress_basis(stress)) "." }
            ul.verdicts {
                @for network in &stress.networks {
                    li { strong { (network.network) } ": " (network.verdict) }
                }
            }
            @if let Some(hardening) = self.table(tables::HARDENING) {
                h3 { "Trained under faults" }
                (hardening)
                (self.table(tables::UNSEEN).unwrap_or_default())
            }
            @if let Some(guard) = self.table(tables::GUARD) {
                h3 { "Behind a guard" }
                (guard)
            }
            (self.chart(charts::FAULT_LOSSES, tables::FAULT_LOSSES).unwrap_or_default())
            (self.table(tables::BREAKING_POINTS).unwrap_or_default())
            (self.chart(charts::FAULT_CURVES, tables::FAULT_CURVES).unwrap_or_default())
            (self.folded(tables::FAULT_LOSSES))
            (self.folded(tables::FAULT_CURVES))
            (self.chart(charts::CALIBRATION, tables::BREAKING_POINTS).unwrap_or_default())
            (self.folded(tables::FAULTS))
            @if !stress.left_out.is_empty() {
                h3 { "Left out" }
                ul { @for (fault, reason) in &stress.left_out { li { (fault) ": " (reason) } } }
            }
        }
    }

    fn errors(&self) -> Option<Markup> {
        let table = self.table(tables::ERRORS)?;
        let drawn = self.charts.iter().filter(|drawn| drawn.name.starts_with(charts::VALUES));
        Some(html! {
            p {
                "A model that " code { "taxel fit" } " makes of this run says with each value the interval that held the true one in \
                 nine of ten test samples."
            }
            @for scatter in drawn { (chart(scatter, tables::ERRORS)) }
            (table)
            (self.table(tables::UNKNOWN).unwrap_or_default())
        })
    }

    fn certainty(&self) -> Option<Markup> {
        let chart = self.chart(charts::RELIABILITY, tables::CERTAINTY)?;
        Some(html! {
            p {
                "A model that " code { "taxel fit" } " makes of this run divides its logits by the temperature here, which is fitted \
                 to the test parts. It changes how sure an answer is, never which class it names."
            }
            (chart)
            (self.table(tables::CERTAINTY).unwrap_or_default())
            (self.chart(charts::SUREST, tables::CERTAINTY).unwrap_or_default())
            (self.table(tables::SURE).unwrap_or_default())
            (self.table(tables::UNKNOWN).unwrap_or_default())
        })
    }

    fn early(&self) -> Option<Markup> {
        let chart = self.chart(charts::EARLY, tables::EARLY)?;
        Some(html! {
            p { "How right answers are before a sample is whole. A model that is calibrated decides later: see " code { "taxel inspect" } "." }
            (chart)
            (self.table(tables::EARLY).unwrap_or_default())
            (self.folded(tables::EARLY_DECISIONS))
        })
    }

    /// Shows what decisions rest on.
    fn mattered(&self) -> Option<Markup> {
        let chart = self.chart(charts::IMPORTANCE, tables::IMPORTANCE)?;
        Some(html! {
            (chart)
            p.reading {
                "A part that other parts can stand in for costs little alone, so little lost does not say that it is useless: "
                code { "taxel shrink" } " trains without it."
            }
            (self.folded(tables::IMPORTANCE))
        })
    }

    /// Says what more training recordings would bring.
    fn recordings(&self) -> Option<Markup> {
        let curve = self.judgement.learning_curve.as_ref()?;
        let drawn = self.charts.iter().find(|drawn| drawn.name == charts::LEARNING_CURVE)?;
        Some(html! {
            @for sentence in &curve_words(curve, &self.judgement.primary()) { p { (sentence) } }
            (small_chart(drawn))
            p.reading { (drawn.reading) }
        })
    }

    fn evidence(&self) -> Option<Markup> {
        self.table(tables::EVIDENCE)
    }

    fn details(&self) -> Markup {
        let matrices: Vec<&Chart> =
            self.charts.iter().filter(|c| c.name.starts_with(charts::CONFUSION)).collect();
        let numbers = match self.judgement.results.task {
            Task::Levels(_) => tables::ATTRIBUTES,
            Task::Classes(_) | Task::Values(_) => tables::CONFUSION,
        };
        html! {
            (self.against(charts::SIZE, tables::COSTS))
            (self.against(charts::MACS, tables::COSTS))
            (self.table(tables::COSTS).unwrap_or_default())
            (self.chart(charts::WHERE_TIME_GOES, tables::SPEED).unwrap_or_default())
            (self.table(tables::SPEED).unwrap_or_default())
            @if let Some(chart) = self.chart(charts::FEW_SAMPLES, tables::FEW_SAMPLES) {
                (chart)
                (self.table(tables::FEW_SAMPLES).unwrap_or_default())
            }
            @if let Some(chart) = self.chart(charts::TRAINING, tables::TRAINING) {
                (chart)
                (self.folded(tables::TRAINING))
            }
            @if let Some(chart) = self.chart(charts::WEIGHT_CHANGES, tables::WEIGHT_CHANGES) {
                (chart)
                (self.table(tables::WEIGHT_CHANGES).unwrap_or_default())
            }
            @if let Some(first) = matrices.first() {
                h3 { "What is taken for what" }
                p.reading { (first.reading) " Numbers: " a href={ "#table-" (numbers) } { "table" } "." }
                div.grid { @for matrix in &matrices { (small_chart(matrix)) } }
            }
            (self.folded(tables::CONFUSION))
            (self.table(tables::ATTRIBUTES).unwrap_or_default())
            (self.folded(tables::CLASSES))
            (self.folded(tables::FOLDS))
        }
    }

    fn examples(&self) -> Result<Option<Markup>> {
        if self.judgement.examples.is_empty() {
            return Ok(None);
        }
        let all = self.judgement.examples.iter().enumerate();
        let articles = all.map(|(i, shown)| example(i + 1, shown)).collect::<Result<Vec<_>>>()?;
        Ok(Some(html! {
            p {
                "Test samples of the first fold: those that divide the networks most, and one that all "
                (if self.judgement.primary().is_percent() { "get right" } else { "come near to" }) ". "
                "Images are scaled from their least to their largest value."
            }
            @for article in &articles { (article) }
            (self.folded(tables::EXAMPLES))
        }))
    }

    fn how(&self) -> Markup {
        let judgement = self.judgement;
        let published = judgement.networks.iter().any(|n| n.results.published.is_some());
        let kinds = if published { "Simulated, real and published" } else { "Simulated and real" };
        html! {
            dl { @for (name, text) in &facts(judgement) { dt { (name) } dd { (text) } } }
            @for line in judgement.results.batch_norm_words() { p { "The same weights: " (line) "." } }
            @if !judgement.results.left_out.is_empty() {
                h3 { "Baselines that were left out" }
                ul { @for (name, reason) in &judgement.results.left_out { li { (name) ": " (reason) } } }
            }
            p {
                "All of this is in " code { "judgement.json" } "; nothing was trained for this page"
                @if self.judgement.learning_curve.is_some() { ", but for the curve of more recordings" }
                ". "
                (kinds) " numbers never share a column."
            }
        }
    }
}

/// Returns the circumstances of the measurements: samples, protocol, machines.
fn facts(judgement: &Judgement) -> Vec<(String, String)> {
    let primary = judgement.primary();
    let (then, now) = (&judgement.environment, &judgement.judged_on);
    let machine = |environment: &Environment| {
        let cpu = environment.processor().unwrap_or("unknown processor".into());
        let build = if environment.optimised { "release build" } else { "debug build" };
        let commit = environment.commit.as_deref().unwrap_or("unknown commit");
        format!("{cpu}, {}, taxel {} ({commit}, {build})", environment.platform, environment.taxel)
    };
    vec![
        ("Readings".into(), judgement.results.source.to_string()),
        ("Digest of the readings".into(), judgement.results.data_digest.clone()),
        ("Protocol".into(), format!("{}, seed {}", judgement.protocol, judgement.results.seed)),
        (primary.heading(), format!("mean over test parts; interval: {}", interval_words(judgement))),
        (
            primary.chance_heading().into(),
            format!("{}: {}", primary.value(judgement.chance), primary.knowing_nothing()),
        ),
        (
            "Latency".into(),
            format!(
                "one test sample at a time on one thread, from raw reading to {}, encoding \
                 included; {} timed runs after up to 50 to warm up",
                if primary.is_percent() { "probabilities" } else { "values" },
                runs(judgement)
            ),
        ),
        ("Trained on".into(), format!("{}, {} threads", machine(then), then.threads)),
        ("Timed on".into(), machine(now)),
        (
            "Faults".into(),
            judgement.stress.as_ref().map_or("not tested".into(), |stress| {
                format!("{}; seed {}", stress_basis(stress), stress.seed)
            }),
        ),
    ]
}

fn example(number: usize, example: &Example) -> Result<Markup> {
    let drawn = |picture| Ok((label(picture), show(picture, Paint::Page)?));
    let pictures: Vec<(String, Shown)> = example.pictures.iter().map(drawn).collect::<Result<_>>()?;
    Ok(html! {
        article.example {
            h3 { "Example " (number) ": " (example.truth) }
            p.reading { (example.origin) }
            div.pictures {
                @for (label, shown) in &pictures {
                    figure { (picture(shown, label)) figcaption { (label) } }
                }
            }
            ul.answers {
                @for verdict in &example.verdicts {
                    li class=[verdict.right.map(|right| if right { "right" } else { "wrong" })] {
                        @if let Some(right) = verdict.right {
                            span.mark aria-hidden="true" { (if right { "✓" } else { "✕" }) }
                        }
                        strong { (verdict.network) } ": " (verdict.predicted)
                        @if let Some(share) = verdict.probability { " (" (format!("{:.0} %", 100.0 * share)) ")" }
                        @if let Some(right) = verdict.right {
                            span.unseen { (if right { ", right" } else { ", wrong" }) }
                        }
                    }
                }
            }
        }
    })
}

/// Returns the label of a picture: `image, 3×50×50 colours by rows by columns`.
pub(super) fn label(picture: &ArrayPicture) -> String {
    let shape: Vec<String> = picture.shape.iter().map(usize::to_string).collect();
    let kind = match picture.kind {
        PictureKind::Lines => "channels by readings",
        PictureKind::Grey => "rows by columns",
        PictureKind::Colour => "colours by rows by columns",
        PictureKind::Frames => "frames by rows by columns",
    };
    format!("{}, {} {kind}", picture.name, shape.join("×"))
}
