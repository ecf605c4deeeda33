//! Evidence for a choice, and predictions for examples.

use taxel_report::numbers::{bytes, digits, in_brackets, si, tenth};
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::{Choice, CostKind, Evidence, Example, Judgement, Test, Verdict};

pub(super) fn choice(choice: &Choice) -> Table {
    let p = |value: Option<f64>| {
        Cell::number(value, |v| if v < 1e-4 { "< 0.0001".into() } else { format!("{v:.4}") })
    };
    let by = choice.criteria.cost;
    let (head, csv) = match by {
        CostKind::Latency => ("latency, ms", "latency_ms"),
        CostKind::Size => ("size", "bytes"),
        CostKind::Macs => ("MACs", "macs"),
    };
    let cost = move |value: f64| match by {
        CostKind::Latency => digits(value),
        CostKind::Size => bytes(value),
        CostKind::Macs => si(value),
    };
    let primary = &choice.primary;
    let show = primary.show();
    let columns = vec![
        Column::text("network", "network", |e: &Evidence| Cell::text(&e.network)),
        Column::value(&primary.head(), &primary.column(""), show, move |e: &Evidence| Some(e.score)),
        Column::number(
            &format!("{} [95 % interval]", primary.head_of_loss("against the best")),
            &["difference", "difference_low", "difference_high"]
                .map(|name| primary.column_of_loss(name))
                .each_ref()
                .map(String::as_str),
            move |e: &Evidence| {
                Cell::number(Some(e.difference), show).interval(e.interval, in_brackets(show))
            },
        ),
        Column::number("p", &["p"], move |e: &Evidence| p(e.p)),
        Column::number("p, Holm", &["p_holm"], move |e: &Evidence| p(e.p_holm)),
        Column::text("worse beyond doubt", "worse", |e: &Evidence| Cell::yes(e.worse, "yes")),
        Column::value(head, csv, cost, move |e: &Evidence| e.cost),
        Column::value(
            &primary.head_of_loss("lost under faults"),
            &primary.column_of_loss("mean_fault_loss"),
            show,
            move |e: &Evidence| e.mean_loss,
        ),
        Column::text("broken at severity 1 by", "breaks_at_1", |e: &Evidence| {
            Cell::text(e.breaks_at_1.iter().map(|fault| fault.name()).collect::<Vec<_>>().join(", "))
        }),
        Column::text("refused because", "refused", |e: &Evidence| {
            Cell::text(e.refused.as_deref().unwrap_or_default())
        }),
    ];
    let test = words(choice.test);
    let other = choice.evidence.iter().any(|e| e.test.is_some_and(|test| test != choice.test));
    let alike = if other { "; where all folds differ alike, a test on all samples together" } else { "" };
    let caption = format!(
        "Each network against {}, the most accurate; {test}{alike}, Holm-corrected over the table, level {}",
        choice.best, choice.criteria.alpha
    );
    let chosen = |e: &Evidence| Some(&e.network) == choice.chosen.as_ref();
    let marked = (0..choice.evidence.len()).filter(|&i| chosen(&choice.evidence[i])).collect();
    Table { marked, ..Table::new(table::EVIDENCE, caption, columns, &choice.evidence) }
}

/// Returns a test with its source.
fn words(test: Test) -> &'static str {
    match test {
        Test::NadeauBengio => "corrected resampled t-test over folds (Nadeau and Bengio 2003)",
        Test::FreshWorlds => "paired t-test over simulated worlds",
        Test::McNemar => "exact McNemar test on all test samples, each counted once",
        Test::GroupedPairs => {
            "t-test on the paired differences of grouped test samples (Durkalski et al. 2003)"
        }
        Test::Wilcoxon => "signed-rank test on all test samples, or on their groups (Wilcoxon 1945)",
    }
}

pub(super) fn examples(judgement: &Judgement) -> Table {
    type Row<'a> = (&'a Example, &'a Verdict);
    let mut rows: Vec<Row> = vec![];
    for example in &judgement.examples {
        rows.extend(example.verdicts.iter().map(|verdict| (example, verdict)));
    }
    let columns = vec![
        Column::text("sample", "sample", |row: &Row| Cell::text(&row.0.origin)),
        Column::text("true", "true", |row: &Row| Cell::text(&row.0.truth)),
        Column::text("network", "network", |row: &Row| Cell::text(&row.1.network)),
        Column::text("says", "predicted", |row: &Row| Cell::text(&row.1.predicted)),
        Column::value("sure to %", "probability_percent", tenth, |row: &Row| {
            row.1.probability.map(|share| 100.0 * share)
        }),
        Column::text("right", "right", |row: &Row| {
            row.1.right.map_or_else(|| Cell::text(""), |right| Cell::yes(right, "yes"))
        }),
    ];
    Table::new(table::EXAMPLES, "What the networks say about some test samples".into(), columns, &rows)
}
