//! `results.json`, `metrics.jsonl`, `timings.jsonl` and `predictions.npz` from the finished folds.

use std::path::Path;

use serde_json::{Map, Value, json};
use taxel_data::{Npz, Task};

use crate::error::{Error, Result};
use crate::json_file::{write_atomic, write_json};
use crate::metrics::{Metric, Outcome};
use crate::run::folder::RunFolder;
use crate::run::records::{FoldKey, FoldRecord, Timing};
use crate::run::results::{Results, ScoringContext};

/// Puts the finished folds, in the order of the run, into the results.
///
/// # Errors
/// Records that do not fit the data.
pub(crate) fn fill(
    results: &mut Results,
    all: &[FoldKey],
    records: &[FoldRecord],
    frame: &ScoringContext,
) -> Result<()> {
    for network in &mut results.networks {
        let of_row: Vec<&FoldRecord> = records.iter().filter(|r| r.key.network == network.network).collect();
        network.fill(&of_row, frame)?;
    }
    results.missing = all.iter().filter(|key| !records.iter().any(|r| r.key == **key)).cloned().collect();
    results.complete = results.missing.is_empty();
    Ok(())
}

/// Writes everything that follows from the finished folds; `records` are in the order of the run.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn assemble(
    folder: &RunFolder,
    results: &Results,
    records: &[FoldRecord],
    timings: &[Timing],
) -> Result<()> {
    let mut lines = vec![];
    for record in records {
        metric_lines(record, &results.task, &mut lines)?;
    }
    write_lines(&folder.file("metrics.jsonl"), &lines)?;
    write_lines(&folder.file("timings.jsonl"), &timing_lines(timings))?;
    write_predictions(&folder.file("predictions.npz"), results, records)?;
    // Last: what it calls complete is there.
    write_json(&folder.file("results.json"), results, true).map(|_| ())
}

fn metric_lines(record: &FoldRecord, task: &Task, lines: &mut Vec<Value>) -> Result<()> {
    let test = record.scores(task)?;
    let primary = Metric::primary(task).name;
    for (i, epoch) in record.epochs.iter().enumerate() {
        let mut line = key_fields(&record.key);
        line.insert("epoch".into(), json!(epoch.epoch));
        line.insert("lr".into(), json!(epoch.lr));
        line.insert("train_loss".into(), json!(epoch.train_loss));
        line.insert(format!("train_{primary}"), json!(epoch.train_score));
        if let (Some(loss), Some(score)) = (epoch.validation_loss, epoch.validation_score) {
            line.insert("validation_loss".into(), json!(loss));
            line.insert(format!("validation_{primary}"), json!(score));
        }
        // Test samples are looked at once, after training: nothing can be picked by them.
        if i + 1 == record.epochs.len() {
            line.insert("test_loss".into(), json!(record.test_loss));
            for (name, value) in test.iter() {
                line.insert(format!("test_{name}"), json!(value));
            }
        }
        lines.push(Value::Object(line));
    }
    Ok(())
}

fn timing_lines(timings: &[Timing]) -> Vec<Value> {
    let mut lines = vec![];
    for timing in timings {
        let mut line = key_fields(&timing.key);
        line.insert("train_seconds".into(), json!(timing.train_seconds));
        line.insert("samples".into(), json!(timing.samples));
        line.insert("samples_per_second".into(), json!(timing.samples_per_second()));
        line.insert("test_seconds".into(), json!(timing.test_seconds));
        line.insert("threads".into(), json!(timing.threads));
        line.insert("encoding_ms_per_sample".into(), json!(timing.encoding_ms_per_sample));
        lines.push(Value::Object(line));
    }
    for timing in timings {
        if let Some(latency) = timing.latency {
            lines.push(json!({
                "network": timing.key.network,
                "latency_p50_ms": latency.p50_ms,
                "latency_p95_ms": latency.p95_ms,
                "latency_runs": latency.runs,
                "latency_batch": 1,
                "latency_threads": 1,
                "encoding_ms_per_sample": timing.encoding_ms_per_sample,
            }));
        }
    }
    lines
}

fn key_fields(key: &FoldKey) -> Map<String, Value> {
    let mut line = Map::new();
    line.insert("network".into(), json!(key.network));
    line.insert("repetition".into(), json!(key.repetition));
    line.insert("fold".into(), json!(key.fold));
    line
}

fn write_lines(path: &Path, lines: &[Value]) -> Result<()> {
    let mut text = String::new();
    for line in lines {
        text.push_str(&line.to_string());
        text.push('\n');
    }
    write_atomic(path, text.as_bytes())
}

/// Writes per network arrays `index`, `fold`, `repetition`, `true`, `predicted` `[n]` (the last two `[n, attributes]` or
/// `[n, quantities]` where there are several), and of labels `probabilities` `[n, outputs]`, folds one after the other.
fn write_predictions(path: &Path, results: &Results, records: &[FoldRecord]) -> Result<()> {
    let io = |e| Error::io(path, "written", e);
    let mut archive = Npz::default();
    for network in &results.networks {
        let of_row: Vec<&FoldRecord> = records.iter().filter(|r| r.key.network == network.network).collect();
        let each = |value: fn(&FoldKey) -> usize| -> Vec<u32> {
            of_row.iter().flat_map(|r| std::iter::repeat_n(value(&r.key) as u32, r.index.len())).collect()
        };
        let index: Vec<u32> = of_row.iter().flat_map(|r| r.index.iter().map(|&i| i as u32)).collect();
        let n = index.len();
        let name = |array: &str| format!("{}.{array}", network.network);
        for (array, values) in
            [("index", index), ("fold", each(|key| key.fold)), ("repetition", each(|key| key.repetition))]
        {
            archive.add(&name(array), &[n], &values).map_err(io)?;
        }
        let shape = |values: usize| if values == n { vec![n] } else { vec![n, values / n] };
        let Outcomes { labels, values, probabilities } = Outcomes::of(&of_row);
        let is_labels = results.task.quantities().is_empty();
        for (array, (labels, values)) in ["true", "predicted"].into_iter().zip(labels.iter().zip(&values)) {
            let added = if is_labels {
                archive.add(&name(array), &shape(labels.len()), labels)
            } else {
                archive.add(&name(array), &shape(values.len()), values)
            };
            added.map_err(io)?;
        }
        if is_labels {
            let shape = [n, results.task.outputs()];
            archive.add(&name("probabilities"), &shape, &probabilities).map_err(io)?;
        }
    }
    write_atomic(path, &archive.finish().map_err(io)?)
}

/// Outcomes of folds one after the other: true and predicted labels or values, and probabilities of labels.
#[derive(Default)]
struct Outcomes {
    labels: [Vec<u32>; 2],
    values: [Vec<f32>; 2],
    probabilities: Vec<f32>,
}

impl Outcomes {
    fn of(records: &[&FoldRecord]) -> Self {
        let mut all = Outcomes::default();
        for record in records {
            match &record.outcome {
                Outcome::Labels { truth, predicted, probabilities, .. } => {
                    all.labels[0].extend(truth);
                    all.labels[1].extend(predicted);
                    all.probabilities.extend(probabilities);
                }
                Outcome::Values { truth, predicted, .. } => {
                    all.values[0].extend(truth);
                    all.values[1].extend(predicted);
                }
            }
        }
        all
    }
}
