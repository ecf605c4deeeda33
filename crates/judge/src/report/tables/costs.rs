//! Costs of networks: time, size, training; and how far training changed the weights.

use taxel_report::numbers::{bytes, digits, si};
use taxel_report::table::{Cell, Column, Table};

use super::scores::name;
use crate::report::names::table;
use crate::values::{EpochPoint, Judged, Judgement, Speed};

pub(super) fn speed(judgement: &Judgement) -> Table {
    let rows: Vec<Judged> = judgement.networks.iter().filter(|n| n.speed.is_some()).cloned().collect();
    let of = |head: &'static str, csv: &'static str, value: fn(&Speed) -> f64| {
        Column::value(head, csv, digits, move |n: &Judged| n.speed.as_ref().map(value))
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
        Column::value("training per fold, s", "train_seconds", digits, |n: &Judged| Some(n.train_seconds)),
        Column::value("per epoch, s", "epoch_seconds", digits, |n: &Judged| n.epoch_seconds),
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
        Column::count("parameters", "parameters", |n: &Judged| n.results.costs.parameters),
        Column::value("size", "bytes", bytes, |n: &Judged| Some(n.results.costs.bytes as f64)),
        Column::value("MACs", "macs", si, |n: &Judged| Some(n.results.costs.macs as f64)),
        Column::value("FLOPs", "flops", si, |n: &Judged| Some(n.results.costs.flops as f64)),
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
        Column::count("epoch", "epoch", |row: &Row| row.1.epoch as u64 + 1),
        Column::value("training loss", "train_loss", digits, |row: &Row| Some(row.1.train_loss)),
        Column::value(
            &format!("training {}", primary.head()),
            &format!("train_{}", primary.column("")),
            show,
            move |row: &Row| Some(row.1.train_score),
        ),
        Column::value("validation loss", "validation_loss", digits, |row: &Row| row.1.validation_loss),
        Column::value(
            &format!("validation {}", primary.head()),
            &format!("validation_{}", primary.column("")),
            show,
            move |row: &Row| row.1.validation_score,
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
        Column::value(
            "mean squared change",
            "change",
            |v| format!("{v:.3e}"),
            |row: &Row| Some(row.1.change),
        ),
    ];
    let caption = "How much training changed the kernels of each convolution, both scaled to 0 to 1, mean \
                   over folds (Rouhafzay et al. 2021, Figs. 3 and 4)";
    Table::new(table::WEIGHT_CHANGES, caption.into(), columns, &rows)
}
