//! A row of a run on fewer and fewer training recordings: what more of them would bring.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Fold, Task};
use taxel_judge::statistics::power_law;
use taxel_judge::{Case, CurvePoint, LearningCurve, Primary};
use taxel_learn::{FoldRecord, Progress, shuffled};
use taxel_trainer::{Experiment, Variant};
use taxel_zoo::Registry;

use crate::cache::{Cache, Request};
use crate::error::{Error, Result};

/// Shares of a training part that are learned from, besides the whole, of which the run has the scores.
const SHARES: [f64; 3] = [0.125, 0.25, 0.5];
/// The least recordings of the largest class of a training part, for an eighth to say anything.
const LEAST: usize = 8;
/// Most folds that are used.
const MOST_FOLDS: usize = 10;
/// Folder of the records below a run folder.
const RECORDS: &str = "learning-curve";
/// Numbers these trainings apart from all others, for their random choices.
const APART: usize = 2_000_000;

/// Trains a network or baseline of a run on an eighth, a quarter and half of each training part, tests it on the run's own test
/// parts, and fits a power law to the scores. Nothing is chosen by it, so test parts stay fair.
///
/// Whole recordings are drawn, of each class the same share, the smaller sets inside the larger ones; groups are not kept apart, so
/// the law is that of more recordings of the same groups. Finished trainings are kept in the run folder and made once.
///
/// # Errors
/// A run that is a learning curve itself or of another split, too few recordings, [`Error::Stopped`] if `cancel` was set.
pub fn learning_curve(
    (case, experiment, registry): (&Case, &Experiment, &Registry),
    network: &str,
    threads: usize,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<LearningCurve> {
    let parts = parts(case, network)?;
    let (dataset, changes) = (&case.dataset, Variant::default());
    let records = case.folder.file(RECORDS);
    std::fs::create_dir_all(&records).map_err(|e| Error::file(&records, format!("cannot be made: {e}")))?;
    let mut cache = Cache::new((experiment, registry, dataset), records, threads, progress, cancel);
    cache.expect(SHARES.len() * parts.len());
    let seen = |(record, fold): &(FoldRecord, Fold)| record.epochs.len().max(1) * fold.train.len();
    let work: usize = parts.iter().map(seen).sum();
    progress.start((work as f64 * SHARES.iter().sum::<f64>()) as u64);
    let mut points = vec![];
    for share in SHARES {
        let label = format!("{network} on {:.0} %", 100.0 * share);
        let mut scores = vec![];
        let mut counts = vec![];
        for (record, fold) in &parts {
            let train = drawn(dataset, &fold.train, share, experiment.config().seed);
            counts.push(counted(dataset, &train));
            let fold = Fold { train, ..fold.clone() };
            let place = (record.key.repetition, APART + record.key.fold);
            let request = Request {
                name: network,
                label: &label,
                changes: &changes,
                place,
                fold: &fold,
                teacher: None,
            };
            let tested = cache.predictions(request);
            let tested = tested.inspect_err(|_| progress.finish())?;
            scores.push(score(&tested, case.task())?);
        }
        points.push(point(&counts, scores));
    }
    progress.finish();
    let counts: Vec<f64> = parts.iter().map(|(_, fold)| counted(dataset, &fold.train)).collect();
    let whole = parts.iter().map(|(record, _)| score(record, case.task())).collect::<Result<_>>()?;
    points.push(point(&counts, whole));
    let primary = case.primary();
    let error = |score: f64| if primary.is_percent() { 100.0 - score } else { score };
    let ratio =
        |(record, fold): &(FoldRecord, Fold)| record.index.len() as f64 / fold.train.len().max(1) as f64;
    let ratio = parts.iter().map(ratio).sum::<f64>() / parts.len() as f64;
    let last = points[points.len() - 1].count;
    let law = power_law(&points, error, ratio, &[round(last / 4.0), round(last)])?;
    Ok(LearningCurve { network: network.into(), per: per(&primary, case.task()).into(), points, law })
}

/// Returns the folds of a run that are used, divided again as it was divided.
fn parts(case: &Case, network: &str) -> Result<Vec<(FoldRecord, Fold)>> {
    if case.results.protocol.per_class().is_some() {
        return Err(Error::file(case.folder.path(), "is a learning curve itself (protocol.per_class)"));
    }
    let mut parts = vec![];
    let (protocol, seed) = (&case.results.protocol, case.results.seed);
    for record in case.records(network).take(MOST_FOLDS) {
        let all = protocol.folds(&case.dataset, seed, record.key.repetition)?;
        let same = |fold: &&Fold| fold.test == record.index;
        let fold = all.get(record.key.fold).filter(same).cloned().ok_or_else(|| {
            Error::file(case.folder.path(), format!("fold {} is of another split; run it again", record.key))
        })?;
        parts.push((record.clone(), fold));
    }
    let most = parts.iter().map(|(_, fold)| largest_class(&case.dataset, &fold.train)).min().unwrap_or(0);
    if parts.is_empty() {
        return Err(Error::value("network", format!("{network:?}"), "has no finished fold; resume the run"));
    }
    if most < LEAST {
        let reason =
            format!("has {most} recordings of its largest class in a training part, and {LEAST} are needed");
        return Err(Error::file(case.folder.path(), format!("a learning curve: {reason}")));
    }
    Ok(parts)
}

/// Returns the whole recordings, or sets of copies, of each class among rows: class, then rows by recording.
fn units(dataset: &Dataset, rows: &[usize]) -> BTreeMap<u32, BTreeMap<u32, Vec<usize>>> {
    let strata = dataset.strata();
    let mut found: BTreeMap<u32, BTreeMap<u32, Vec<usize>>> = BTreeMap::new();
    for &row in rows {
        let unit = dataset.units.as_ref().map_or(row as u32, |units| units[row]);
        found.entry(strata[row]).or_default().entry(unit).or_default().push(row);
    }
    found
}

fn largest_class(dataset: &Dataset, rows: &[usize]) -> usize {
    units(dataset, rows).values().map(BTreeMap::len).max().unwrap_or(0)
}

/// Draws this share of the recordings of each class, one at least; those of a smaller share are among those of a larger one.
fn drawn(dataset: &Dataset, rows: &[usize], share: f64, seed: u64) -> Vec<usize> {
    let mut taken = vec![];
    for (class, units) in units(dataset, rows) {
        let count = ((share * units.len() as f64).round() as usize).max(1);
        let names: Vec<usize> = units.keys().map(|unit| *unit as usize).collect();
        let order = shuffled(&names, seed, APART, class as usize, 0);
        taken.extend(order.iter().take(count).flat_map(|unit| units[&(*unit as u32)].iter().copied()));
    }
    taken.sort_unstable();
    taken
}

/// Counts the recordings of a class, mean over the classes; of values all of them.
fn counted(dataset: &Dataset, rows: &[usize]) -> f64 {
    let units = units(dataset, rows);
    let all: usize = units.values().map(BTreeMap::len).sum();
    match dataset.task() {
        Task::Classes(classes) => all as f64 / classes.len().max(1) as f64,
        Task::Levels(_) | Task::Values(_) => all as f64,
    }
}

/// Returns the thing that a count is of.
fn per(primary: &Primary, task: &Task) -> &'static str {
    match task {
        Task::Classes(_) => primary.stratum(),
        Task::Levels(_) | Task::Values(_) => "",
    }
}

