//! From an opened run folder to its [`Judgement`].

use ndarray::Axis;
use serde::{Deserialize, Serialize};
use taxel_learn::{
    Card, Environment, Epoch, FoldRecord, ModelKind, NetworkResults, Results, RunFolder, Timing,
};

use super::certainty::{certainty, tried};
use super::chance::chance;
use super::early::{EarlyOptions, early};
use super::eight_bits::changed;
use super::errors::errors;
use super::examples::examples;
use super::importance::importance;
use super::speed::speed;
use super::stress::{StressOptions, stress};
use crate::case::Case;
use crate::error::{Error, Result};
use crate::pareto::front;
use crate::values::{EpochPoint, Judged, Judgement, Primary, Speed};

/// Name of a judgement in its run folder.
const FILE: &str = "judgement.json";

/// Options of a judgement: measurements, time, progress.
pub struct JudgeOptions<'a> {
    /// Faults to try; none leaves the stress test out.
    pub stress: Option<StressOptions>,
    /// Options of the scores on starts of samples; none leaves them out.
    pub early: Option<EarlyOptions>,
    /// Seconds for timing one network.
    pub budget: f64,
    /// Hears what is being done.
    pub say: &'a (dyn Fn(&str) + Sync),
    /// Hears how many steps the stress test has.
    pub start: &'a dyn Fn(u64),
    /// Hears every step of it.
    pub tick: &'a (dyn Fn() + Sync),
}

impl Default for JudgeOptions<'_> {
    fn default() -> Self {
        JudgeOptions {
            stress: Some(StressOptions::default()),
            early: Some(EarlyOptions::default()),
            budget: 2.0,
            say: &|_| {},
            start: &|_| {},
            tick: &|| {},
        }
    }
}

/// Measures everything that a report says about a run: speed first, while nothing else runs.
///
/// # Errors
/// Models that are missing or damaged, readings that cannot be broken.
pub fn judge(case: &Case, options: &JudgeOptions) -> Result<Judgement> {
    let compared = case.compared();
    let of_one_fault = |row: &&NetworkResults| row.hardening.as_ref().is_some_and(|how| how.unmet.is_some());
    let (probes, rows): (Vec<_>, Vec<_>) = case.results.networks.iter().partition(of_one_fault);
    let mut networks = vec![];
    for row in rows {
        let timed = compared.contains(&row.network.as_str());
        networks.push(judged(case, row, timed, options)?);
    }
    mark_front(&mut networks, &case.primary());
    let stress = match &options.stress {
        Some(wanted) => {
            (options.say)("breaking test samples on purpose");
            Some(stress(case, wanted, options.start, options.tick)?)
        }
        None => None,
    };
    let early = match &options.early {
        Some(wanted) => {
            (options.say)("asking about the starts of test samples");
            early(case, wanted)?
        }
        None => None,
    };
    (options.say)("masking parts of test samples");
    let threads = options.stress.as_ref().map_or_else(|| taxel_learn::threads(None), |stress| stress.threads);
    let importance = importance(case, threads)?;
    let results = Results { networks: vec![], ..case.results.clone() };
    Ok(Judgement {
        protocol: results.protocol.words(&results.task),
        environment: case.folder.environment()?,
        judged_on: Environment::now(1, results.seed, &results.source, &results.data_digest),
        chance: chance(&case.dataset)?,
        examples: examples(case)?,
        networks,
        probes: probes.into_iter().cloned().collect(),
        changed: changed(case),
        stress,
        early,
        certainty: certainty(case)?,
        errors: errors(case)?,
        importance,
        learning_curve: None,
        results,
    })
}

/// Judges one row; `timed` says whether its speed is measured.
fn judged(case: &Case, row: &NetworkResults, timed: bool, options: &JudgeOptions) -> Result<Judged> {
    let records: Vec<&FoldRecord> = case.records(&row.network).collect();
    let (mut card, mut measured): (_, Option<Speed>) = (None, None);
    if let Some(first) = records.first() {
        let model = case.model(&first.key)?;
        if timed {
            (options.say)(&format!("timing {}", row.network));
            measured = Some(speed(&model, &case.dataset.x.select(Axis(0), &first.index), options.budget)?);
        }
        card = Some(model.card().clone());
    }
    let timings = records.iter().map(|record| timing(case, record)).collect::<Result<Vec<_>>>()?;
    let epochs = records.iter().map(|r| r.epochs.len()).max().unwrap_or(0);
    let trained = timings.iter().zip(&records).filter(|(_, record)| !record.epochs.is_empty());
    let per_epoch = mean(trained.map(|(timing, record)| timing.train_seconds / record.epochs.len() as f64));
    Ok(Judged {
        baseline: card.as_ref().is_some_and(|card| card.graph().is_none()),
        inputs: card.iter().flat_map(|card| &card.inputs).map(|input| input.name.clone()).collect(),
        frozen: card.as_ref().map_or(vec![], frozen),
        speed: measured,
        train_seconds: mean(timings.iter().map(|timing| timing.train_seconds)).unwrap_or(0.0),
        epoch_seconds: per_epoch,
        calibration_error: calibration_error(case, row),
        on_front: false,
        training: (0..epochs).map(|epoch| point(epoch, &records)).collect(),
        results: row.clone(),
    })
}

