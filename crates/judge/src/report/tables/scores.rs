//! Scores: the table of the networks, what papers published, folds, classes.

use taxel_learn::metrics::{ClassScores, LevelScores, Metric, shown};
use taxel_learn::{FoldScores, NetworkResults, Published};
use taxel_report::numbers::{bytes, digits, in_brackets, si, tenth};
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::report::words::{few_groups, few_samples_of, is_shown, kind};
use crate::values::{Choice, Judged, Judgement, Primary, Speed};

/// Returns the source, which every caption of measured scores names: `simulated: fingertip`.
fn measured_on(judgement: &Judgement) -> String {
    format!("Measured on {} readings ({})", kind(judgement.kind()), judgement.results.source)
}

pub(super) fn name(head: &str) -> Column<'_, Judged> {
    Column::text(head, "network", |n: &Judged| Cell::text(&n.results.network))
}

/// Returns the column of the primary metric with its interval.
fn primary_column<'a, R: 'a>(primary: &Primary, of: impl Fn(&R) -> &NetworkResults + 'a) -> Column<'a, R> {
    let show = primary.show();
    let fields = ["", "low", "high"].map(|what| primary.column(what));
    let head = format!("{} [95 % interval]", primary.head());
    Column::number(&head, &fields.each_ref().map(String::as_str), move |row: &R| {
        let results = of(row);
        Cell::number(results.primary(), show).interval(results.interval, in_brackets(show))
    })
}

/// Returns the column of its standard deviation.
fn spread_column<'a, R: 'a>(
    primary: &Primary,
    over: &str,
    of: impl Fn(&R) -> &NetworkResults + 'a,
) -> Column<'a, R> {
    let show = primary.show();
    let head = primary.head_of_loss(&format!("SD over {over}"));
    let field = primary.column_of_loss(&format!("{}_sd", primary.name()));
    Column::value(&head, &field, show, move |row: &R| of(row).primary_spread())
}

/// A metric beside the primary one: its head, field and name, and how its numbers are shown.
type Other = (String, String, &'static str, fn(f64) -> String);

/// Returns the other metrics that tables of this task show.
fn others(judgement: &Judgement) -> Vec<Other> {
    let task = &judgement.results.task;
    let means = judgement.networks.iter().filter_map(|network| network.results.mean.as_ref());
    let mut shown = shown(task, means).into_iter().skip(1).peekable();
    let other = |metric: &'static Metric| -> Other {
        (metric.with_unit(task), metric.name.into(), metric.name, digits)
    };
    if !task.quantities().is_empty() {
        return shown.map(other).collect();
    }
    // Of labels macro F1 alone, and the metrics of events.
    while shown.next_if(|metric| metric.is_shown).is_some() {}
    let macro_f1 = ("macro F1 %".into(), "macro_f1_percent".into(), "f1", tenth as fn(f64) -> String);
    std::iter::once(macro_f1).chain(shown.map(other)).collect()
}

/// Returns the table that a report begins with.
pub(in crate::report) fn networks(judgement: &Judgement, choice: Option<&Choice>) -> Table {
    let primary = judgement.primary();
    let show = primary.show();
    let loss = |n: &Judged| judgement.stress.as_ref()?.mean_loss(&n.results.network);
    let role = |n: &Judged| {
        let name = Some(n.results.network.as_str());
        if choice.and_then(|c| c.chosen.as_deref()) == name {
            "recommended"
        } else if n.results.diverged > 0 {
            "diverged"
        } else if choice.map(|c| c.best.as_str()) == name {
            "most accurate"
        } else if n.on_front {
            "on the front"
        } else {
            "dominated"
        }
    };
    let speed =
        |value: fn(&Speed) -> f64| move |n: &Judged| Cell::number(n.speed.as_ref().map(value), digits);
    let mut columns = vec![
        name("network"),
        Column::text("what", "kind", |n: &Judged| {
            Cell::text(if n.baseline { "baseline" } else { "network" })
        }),
        primary_column(&primary, |n: &Judged| &n.results),
        spread_column(&primary, "folds", |n: &Judged| &n.results),
    ];
    columns.extend(others(judgement).into_iter().map(|(head, field, name, show)| {
        Column::value(&head, &field, show, move |n: &Judged| n.results.score(name))
    }));
    columns.extend([
        Column::number("latency p50, ms", &["latency_p50_ms"], speed(|s| s.whole.p50_ms)),
        Column::number("p95, ms", &["latency_p95_ms"], speed(|s| s.whole.p95_ms)),
        Column::value("size", "bytes", bytes, |n: &Judged| Some(n.results.costs.bytes as f64)),
        Column::value("MACs", "macs", si, |n: &Judged| Some(n.results.costs.macs as f64)),
    ]);
    if judgement.stress.is_some() {
        columns.push(Column::value(
            &primary.head_of_loss("lost under faults"),
            &primary.column_of_loss("mean_fault_loss"),
            show,
            move |n: &Judged| loss(n),
        ));
    }
    columns.push(Column::text(&format!("speed against {}", primary.title()), "role", move |n: &Judged| {
        Cell::text(if n.speed.is_some() || n.results.diverged > 0 { role(n) } else { "not timed" })
    }));
    let shown: Vec<Judged> = judgement.networks.iter().filter(|n| is_shown(judgement, n)).cloned().collect();
    let caption = format!(
        "{}; {}; {}: mean over folds{}; latency: one sample from raw reading to answer, one thread",
        measured_on(judgement),
        judgement.protocol,
        primary.title(),
        few_groups(judgement).map_or(String::new(), |few| format!(", {few}"))
    );
    let chosen = choice.and_then(|c| c.chosen.as_ref());
    let marked = (0..shown.len()).filter(|&i| Some(&shown[i].results.network) == chosen).collect();
    Table { marked, ..Table::new(table::NETWORKS, caption, columns, &shown) }
}