fn point(counts: &[f64], scores: Vec<f64>) -> CurvePoint {
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len().max(1) as f64;
    CurvePoint { count: mean(counts), score: mean(&scores), scores }
}

/// Returns the primary metric of a fold.
fn score(record: &FoldRecord, task: &Task) -> Result<f64> {
    let scores = record.scores(task)?;
    let unfinished =
        || Error::value("network", format!("{:?}", record.key.network), "has a fold without a score");
    scores.primary().filter(|score| score.is_finite()).ok_or_else(unfinished)
}

/// Rounds a number of recordings to one that people say: 1, 2, 5, 10, 20, 50 ...
fn round(count: f64) -> f64 {
    let ten = 10f64.powf(count.max(1.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|step| step * ten)
        .into_iter()
        .min_by(|a, b| (a - count).abs().total_cmp(&(b - count).abs()))
        .unwrap_or(ten)
}

#[cfg(test)]
mod tests {
    use super::*;
    use taxel_data::Layout;

    fn presses() -> Dataset {
        let x = ndarray::ArrayD::zeros(vec![40, 1, 4]);
        let labels: Vec<&str> = (0..40).map(|press| if press < 24 { "soft" } else { "hard" }).collect();
        let mut dataset = Dataset::new("presses", Layout::Series, x, &labels).unwrap();
        dataset.units = Some((0..40).map(|press| press / 2).collect());
        dataset
    }

    #[test]
    fn smaller_sets_of_whole_recordings_are_inside_larger_ones() {
        let (dataset, rows) = (presses(), (0..40).collect::<Vec<_>>());
        let mut larger = rows.clone();
        for share in [0.5, 0.25, 0.125] {
            let set = drawn(&dataset, &rows, share, 3);
            assert!(set.iter().all(|row| larger.contains(row)), "{set:?}");
            assert!(set.iter().all(|row| set.contains(&(row ^ 1))), "both samples of a recording: {set:?}");
            let soft = set.iter().filter(|row| **row < 24).count();
            assert_eq!(soft, 2 * (share * 12.0).round() as usize, "{share}");
            larger = set;
        }
        assert_eq!(counted(&dataset, &rows), 10.0);
    }

    #[test]
    fn numbers_of_recordings_are_round() {
        assert_eq!([0.4, 3.2, 12.0, 48.0, 160.0].map(round), [1.0, 2.0, 10.0, 50.0, 200.0]);
    }
}
