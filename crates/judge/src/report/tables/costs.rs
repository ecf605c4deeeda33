//! What networks cost: time, size, training; and what training changed.

use taxel_report::numbers::{bytes, digits, si};
use taxel_report::table::{Cell, Column, Table};

use super::scores::name;
use crate::report::names::table;
use crate::values::{EpochPoint, Judged, Judgement, Speed};

pub(super) fn speed(judgement: &Judgement) -> Table {
    let rows: Vec<Judged> = judgement.networks.iter().filter(|n| n.speed.is_some()).cloned().collect();
    let of = |head: &'static str, csv: &'static str, value: fn(&Speed) -> f64| {
        Column::number(head, &[csv], move |n: &Judged| Cell::number(n.speed.as_ref().map(value), digits))
    };
    let count = |head: &'static str, csv: &'static str, value: fn(&Speed) -> usize| {
        let cell =
            move |n: &Judged| n.speed.as_ref().map_or(Cell::count(0), |s| Cell::count(value(s) as u64));
        Column::number(head, &[csv], cell)
    };
    let columns = vec![
        name("network"),
        of("encoding p50, ms", "encoding_p50_ms", |s| s.encoding.p50_ms),
        of("network p50, ms", "network_p50_ms", |s| s.network.p50_ms),
        of("network p95, ms", "network_p95_ms", |s| s.network.p95_ms),
        of("whole p50, ms", "whole_p50_ms", |s| s.whole.p50_ms),
        of("whole p95, ms", "whole_p95_ms", |s| s.whole.p95_ms),
        count("timed runs", "runs", |s| s.whole.runs),
        of("samples per second in batches", "samples_per_second", |s| s.samples_per_second),
        count("batch", "batch", |s| s.batch),
        Column::number("training per fold, s", &["train_seconds"], |n: &Judged| {
            Cell::number(Some(n.train_seconds), digits)
        }),
        Column::number("per epoch, s", &["epoch_seconds"], |n: &Judged| {
            Cell::number(n.epoch_seconds, digits)
        }),
    ];
    let on = &judgement.judged_on;
    let machine = on.processor().unwrap_or(on.platform.clone());
    let then = judgement.environment.threads;
    let caption = format!(
        "Measured on {machine}, one thread; training was timed when the run was made ({then} threads)"
    );
    Table::new(table::SPEED, caption, columns, &rows)
}

pub(super) fn size(judgement: &Judgement) -> Table {
    let columns = vec![
        name("network"),
        Column::text("in the zoo", "zoo", |n: &Judged| Cell::text(&n.results.zoo)),
        Column::text("from", "paper", |n: &Judged| Cell::text(&n.results.paper)),
        Column::text("reads", "inputs", |n: &Judged| Cell::text(n.inputs.join(", "))),
        Column::number("parameters", &["parameters"], |n: &Judged| Cell::count(n.results.costs.parameters)),
        Column::number("size", &["bytes"], |n: &Judged| {
            Cell::number(Some(n.results.costs.bytes as f64), bytes)
        }),
        Column::number("MACs", &["macs"], |n: &Judged| Cell::number(Some(n.results.costs.macs as f64), si)),
        Column::number("FLOPs", &["flops"], |n: &Judged| {
            Cell::number(Some(n.results.costs.flops as f64), si)
        }),
    ];
    let caption = "Counted, not measured: the same on every machine; size: parameters and statistics in f32";
    Table::new(table::COSTS, caption.into(), columns, &judgement.networks)
}

pub(super) fn training(judgement: &Judgement) -> Table {
    let (primary, show) = (judgement.primary(), judgement.primary().show());
    type Row<'a> = (&'a str, EpochPoint);
    let mut rows: Vec<Row> = vec![];
    for n in &judgement.networks {
        rows.extend(n.training.iter().map(|point| (n.results.network.as_str(), *point)));
    }
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::number("epoch", &["epoch"], |row: &Row| Cell::count(row.1.epoch as u64 + 1)),
        Column::number("training loss", &["train_loss"], |row: &Row| {
            Cell::number(Some(row.1.train_loss), digits)
        }),
        Column::number(
            &format!("training {}", primary.head()),
            &[&format!("train_{}", primary.column(""))],
            move |row: &Row| Cell::number(Some(row.1.train_score), show),
        ),
        Column::number("validation loss", &["validation_loss"], |row: &Row| {
            Cell::number(row.1.validation_loss, digits)
        }),
        Column::number(
            &format!("validation {}", primary.head()),
            &[&format!("validation_{}", primary.column(""))],
            move |row: &Row| Cell::number(row.1.validation_score, show),
        ),
    ];
    Table::new(table::TRAINING, "Training, epoch by epoch, mean over folds".into(), columns, &rows)
}

pub(super) fn weight_changes(judgement: &Judgement) -> Table {
    type Row<'a> = (&'a str, &'a taxel_learn::Change);
    let mut rows: Vec<Row> = vec![];
    for n in &judgement.networks {
        rows.extend(n.results.changes.iter().map(|change| (n.results.network.as_str(), change)));
    }
    let columns = vec![
        Column::text("network", "network", |row: &Row| Cell::text(row.0)),
        Column::text("layer", "layer", |row: &Row| Cell::text(&row.1.layer)),
        Column::number("mean squared change", &["change"], |row: &Row| {
            Cell::number(Some(row.1.change), |v| format!("{v:.3e}"))
        }),
    ];
    let caption = "How much training changed the kernels of each convolution, both scaled to 0 to 1, mean \
                   over folds (paper 001, Figs. 3 and 4)";
    Table::new(table::WEIGHT_CHANGES, caption.into(), columns, &rows)
}
