//! What speaks for a choice, and what networks say about examples.

use taxel_report::numbers::{bytes, digits, si, tenth};
use taxel_report::table::{Cell, Column, Table};

use crate::report::names::table;
use crate::values::{Choice, CostKind, Evidence, Example, Judgement, Test, Verdict};

fn interval(value: Option<[f64; 2]>, show: fn(f64) -> String) -> (String, [Option<f64>; 2]) {
    let shown = value.map_or(String::new(), |[low, high]| format!(" [{}, {}]", show(low), show(high)));
    (shown, value.map_or([None, None], |both| both.map(Some)))
}

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
        Column::number(&primary.head(), &[&primary.column("")], move |e: &Evidence| {
            Cell::number(Some(e.score), show)
        }),
        Column::number(
            &format!("{} [95 % interval]", primary.head_of_loss("against the best")),
            &["difference", "difference_low", "difference_high"]
                .map(|name| primary.column_of_loss(name))
                .each_ref()
                .map(String::as_str),
            move |e: &Evidence| {
                let (shown, ends) = interval(e.interval, show);
                Cell::number(Some(e.difference), show).and(shown, &ends)
            },
        ),
        Column::number("p", &["p"], move |e: &Evidence| p(e.p)),
        Column::number("p, Holm", &["p_holm"], move |e: &Evidence| p(e.p_holm)),
        Column::text("worse beyond doubt", "worse", |e: &Evidence| Cell::yes(e.worse, "yes")),
        Column::number(head, &[csv], move |e: &Evidence| Cell::number(e.cost, cost)),
        Column::number(
            &primary.head_of_loss("lost under faults"),
            &[&primary.column_of_loss("mean_fault_loss")],
            move |e: &Evidence| Cell::number(e.mean_loss, show),
        ),
        Column::text("refused because", "refused", |e: &Evidence| {
            Cell::text(e.refused.as_deref().unwrap_or_default())
        }),
    ];
    let test = match choice.test {
        Test::NadeauBengio => "corrected resampled t-test over folds (Nadeau and Bengio 2003)",
        Test::McNemar => "exact McNemar test on the shared test part",
        Test::Wilcoxon => {
            "signed-rank test on the shared test part, by samples or their groups (Wilcoxon 1945)"
        }
    };
    let caption = format!(
        "Each network against {}, the most accurate; {test}, Holm-corrected over the table, level {}",
        choice.best, choice.criteria.alpha
    );
    let chosen = |e: &Evidence| Some(&e.network) == choice.chosen.as_ref();
    let marked = (0..choice.evidence.len()).filter(|&i| chosen(&choice.evidence[i])).collect();
    Table { marked, ..Table::new(table::EVIDENCE, caption, columns, &choice.evidence) }
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
        Column::number("sure to %", &["probability_percent"], |row: &Row| {
            Cell::number(row.1.probability.map(|share| 100.0 * share), tenth)
        }),
        Column::text("right", "right", |row: &Row| {
            row.1.right.map_or_else(|| Cell::text(""), |right| Cell::yes(right, "yes"))
        }),
    ];
    Table::new(table::EXAMPLES, "What the networks say about some test samples".into(), columns, &rows)
}
