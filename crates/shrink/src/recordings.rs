//! A row of a run on fewer and fewer training recordings: what more of them would bring.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Fold, Task};
use taxel_judge::statistics::power_law;
use taxel_judge::{Case, CurvePoint, LearningCurve, Primary};
use taxel_learn::{FoldRecord, Progress, Protocol, inner_folds, shuffled};
use taxel_trainer::{Experiment, Variant};
use taxel_zoo::Registry;

use crate::cache::{Cache, Request};
use crate::curves::inner_place;
use crate::error::{Error, Result};

/// Shares of an inner training part that are learned from.
const SHARES: [f64; 4] = [0.125, 0.25, 0.5, 1.0];
/// The least recordings of the largest class of an inner training part, for an eighth to say anything.
const LEAST: usize = 8;
/// Most folds of the run that are used.
const MOST_FOLDS: usize = 10;
/// Inner folds of a training part, where it has as many groups.
const INNER: usize = 5;
/// Inner folds that are used, of all training parts together: three are the least for a law.
const WANTED: usize = 5;
/// Folder of the records below a run folder.
const RECORDS: &str = "learning-curve";
/// Numbers these trainings apart from all others, for their random choices.
const APART: usize = 2_000_000;

/// A fold of the run, with the inner folds of its training part that are used.
struct Part {
    /// Repetition and fold.
    place: (usize, usize),
    fold: Fold,
    /// Number of each and its samples.
    inner: Vec<(usize, Fold)>,
}

