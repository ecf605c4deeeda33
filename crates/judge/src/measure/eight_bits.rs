//! Which predictions eight bits change, sample by sample.

use taxel_learn::FoldRecord;
use taxel_learn::metrics::{Metric, Outcome};

use crate::case::Case;
use crate::values::Changed;

/// Returns one value for each row in eight bits, over the test parts of the first repetition.
pub(super) fn changed(case: &Case) -> Vec<Changed> {
    let rows = case.results.networks.iter().filter_map(|row| Some((row, row.quantized.as_ref()?)));
    let all = rows.map(|(row, floats)| {
        let mut changed = Changed {
            network: row.network.clone(),
            floats: floats.clone(),
            samples: 0,
            differ: 0,
            only: [0; 2],
        };
        for bytes in case.first_repetition(&row.network) {
            let twin = case.first_repetition(floats);
            let same = |other: &&FoldRecord| other.key.fold == bytes.key.fold && other.index == bytes.index;
            if let Some(floats) = twin.into_iter().find(same) {
                match &floats.outcome {
                    Outcome::Labels { .. } => count(floats, bytes, &mut changed),
                    Outcome::Values { .. } => nearer(case, floats, bytes, &mut changed),
                }
            }
        }
        changed
    });
    all.filter(|eight_bits| eight_bits.samples > 0).collect()
}

fn count(floats: &FoldRecord, bytes: &FoldRecord, changed: &mut Changed) {
    let ((truth, before), (_, after)) = (floats.outcome.labels(), bytes.outcome.labels());
    let attributes = (truth.len() / floats.index.len().max(1)).max(1);
    let predictions = before.chunks(attributes).zip(after.chunks(attributes));
    for ((before, after), truth) in predictions.zip(truth.chunks(attributes)) {
        changed.samples += 1;
        changed.differ += u64::from(before != after);
        changed.only[0] += u64::from(before == truth && after != truth);
        changed.only[1] += u64::from(before != truth && after == truth);
    }
}

/// Counts the samples whose values differ, and those that one of the two comes nearer to.
fn nearer(case: &Case, floats: &FoldRecord, bytes: &FoldRecord, changed: &mut Changed) {
    let (task, metric) = (case.task(), Metric::primary(case.task()));
    let terms = |record: &FoldRecord| metric.terms(task, &record.outcome).unwrap_or_default();
    let width = task.outputs().max(1);
    let rows = floats.outcome.outputs().chunks(width).zip(bytes.outcome.outputs().chunks(width));
    for ((before, after), (a, b)) in rows.zip(terms(floats).into_iter().zip(terms(bytes))) {
        changed.samples += 1;
        changed.differ += u64::from(before != after);
        changed.only[0] += u64::from(metric.prefers(a, b));
        changed.only[1] += u64::from(metric.prefers(b, a));
    }
}