/// Returns the mean over folds, 0 without one; none of values, which have no probability.
fn calibration_error(case: &Case, row: &NetworkResults) -> Option<f64> {
    let of_folds = row.folds.iter().filter_map(|fold| fold.scores.get("calibration_error"));
    case.task().quantities().is_empty().then(|| mean(of_folds).unwrap_or(0.0))
}

fn frozen(card: &Card) -> Vec<String> {
    match &card.kind {
        ModelKind::Network { recipe, .. } => recipe.frozen.clone(),
        ModelKind::Baseline { .. } | ModelKind::Average { .. } => vec![],
    }
}

/// Reads how long a finished fold took.
fn timing(case: &Case, record: &FoldRecord) -> Result<Timing> {
    case.folder.timing(&record.key)?.ok_or_else(|| {
        let reason = format!("fold {} has no timing; delete its record and resume the run", record.key);
        Error::run(case.folder.path(), reason)
    })
}

/// Returns the mean; none without values.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let all: Vec<f64> = values.collect();
    (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
}

/// Returns the mean of one epoch over the folds that got so far: one did at least.
fn point(epoch: usize, records: &[&FoldRecord]) -> EpochPoint {
    let lines = || records.iter().filter_map(|record| record.epochs.get(epoch));
    let over = |value: fn(&Epoch) -> f64| lines().map(value).sum::<f64>() / lines().count() as f64;
    EpochPoint {
        epoch,
        train_loss: over(|line| line.train_loss),
        train_score: over(|line| line.train_score),
        validation_loss: mean(lines().filter_map(|line| line.validation_loss)),
        validation_score: mean(lines().filter_map(|line| line.validation_score)),
    }
}

/// Marks those for which no other is at least as fast and at least as good, and better in one.
fn mark_front(networks: &mut [Judged], primary: &Primary) {
    let sound = |n: &Judged| (n.results.diverged == 0).then_some(());
    let place = |n: &Judged| sound(n).and(Some((n.speed?.whole.p50_ms, primary.merit(n.score()?))));
    let places: Vec<(f64, f64)> = networks.iter().filter_map(place).collect();
    let known = networks.iter_mut().filter(|n| place(n).is_some());
    known.zip(front(&places)).for_each(|(network, on_front)| network.on_front = on_front);
}

impl Judgement {
    /// Reads the judgement in a run folder, if there is one of this version and it is about the run as it is now.
    ///
    /// # Errors
    /// A file that is damaged or was changed since it was measured.
    pub fn read(case: &Case) -> Result<Option<Self>> {
        let mut read = match case.folder.read::<Sealed>(FILE)? {
            Some(Sealed { judgement, digest: Some(digest) }) if digest == seal(&judgement)? => {
                Some(judgement)
            }
            Some(Sealed { digest: Some(_), .. }) => {
                let (file, reason) = (case.folder.file(FILE).display().to_string(), CHANGED.into());
                return Err(taxel_learn::Error::Damaged { file, reason }.into());
            }
            _ => None,
        };
        // Those of older versions have intervals of another kind, which are no measurements.
        for network in read.iter_mut().flat_map(|judgement| &mut judgement.networks) {
            let row = case.results.networks.iter().find(|row| row.network == network.results.network);
            if let Some(row) = row {
                network.results.interval = row.interval;
                network.results.interval_groups = row.interval_groups;
            }
        }
        // Gates are tried by the run and not measured here; that may have been later.
        read.iter_mut().try_for_each(|judgement| tried(case, &mut judgement.certainty))?;
        let is_of_run = |j: &Judgement| {
            let networks = j.networks.iter().map(|n| &n.results);
            networks.eq(&case.results.networks) && j.results.data_digest == case.results.data_digest
        };
        Ok(read.filter(is_of_run))
    }

    /// Writes the judgement into its run folder, whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &RunFolder) -> Result<()> {
        Ok(folder.write(FILE, &Sealed { digest: Some(seal(self)?), judgement: self.clone() })?)
    }
}

/// A judgement as it is written: nothing in it is checked again but that it is what was measured.
#[derive(Serialize, Deserialize)]
struct Sealed {
    #[serde(flatten)]
    judgement: Judgement,
    /// BLAKE3 of the judgement as JSON; none in those of older versions.
    digest: Option<String>,
}

const CHANGED: &str = "is not what was measured (digests differ); delete it, and the run is measured again";

fn seal(judgement: &Judgement) -> Result<String> {
    let text = serde_json::to_string(judgement).map_err(|e| Error::write(FILE.as_ref(), e))?;
    Ok(blake3::hash(text.as_bytes()).to_hex().to_string())
}
