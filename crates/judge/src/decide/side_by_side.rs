//! Two models, or rows of runs, on the same samples: how far apart they are, and where.

use std::collections::{BTreeMap, BTreeSet};

use taxel_data::{Dataset, Task};
use taxel_learn::metrics::Outcome;
use taxel_learn::{FoldKey, FoldRecord, Protocol};

use super::comparison::Comparison;
use super::places::{places, right};
use super::statistics::samples_to_decide;
use crate::error::Result;
use crate::values::{Primary, SideBySide, SideCosts, Test};

/// Level of significance, and the share of cases in which a difference that is there is to be found.
const ALPHA: f64 = 0.05;
const POWER: f64 = 0.8;

/// One of the two: a name, what it predicted, what it costs.
#[derive(Debug, Clone)]
pub struct Side {
    /// Its name.
    pub name: String,
    /// Its predictions: folds of a run, or one record of a model.
    pub records: Vec<FoldRecord>,
    /// Its costs.
    pub costs: SideCosts,
}

impl Side {
    /// Takes the predictions `outcome` of a model for all samples of a data set, `trained` samples behind them.
    pub fn of_model(
        name: &str,
        dataset: &Dataset,
        outcome: Outcome,
        trained: usize,
        costs: SideCosts,
    ) -> Self {
        let key = FoldKey { network: name.into(), repetition: 0, fold: 0 };
        let index: Vec<usize> = (0..dataset.len()).collect();
        let record = FoldRecord::of_predictions(key, trained, index, outcome);
        Side { name: name.into(), records: vec![record], costs }
    }
}

/// Compares two on the samples of `dataset` that both predicted, with targets of `task`: over the parts that they share as wholes, and
/// over single samples where they share none. None where they share no sample.
///
/// # Errors
/// None that records of a run cause.
pub fn side_by_side(
    dataset: &Dataset,
    task: &Task,
    (protocol, seed): (&Protocol, u64),
    sides: [Side; 2],
) -> Result<Option<SideBySide>> {
    let [a, b] = sides;
    let names = [a.name, b.name];
    // Rows of two runs may have one name.
    let keys = ["a".to_string(), "b".to_string()];
    let Some(records) = aligned(a.records, b.records, task) else { return Ok(None) };
    let parts = records[0].len();
    let pairs: Vec<(FoldRecord, FoldRecord)> = records[0].iter().cloned().zip(records[1].clone()).collect();
    let comparison = Comparison {
        networks: keys.iter().cloned().zip(records).collect(),
        clusters: dataset.clusters(),
        is_grouped: dataset.groups.is_some(),
        task: task.clone(),
        protocol: protocol.clone(),
        seed,
    };
    let Some((effect, test)) = comparison.tested(&keys[0], &keys[1], None)? else { return Ok(None) };
    let primary = Primary::of(task);
    let (first, second) = comparison.values(&keys[0], &keys[1], |part| part.score());
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len().max(1) as f64;
    let tested: BTreeSet<usize> = pairs.iter().flat_map(|(a, _)| a.index.iter().copied()).collect();
    let group = |row: &usize| dataset.groups.as_ref().map(|groups| groups[*row]);
    let groups = tested.iter().filter_map(group).collect::<BTreeSet<u32>>().len();
    // Where samples of one group are on both sides of a cut, it is samples that are drawn.
    let by_group = groups > 0 && (test == Test::GroupedPairs || protocol.keeps_groups());
    let units = if by_group { groups } else { tested.len() };
    let is_open = effect.p.is_none_or(|p| p >= ALPHA);
    let needed = || samples_to_decide(units as u64, effect.size, effect.interval?, ALPHA, POWER);
    Ok(Some(SideBySide {
        names,
        samples: tested.len(),
        groups: (groups > 0).then_some(groups),
        parts,
        scores: [mean(&first), mean(&second)],
        difference: effect.size,
        interval: effect.interval,
        p: effect.p,
        test,
        deciding: if is_open { needed() } else { None },
        deciding_groups: by_group,
        right: right(task, &pairs),
        places: places(task, &pairs),
        primary,
        costs: [a.costs, b.costs],
    }))
}

/// Returns the records of both over the same parts: their shared ones, or one part of the samples that both tested in their first
/// repetition.
fn aligned(a: Vec<FoldRecord>, b: Vec<FoldRecord>, task: &Task) -> Option<[Vec<FoldRecord>; 2]> {
    let place = |record: &FoldRecord| (record.key.repetition, record.key.fold);
    let twin = |record: &FoldRecord| {
        b.iter().find(|other| place(other) == place(record) && other.index == record.index)
    };
    let shared: Vec<(FoldRecord, FoldRecord)> =
        a.iter().filter_map(|record| Some((record.clone(), twin(record)?.clone()))).collect();
    let whole = shared.len() == a.len().min(b.len());
    if whole && !shared.is_empty() {
        let (a, b) = shared.into_iter().unzip();
        return Some([a, b]);
    }
    let (a, b) = (by_sample(&a), by_sample(&b));
    let common: Vec<usize> = a.keys().filter(|row| b.contains_key(row)).copied().collect();
    (!common.is_empty()).then(|| [a, b].map(|each| vec![gathered(&each, &common, task)]))
}

/// Returns where each sample stands in the records of the first repetition: the record and its row.
fn by_sample(records: &[FoldRecord]) -> BTreeMap<usize, (&FoldRecord, usize)> {
    let first = records.iter().filter(|record| record.key.repetition == 0);
    first
        .flat_map(|record| record.index.iter().enumerate().map(move |(row, sample)| (*sample, (record, row))))
        .collect()
}

/// Returns one record of the samples `common`, in their order.
fn gathered(from: &BTreeMap<usize, (&FoldRecord, usize)>, common: &[usize], task: &Task) -> FoldRecord {
    let rows: Vec<(&FoldRecord, usize)> = common.iter().map(|sample| from[sample]).collect();
    let width = if task.quantities().is_empty() { task.attributes().len() } else { task.outputs() };
    fn cut<T: Copy>(all: &[T], row: usize, width: usize) -> Vec<T> {
        all.get(row * width..(row + 1) * width).map_or(vec![], <[T]>::to_vec)
    }
    let labels = |of: fn(&Outcome) -> &[u32]| -> Vec<u32> {
        rows.iter().flat_map(|(record, row)| cut(of(&record.outcome), *row, width)).collect()
    };
    let outputs: Vec<f32> =
        rows.iter().flat_map(|(record, row)| cut(record.outcome.outputs(), *row, task.outputs())).collect();
    let outcome = if task.quantities().is_empty() {
        Outcome::Labels {
            truth: labels(|outcome| outcome.labels().0),
            predicted: labels(|outcome| outcome.labels().1),
            probabilities: outputs,
            untrained: vec![],
            steps: None,
        }
    } else {
        let truth = |outcome: &Outcome, row: usize| cut(outcome.values().0, row, width);
        let truth = rows.iter().flat_map(|(record, row)| truth(&record.outcome, *row)).collect();
        Outcome::Values { truth, predicted: outputs, spread: vec![] }
    };
    let trained = rows.first().map_or(0, |(record, _)| record.train_samples);
    let key = FoldKey { network: String::new(), repetition: 0, fold: 0 };
    FoldRecord::of_predictions(key, trained, common.to_vec(), outcome)
}