/// Lists the scores that authors report on their own data; they share no column with scores measured here.
pub(super) fn published(judgement: &Judgement) -> Table {
    let pair = |score: &[f64]| {
        let sd = score.get(1).copied();
        Cell::number(score.first().copied(), |v| format!("{v:.2}"))
            .and(sd.map_or(String::new(), |sd| format!(" ± {sd:.2}")), &[sd])
    };
    let rows: Vec<_> = judgement
        .networks
        .iter()
        .filter_map(|n| n.results.published.clone().map(|published| (n.results.network.clone(), published)))
        .collect();
    type Row = (String, Published);
    let mut columns = vec![
        Column::text("network", "network", |(name, _): &Row| Cell::text(name)),
        Column::text("where", "published_in", |(_, published): &Row| Cell::text(&published.table)),
        Column::number(
            "accuracy %, published",
            &["published_accuracy_percent", "published_accuracy_sd"],
            move |(_, published): &Row| pair(&published.accuracy),
        ),
        Column::number(
            "macro F1 %, published",
            &["published_f1_percent", "published_f1_sd"],
            move |(_, published): &Row| pair(published.f1.as_deref().unwrap_or_default()),
        ),
        Column::value(
            "size MB, published",
            "published_megabytes",
            |v| v.to_string(),
            |(_, published): &Row| published.megabytes,
        ),
        Column::value(
            "GFLOPs, published",
            "published_gflops",
            |v| v.to_string(),
            |(_, published): &Row| published.gflops,
        ),
    ];
    if rows.iter().any(|(_, published)| published.seconds.is_some()) {
        columns.push(Column::value(
            "training s, published",
            "published_training_seconds",
            |v| v.to_string(),
            |(_, published): &Row| published.seconds,
        ));
    }
    let caption = "Published by the papers on their own recordings: other data, other machines, not \
                   measured here and not to be compared digit by digit";
    Table::new(table::PUBLISHED, caption.into(), columns, &rows)
}

/// Returns the table of attributes, where there are several.
pub(super) fn attributes(judgement: &Judgement) -> Table {
    type Row<'a> = (&'a str, &'a str, &'a LevelScores);
    let names = &judgement.results.task.attributes();
    let mut rows: Vec<Row> = vec![];
    for n in &judgement.networks {
        let attributes = names.iter().zip(&n.results.attributes);
        rows.extend(
            attributes
                .map(|(attribute, scores)| (n.results.network.as_str(), attribute.name.as_str(), scores)),
        );
    }
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::text("attribute", "attribute", |row: &Row| Cell::text(row.1)),
        Column::value("accuracy %", "accuracy_percent", tenth, |row: &Row| {
            Some(100.0 * row.2.scores.accuracy)
        }),
        Column::value("macro F1 %", "macro_f1_percent", tenth, |row: &Row| Some(100.0 * row.2.scores.f1)),
        Column::value("off by, levels", "mean_absolute_error_levels", digits, |row: &Row| {
            Some(row.2.mean_absolute_error)
        }),
    ];
    let caption = format!("{}: each attribute, all folds together", measured_on(judgement));
    Table::new(table::ATTRIBUTES, caption, columns, &rows)
}

