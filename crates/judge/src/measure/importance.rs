//! The parts that decisions rest on: the loss of a trained model while parts of its test samples read their mean.

use std::collections::BTreeMap;

use ndarray::Axis;
use rayon::prelude::*;
use taxel_data::Task;
use taxel_learn::metrics::Outcome;
use taxel_learn::{MaskGrid, Masked};

use super::guarding::trained_on;
use super::parts::{BATCH, TestPart, parts};
use super::threads::on;
use crate::case::Case;
use crate::error::Result;
use crate::values::{ClassImportance, Importance};

/// Test samples that are masked at most.
const SAMPLES: usize = 100;
/// Multiply-accumulates of all predictions together, about; large networks get fewer samples.
const WORK: f64 = 5e10;

/// The losses of one sample: its true class, then one for each mask.
struct Losses {
    class: usize,
    of_masks: Vec<f64>,
}

/// Masks the sensors and parts of the window of the test samples of the best row, as the models of its folds see them. None where no row
/// has a score, and for folds that the protocol does not make again.
///
/// # Errors
/// Models that are missing.
pub(super) fn importance(case: &Case, threads: usize) -> Result<Option<Importance>> {
    let primary = case.primary();
    let compared = case.compared();
    let rows = case.results.networks.iter().filter(|row| compared.contains(&row.network.as_str()));
    let scored = rows.filter_map(|row| Some((row, row.primary()?)));
    let best = scored.reduce(|best, row| if primary.prefers(row.1, best.1) { row } else { best });
    let Some((row, _)) = best else { return Ok(None) };
    let grid = MaskGrid::of(&case.dataset.spec);
    let masks = grid.masks(true);
    let each = (masks.len() + 1) as f64 * row.costs.macs.max(1) as f64;
    let most = ((WORK / each) as usize).clamp(1, SAMPLES);
    let (parts, _) = parts(case, &[row.network.as_str()], most)?;
    let mut losses = vec![];
    for part in &parts {
        let Some(key) = part.keys.first() else { continue };
        // Another split: nobody knows what it was trained on.
        let Ok(trained) = trained_on(case, key) else { return Ok(None) };
        losses.extend(of_part(case, part, &trained, (&grid, &masks), threads)?);
    }
    Ok((!losses.is_empty()).then(|| gathered(case, &row.network, &grid, &masks, &losses)))
}

/// Returns the losses of the samples of a part.
fn of_part(
    case: &Case,
    part: &TestPart,
    trained: &[usize],
    (grid, masks): (&MaskGrid, &[Masked]),
    threads: usize,
) -> Result<Vec<Losses>> {
    let dataset = &case.dataset;
    let mut sums = vec![0.0f64; dataset.spec.shape.iter().product()];
    for &row in trained {
        let sample = dataset.x.index_axis(Axis(0), row);
        sums.iter_mut().zip(sample.iter()).for_each(|(sum, value)| *sum += f64::from(*value));
    }
    let mean: Vec<f32> = sums.iter().map(|sum| (sum / trained.len().max(1) as f64) as f32).collect();
    let predictor = case.model(&part.keys[0])?.predictor(BATCH, 1)?;
    let of_sample = |row: &usize| -> Result<Losses> {
        let sample: Vec<f32> = dataset.x.index_axis(Axis(0), *row).iter().copied().collect();
        let outputs = grid.predict(&predictor, &dataset.spec.shape, (&sample, &mean), masks)?.outputs;
        let outcome = Outcome::new(&dataset.targets, &vec![*row; masks.len() + 1], outputs);
        let scores = scores(case, &outcome, masks.len() + 1);
        let class = outcome.labels().0.first().map_or(0, |label| *label as usize);
        Ok(Losses { class, of_masks: scores[1..].iter().map(|score| scores[0] - score).collect() })
    };
    on(threads, || part.rows.par_iter().map(of_sample).collect())
}

/// Returns how good each answer is: the probability of the true class in %, mean over attributes; of values the error with the other
/// sign.
fn scores(case: &Case, outcome: &Outcome, count: usize) -> Vec<f64> {
    let task = case.task();
    match outcome {
        Outcome::Labels { truth, probabilities, .. } => {
            let attributes = task.attributes();
            let (width, outputs) = (attributes.len(), task.outputs());
            let of = |at: usize| {
                let (mut begin, mut sum) = (at * outputs, 0.0);
                for (attribute, label) in attributes.iter().zip(&truth[at * width..]) {
                    sum += f64::from(probabilities[begin + *label as usize]);
                    begin += attribute.classes.len();
                }
                100.0 * sum / width.max(1) as f64
            };
            (0..count).map(of).collect()
        }
        Outcome::Values { .. } => {
            let metric = case.primary().metric();
            let terms = metric.terms(task, outcome).unwrap_or_default();
            terms.iter().map(|term| -metric.unit.scale() * term).collect()
        }
    }
}

fn gathered(case: &Case, network: &str, grid: &MaskGrid, masks: &[Masked], losses: &[Losses]) -> Importance {
    let mean = |samples: &[&Losses], at: usize| {
        samples.iter().map(|losses| losses.of_masks[at]).sum::<f64>() / samples.len().max(1) as f64
    };
    let all: Vec<&Losses> = losses.iter().collect();
    let place = |wanted: Masked| masks.iter().position(|masked| *masked == wanted);
    let rows = (0..grid.rows.len()).map(|row| Masked { row: Some(row), column: None });
    let columns = (0..grid.columns.len()).map(|column| Masked { row: None, column: Some(column) });
    let of = |masked: Masked| place(masked).map(|at| mean(&all, at));
    let mut by_class: BTreeMap<usize, Vec<&Losses>> = BTreeMap::new();
    losses.iter().for_each(|losses| by_class.entry(losses.class).or_default().push(losses));
    let names = match case.task() {
        Task::Classes(classes) => classes.clone(),
        Task::Levels(attributes) => attributes.first().map_or(vec![], |first| first.classes.clone()),
        Task::Values(_) => vec![],
    };
    let cells = |samples: &Vec<&Losses>| -> Vec<Vec<f64>> {
        let cell = |row, column| {
            place(Masked { row: Some(row), column: Some(column) }).map_or(0.0, |at| mean(samples, at))
        };
        (0..grid.rows.len())
            .map(|row| (0..grid.columns.len()).map(|column| cell(row, column)).collect())
            .collect()
    };
    let class = |(class, samples): (&usize, &Vec<&Losses>)| ClassImportance {
        class: names.get(*class).cloned().unwrap_or_default(),
        samples: samples.len(),
        cells: cells(samples),
    };
    Importance {
        network: network.into(),
        samples: losses.len(),
        rows: grid.rows.clone(),
        columns: grid.columns.clone(),
        by_row: rows.filter_map(of).collect(),
        by_column: columns.filter_map(of).collect(),
        classes: by_class.iter().map(class).collect(),
    }
}