/// Trains a network or baseline of a run on an eighth, a quarter, half and all of inner training parts, tests it on the inner folds
/// beside them, and fits a power law to the scores. The law is continued to the training parts of the run, whose scores it has not
/// seen: no test sample of a fold of the run is in its inner folds.
///
/// Whole recordings are drawn, of each class the same share, the smaller sets inside the larger ones. Groups are kept apart between the
/// parts as the run keeps them, and not among the recordings that are drawn, so the law is that of more recordings of the same groups.
/// Finished trainings are kept in the run folder and made once.
///
/// # Errors
/// A run that is a learning curve itself or of another split, too few recordings or groups, [`Error::Stopped`] if `cancel` was set.
pub fn learning_curve(
    (case, experiment, registry): (&Case, &Experiment, &Registry),
    network: &str,
    threads: usize,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<LearningCurve> {
    let (records, parts) = recorded(case, network)?;
    let (dataset, changes) = (&case.dataset, Variant::default());
    let folder = case.folder.file(RECORDS);
    std::fs::create_dir_all(&folder).map_err(|e| Error::file(&folder, format!("cannot be made: {e}")))?;
    let mut cache = Cache::new((experiment, registry, dataset), folder, threads, progress, cancel);
    cache.expect(SHARES.len() * parts.iter().map(|part| part.inner.len()).sum::<usize>());
    let seen = |(record, part): (&FoldRecord, &Part)| {
        record.epochs.len().max(1) * part.inner.iter().map(|(_, fold)| fold.train.len()).sum::<usize>()
    };
    let work: usize = records.iter().zip(&parts).map(seen).sum();
    progress.start((work as f64 * SHARES.iter().sum::<f64>()) as u64);
    let mut points = vec![];
    for share in SHARES {
        let label = format!("{network} on {:.0} %", 100.0 * share);
        let (mut scores, mut counts) = (vec![], vec![]);
        for part in &parts {
            for (at, inner) in &part.inner {
                let fold = smaller(dataset, inner, share, experiment.config().seed);
                counts.push(counted(dataset, &fold.train));
                let (repetition, number) = inner_place(part.place, *at);
                let place = (repetition, APART + number);
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
        }
        points.push(point(&counts, scores));
    }
    progress.finish();
    finished(case, network, (&records, &parts), points)
}

/// Fits the law to the points, and continues it to the training parts of the run.
fn finished(
    case: &Case,
    network: &str,
    (records, parts): (&[FoldRecord], &[Part]),
    points: Vec<CurvePoint>,
) -> Result<LearningCurve> {
    let counts: Vec<f64> = parts.iter().map(|part| counted(&case.dataset, &part.fold.train)).collect();
    let scores = records.iter().map(|record| score(record, case.task())).collect::<Result<_>>()?;
    let whole = point(&counts, scores);
    let primary = case.primary();
    let error = |score: f64| if primary.is_percent() { 100.0 - score } else { score };
    let inner: Vec<&Fold> = parts.iter().flat_map(|part| part.inner.iter().map(|(_, fold)| fold)).collect();
    let ratio = |fold: &&Fold| fold.test.len() as f64 / fold.train.len().max(1) as f64;
    let ratio = inner.iter().map(ratio).sum::<f64>() / inner.len() as f64;
    let more = [round(whole.count / 4.0), round(whole.count)];
    let law = power_law(&points, error, ratio, (whole.count, &more))?;
    let law = law.map(|law| law.anchored(error(whole.score)));
    let per = per(&primary, case.task()).into();
    Ok(LearningCurve { network: network.into(), per, points, whole: Some(whole), law })
}

/// Returns every training of a learning curve of a run of this protocol: its samples.
///
/// # Errors
/// A protocol that is a learning curve itself, too few recordings or groups.
pub fn curve_folds(dataset: &Dataset, protocol: &Protocol, seed: u64) -> Result<Vec<Fold>> {
    let mut places = vec![];
    for repetition in 0..protocol.repetitions() {
        let folds = protocol.folds(dataset, seed, repetition)?;
        places.extend(folds.into_iter().enumerate().map(|(fold, samples)| ((repetition, fold), samples)));
        if places.len() >= MOST_FOLDS {
            break;
        }
    }
    places.truncate(MOST_FOLDS);
    let parts = parts(dataset, protocol, seed, places)?;
    let inner = || parts.iter().flat_map(|part| part.inner.iter().map(|(_, fold)| fold));
    Ok(SHARES.iter().flat_map(|share| inner().map(|fold| smaller(dataset, fold, *share, seed))).collect())
}

/// Returns the finished folds of a row that are used, and their parts, divided again as the run was divided.
fn recorded(case: &Case, network: &str) -> Result<(Vec<FoldRecord>, Vec<Part>)> {
    let (protocol, seed) = (&case.results.protocol, case.results.seed);
    let refuse = |reason: String| Error::file(case.folder.path(), reason);
    let (mut records, mut places) = (vec![], vec![]);
    if protocol.per_class().is_none() {
        for record in case.records(network).take(MOST_FOLDS) {
            let (repetition, number) = (record.key.repetition, record.key.fold);
            let all = protocol.folds(&case.dataset, seed, repetition)?;
            let same = |fold: &&Fold| fold.test == record.index;
            let fold = all.get(number).filter(same).cloned();
            let other = || refuse(format!("fold {} is of another split; run it again", record.key));
            places.push(((repetition, number), fold.ok_or_else(other)?));
            records.push(record.clone());
        }
        if places.is_empty() {
            let reason = "has no finished fold; resume the run";
            return Err(Error::value("network", format!("{network:?}"), reason));
        }
    }
    Ok((records, parts(&case.dataset, protocol, seed, places)?))
}

/// Divides the training parts of folds again. Each takes its turn at another inner fold, and of few parts several are used.
fn parts(
    dataset: &Dataset,
    protocol: &Protocol,
    seed: u64,
    places: Vec<((usize, usize), Fold)>,
) -> Result<Vec<Part>> {
    let refuse = |reason: String| Error::value("protocol", protocol.words(&dataset.task()), reason);
    if protocol.per_class().is_some() {
        return Err(refuse("is a learning curve itself".into()));
    }
    let each = WANTED.div_ceil(places.len().max(1));
    let mut parts = vec![];
    for (turn, (place, fold)) in places.into_iter().enumerate() {
        let all = inner_folds(protocol, dataset, &fold, INNER, seed, place.0)
            .map_err(|error| refuse(format!("a learning curve divides each training part again: {error}")))?;
        let (first, count) = (turn * each, all.len());
        let numbered = all.into_iter().enumerate();
        let is_used = |at: &usize| (at + count - first % count) % count < each;
        let inner: Vec<(usize, Fold)> = numbered.filter(|(at, _)| is_used(at)).collect();
        parts.push(Part { place, fold, inner });
    }
    let folds = parts.iter().flat_map(|part| &part.inner);
    let most = folds.map(|(_, fold)| largest_class(dataset, &fold.train)).min().unwrap_or(0);
    if most < LEAST {
        return Err(refuse(format!(
            "a learning curve: an inner training part has {most} recordings of its largest class, and {LEAST} are needed"
        )));
    }
    Ok(parts)
}

/// Returns a fold that trains on this share of the recordings alone.
fn smaller(dataset: &Dataset, fold: &Fold, share: f64, seed: u64) -> Fold {
    let train = if share < 1.0 { drawn(dataset, &fold.train, share, seed) } else { fold.train.clone() };
    Fold { train, ..fold.clone() }
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
    fn inner_folds_hold_no_test_sample_and_no_divided_group() {
        let groups: Vec<u32> = (0..80).map(|press| press / 2 % 5).collect();
        // Equal samples would be copies, which count as one recording.
        let x = ndarray::ArrayD::from_shape_fn(vec![80, 1, 4], |at| (at[0] + at[2]) as f32);
        let labels: Vec<&str> = (0..80).map(|press| if press % 2 == 0 { "soft" } else { "hard" }).collect();
        let dataset =
            Dataset::new("presses", Layout::Series, x, &labels).unwrap().with_groups(&groups).unwrap();
        for (protocol, folds) in [(Protocol::group_k_fold(5), 5), (Protocol::k_fold(2), 6)] {
            let places = protocol.folds(&dataset, 0, 0).unwrap();
            let places = places.into_iter().enumerate().map(|(at, fold)| ((0, at), fold)).collect();
            let parts = parts(&dataset, &protocol, 0, places).unwrap();
            let mut used = 0;
            for Part { fold, inner, .. } in &parts {
                for (_, inner) in inner {
                    used += 1;
                    assert!(inner.train.iter().chain(&inner.test).all(|row| fold.train.contains(row)));
                    assert!(
                        !inner.test.is_empty() && inner.test.iter().all(|row| !inner.train.contains(row))
                    );
                    let divided =
                        |row: &usize| inner.train.iter().any(|other| groups[*other] == groups[*row]);
                    assert!(!protocol.keeps_groups() || !inner.test.iter().any(divided));
                }
            }
            assert_eq!(used, folds, "{protocol:?}");
            let trainings = curve_folds(&dataset, &protocol, 0).unwrap();
            assert_eq!(trainings.len(), 4 * used);
        }
        let two = dataset.with_groups(&[0, 1].repeat(40)).unwrap();
        let error = curve_folds(&two, &Protocol::group_k_fold(2), 0).unwrap_err().to_string();
        assert!(error.contains("leaves one group"), "{error}");
    }

    #[test]
    fn numbers_of_recordings_are_round() {
        assert_eq!([0.4, 3.2, 12.0, 48.0, 160.0].map(round), [1.0, 2.0, 10.0, 50.0, 200.0]);
    }
}