/// Returns the table of all folds.
pub(super) fn folds(judgement: &Judgement) -> Table {
    type Row<'a> = (&'a str, &'a FoldScores);
    let (primary, show) = (judgement.primary(), judgement.primary().show());
    let of = |n: &'_ Judged| n.results.folds.len();
    let mut rows: Vec<Row> = Vec::with_capacity(judgement.networks.iter().map(of).sum());
    for n in &judgement.networks {
        rows.extend(n.results.folds.iter().map(|fold| (n.results.network.as_str(), fold)));
    }
    let mut columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::count("repetition", "repetition", |row: &Row| row.1.repetition as u64),
        Column::count("fold", "fold", |row: &Row| row.1.fold as u64),
        Column::count("trained on", "train_samples", |row: &Row| row.1.train_samples as u64),
        Column::count("tested on", "test_samples", |row: &Row| row.1.test_samples as u64),
        Column::value(&primary.head(), &primary.column(""), show, move |row: &Row| row.1.scores.primary()),
    ];
    columns.extend(others(judgement).into_iter().map(|(head, field, name, show)| {
        Column::value(&head, &field, show, move |row: &Row| row.1.scores.get(name))
    }));
    columns.push(Column::value("loss", "test_loss", digits, |row: &Row| Some(row.1.test_loss)));
    if judgement.results.task.quantities().is_empty() {
        columns.push(Column::value(
            "calibration error %",
            "calibration_error_percent",
            tenth,
            |row: &Row| row.1.scores.get("calibration_error").map(|share| 100.0 * share),
        ));
        columns.push(Column::value("Brier score, 0 to 2", "brier", digits, |row: &Row| {
            row.1.scores.get("brier")
        }));
    }
    if rows.iter().any(|row| row.1.diverged) {
        columns.push(Column::text("diverged", "diverged", |row: &Row| Cell::yes(row.1.diverged, "yes")));
    }
    Table::new(table::FOLDS, format!("{}: every fold", measured_on(judgement)), columns, &rows)
}

/// Returns the table of every class of every network that is tested further.
pub(super) fn classes(judgement: &Judgement) -> Table {
    type Row = (String, String, ClassScores);
    let mut rows: Vec<Row> = vec![];
    for n in judgement.networks.iter().filter(|n| is_shown(judgement, n)) {
        let Some(confusion) = &n.results.confusion else { continue };
        let names = judgement.results.task.output_names();
        let classes = names.iter().zip(confusion.per_class());
        rows.extend(classes.map(|(class, scores)| (n.results.network.clone(), class.clone(), scores)));
    }
    let percent = |value: f64| Cell::number(Some(100.0 * value), tenth);
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(&row.0)),
        Column::text("class", "class", |row: &Row| Cell::text(&row.1)),
        Column::number("precision %", &["precision_percent"], move |row: &Row| percent(row.2.precision)),
        Column::number("recall %", &["recall_percent"], move |row: &Row| percent(row.2.recall)),
        Column::number("F1 %", &["f1_percent"], move |row: &Row| percent(row.2.f1)),
        Column::count("samples", "samples", |row: &Row| row.2.support),
    ];
    let caption = format!("{}: every class, all folds together", measured_on(judgement));
    Table::new(table::CLASSES, caption, columns, &rows)
}

/// Returns the table of every pair of classes that was seen at least once.
pub(super) fn confusion(judgement: &Judgement) -> Table {
    type Row<'a> = (&'a str, &'a str, &'a str, u64);
    let classes = &judgement.results.task.output_names();
    let mut rows: Vec<Row> = vec![];
    for n in judgement.networks.iter().filter(|n| is_shown(judgement, n)) {
        let Some(confusion) = &n.results.confusion else { continue };
        for (truth, counts) in classes.iter().zip(confusion.counts()) {
            let seen = classes.iter().zip(counts).filter(|(_, count)| **count > 0);
            rows.extend(seen.map(|(predicted, count)| {
                (n.results.network.as_str(), truth.as_str(), predicted.as_str(), *count)
            }));
        }
    }
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::text("true class", "true", |row: &Row| Cell::text(row.1)),
        Column::text("predicted class", "predicted", |row: &Row| Cell::text(row.2)),
        Column::count("samples", "samples", |row: &Row| row.3),
    ];
    let caption = format!("{}: what was taken for what, all folds together", measured_on(judgement));
    Table::new(table::CONFUSION, caption, columns, &rows)
}

/// Returns the table of a learning curve.
pub(super) fn few_samples(judgement: &Judgement) -> Table {
    type Row<'a> = (&'a str, usize, &'a Judged);
    let primary = judgement.primary();
    let rows: Vec<Row> = judgement
        .networks
        .iter()
        .filter_map(|n| n.results.per_class.map(|count| (few_samples_of(&n.results), count, n)))
        .collect();
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::count(&format!("training samples per {}", primary.stratum()), "per_class", |row: &Row| {
            row.1 as u64
        }),
        primary_column(&primary, |row: &Row| &row.2.results),
        spread_column(&primary, "repetitions", |row: &Row| &row.2.results),
    ];
    let caption = format!("{}: {} with few training samples", measured_on(judgement), primary.title());
    Table::new(table::FEW_SAMPLES, caption, columns, &rows)
}
