//! Models on the test parts of a run: on unbroken samples, under faults, behind a guard.

use std::sync::Arc;

use ndarray::{ArrayD, Axis};
use rayon::prelude::*;
use taxel_data::{Layout, Targets};
use taxel_faults::{Fault, Sensor};
use taxel_learn::certainty::{FALSE_ALARMS, Gates, answers, tempered};
use taxel_learn::guard::{Guard, ReplacedElement};
use taxel_learn::metrics::{Levels, Outcome};
use taxel_learn::{FoldKey, FoldRecord, Predictor, mended};

use super::apart::Apart;
use super::chance::means;
use super::guarding::guard;
use super::threads::on;
use crate::case::Case;
use crate::error::{Error, Result};
use crate::values::Alarms;

/// Samples that a network predicts at a time.
pub(super) const BATCH: usize = 64;
/// The probability from which on an answer is sure.
const SURE: f32 = 0.9;

/// Rows of the data set that a fold tests, with the models that have not seen them.
pub(super) struct TestPart {
    pub fold: usize,
    pub rows: Vec<usize>,
    pub keys: Vec<FoldKey>,
    /// Of each attribute the classes that the fold tests and did not train; empty where there are none.
    pub untrained: Vec<Vec<u32>>,
}

impl TestPart {
    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.rows.len()
    }
}

/// A fault and its severity; none for unbroken samples.
pub(super) type Corruption = Option<(Fault, u8)>;

/// Predictions of one network for a part, beside the true targets.
pub(super) struct PartOutcome {
    pub network: String,
    pub fold: usize,
    pub broken: Corruption,
    pub outcome: Outcome,
    pub refused: usize,
    /// How sure the answers are at the temperature of the other folds; none of values.
    pub sure: Option<SureCount>,
    /// Samples that the gates of the other folds find unknown, and all; none without gates.
    pub unknown: Option<(usize, usize)>,
}

/// Answers of a part counted by how sure they are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct SureCount {
    /// Answers, one for each attribute of each sample.
    pub answers: usize,
    /// Those that are 90 % sure or more.
    pub sure: usize,
    /// Those of them that are right.
    pub right: usize,
}

impl SureCount {
    /// Counts answers at a temperature.
    fn of(outputs: &RawOutputs, outcome: &Outcome, levels: &Levels, temperature: f64) -> Self {
        let (truth, _) = outcome.labels();
        let mut probabilities = outputs.outputs.clone();
        tempered(&mut probabilities, levels.sizes(), temperature);
        let mut count = SureCount::default();
        for (at, answers) in answers(&probabilities, truth, levels).into_iter().enumerate() {
            let is_refused = outputs.refused.contains(&at);
            for (sure, is_right) in answers {
                let is_sure = !is_refused && sure >= f64::from(SURE);
                count.answers += 1;
                count.sure += usize::from(is_sure);
                count.right += usize::from(is_sure && is_right);
            }
        }
        count
    }
}

/// Counts the samples `x`, as a model reads them, that gates find unknown, and all; none without gates.
fn unknown(outputs: &RawOutputs, gates: &Gates, x: (Layout, &ArrayD<f32>)) -> Option<(usize, usize)> {
    let familiarity = gates.familiarities(&outputs.logits, (x.0, x.1))?;
    let is_unknown = |at: &usize| outputs.refused.contains(at) || familiarity[*at] <= FALSE_ALARMS;
    Some(((0..familiarity.len()).filter(is_unknown).count(), familiarity.len()))
}

/// Returns the test parts of the first repetition, thinned out evenly to `most` samples, and the number of all samples.
pub(super) fn parts(case: &Case, names: &[&str], most: usize) -> Result<(Vec<TestPart>, usize)> {
    let records = || names.iter().flat_map(|name| case.first_repetition(name));
    let size = |name: &&str| case.first_repetition(name).map(|r| r.index.len()).sum::<usize>();
    let of = names.iter().map(size).max().unwrap_or(0);
    let every = of.div_ceil(most.max(1)).max(1);
    let mut parts: Vec<TestPart> = vec![];
    for FoldRecord { key, index, outcome, .. } in records() {
        let rows: Vec<usize> = index.iter().copied().step_by(every).collect();
        match parts.iter_mut().find(|part| part.fold == key.fold && part.rows == rows) {
            Some(part) => part.keys.push(key.clone()),
            None => {
                let untrained = match outcome {
                    Outcome::Labels { untrained, .. } => untrained.clone(),
                    Outcome::Values { .. } => vec![],
                };
                parts.push(TestPart { fold: key.fold, rows, keys: vec![key.clone()], untrained });
            }
        }
    }
    Ok((parts, of))
}

/// The samples of a part, its predictors without a guard, each with whether its model has one, and the guard of the fold.
struct PartModels {
    clean: ArrayD<f32>,
    predictors: Vec<(Predictor, bool)>,
    guard: Option<Arc<Guard>>,
    /// Whether each predicts with the guard and without.
    both: bool,
}

/// Outcomes of all networks on all parts.
#[derive(Default)]
pub(super) struct StressOutcomes {
    /// With a guard where their models have one.
    pub saved: Vec<PartOutcome>,
    /// The other way, where that was wanted.
    pub other: Vec<PartOutcome>,
    /// In unbroken samples; none without a guard.
    pub alarms: Option<Alarms>,
}

impl StressOutcomes {
    fn extend(&mut self, more: Self) {
        self.saved.extend(more.saved);
        self.other.extend(more.other);
        self.alarms = match (self.alarms, more.alarms) {
            (Some(before), Some(alarms)) => Some(before.and(alarms)),
            (before, alarms) => before.or(alarms),
        };
    }
}

/// Predicts every part under each of `corruptions` on `threads` threads. Outcomes are in the order of parts and
/// corruptions. `tick` hears each of them.
pub(super) fn stressed_parts(
    case: &Case,
    sensor: &Sensor,
    parts: &[TestPart],
    corruptions: &[Corruption],
    apart: &Apart,
    (is_guarded, threads): (bool, usize),
    tick: &(dyn Fn() + Sync),
) -> Result<StressOutcomes> {
    on(threads, || {
        let mut all = StressOutcomes::default();
        for part in parts {
            let models = PartModels::new(case, part, is_guarded)?;
            let outcomes = |corruption: &Corruption| {
                let outcomes = models.outcomes((case, sensor, apart), part, *corruption)?;
                tick();
                Ok(outcomes)
            };
            let done = corruptions.par_iter().map(outcomes).collect::<Result<Vec<_>>>()?;
            done.into_iter().for_each(|outcomes| all.extend(outcomes));
        }
        Ok(all)
    })
}

impl PartModels {
    /// Reads the models of a part; `both` says whether a fold without a guard gets one.
    fn new(case: &Case, part: &TestPart, both: bool) -> Result<Self> {
        let models = part.keys.iter().map(|key| case.model(key)).collect::<Result<Vec<_>>>()?;
        let guard = guard(case, &part.keys, &models, both)?;
        let mut predictors = vec![];
        for model in &models {
            predictors.push((model.predictor(BATCH, 1)?.guarded(None)?, model.card().guard.is_some()));
        }
        let clean = case.dataset.x.select(Axis(0), &part.rows);
        Ok(PartModels { clean, predictors, guard, both })
    }

    fn outcomes(
        &self,
        (case, sensor, apart): (&Case, &Sensor, &Apart),
        part: &TestPart,
        broken: Corruption,
    ) -> Result<StressOutcomes> {
        let clean = &self.clean;
        let corrupted = broken
            .map(|(fault, severity)| corrupt(case, sensor, clean, part, fault, severity))
            .transpose()?;
        let x = corrupted.as_ref().unwrap_or(clean);
        let behind = self.guard.as_ref().map(|guard| mended(guard, x));
        let alarms = match (&self.guard, &behind, broken) {
            (Some(guard), Some((_, found)), None) => Some(Alarms::of(guard, found)),
            _ => None,
        };
        let mut outcomes = StressOutcomes { alarms, ..StressOutcomes::default() };
        let probes = case.probes();
        for ((predictor, is_guarded), key) in self.predictors.iter().zip(&part.keys) {
            // A row that was trained without one fault is tested under that fault only.
            let left_out = probes.iter().find(|(name, _)| *name == key.network).map(|(_, fault)| *fault);
            if left_out.zip(broken).is_some_and(|(left_out, (fault, _))| left_out != fault) {
                continue;
            }
            let without = if self.both || !is_guarded { Some(predict(predictor, clean, x)?) } else { None };
            let with = match &behind {
                Some((mended, found)) if self.both || *is_guarded => {
                    Some(predict_behind(predictor, clean, mended, found, without.as_ref())?)
                }
                _ => None,
            };
            let fitted = apart.get(&(key.network.clone(), part.fold as u32));
            let (layout, levels) = (case.dataset.spec.layout, case.levels());
            let has_labels = case.dataset.targets.labels().is_some();
            let of = |(outputs, x): (RawOutputs, &ArrayD<f32>)| {
                let outcome = outcome(&case.dataset.targets, part, outputs.clone());
                PartOutcome {
                    network: key.network.clone(),
                    fold: part.fold,
                    broken,
                    refused: outputs.refused.len(),
                    unknown: fitted.and_then(|(_, gates)| unknown(&outputs, gates, (layout, x))),
                    sure: fitted
                        .filter(|_| has_labels)
                        .map(|(temperature, _)| SureCount::of(&outputs, &outcome, &levels, *temperature)),
                    outcome,
                }
            };
            let without = without.map(|outputs| (outputs, x));
            let with = with.zip(behind.as_ref().map(|(mended, _)| mended));
            let (saved, other) = if *is_guarded { (with, without) } else { (without, with) };
            outcomes.saved.extend(saved.map(of));
            outcomes.other.extend(other.map(of));
        }
        Ok(outcomes)
    }
}

/// Returns outputs beside the true targets of a part. A sample that was refused has no class, which is never right, or
/// the mean of each value.
pub(super) fn outcome(targets: &Targets, part: &TestPart, raw: RawOutputs) -> Outcome {
    let RawOutputs { outputs, refused, .. } = raw;
    let mut outcome = Outcome::new(targets, &part.rows, outputs).with_untrained(&part.untrained);
    match (&mut outcome, targets) {
        (Outcome::Values { predicted, .. }, Targets::Values(values)) => {
            let means = means(values);
            for &row in &refused {
                predicted[row * means.len()..][..means.len()].copy_from_slice(&means);
            }
        }
        (Outcome::Labels { predicted, .. }, _) => {
            let width = predicted.len() / part.len().max(1);
            for &row in &refused {
                predicted[row * width..][..width].fill(u32::MAX);
            }
        }
        _ => {}
    }
    outcome
}

/// Returns the samples of a part under one fault.
fn corrupt(
    case: &Case,
    sensor: &Sensor,
    clean: &ArrayD<f32>,
    part: &TestPart,
    fault: Fault,
    severity: u8,
) -> Result<ArrayD<f32>> {
    let mut x = clean.clone();
    for (sample, &row) in x.axis_iter_mut(Axis(0)).zip(&part.rows) {
        fault.apply(sample, sensor, severity, case.results.seed, row).map_err(|source| {
            let source_label = case.dataset.source.to_string();
            Error::Fault { source_label, source }
        })?;
    }
    Ok(x)
}

/// Predictions of a model for some samples.
#[derive(Debug, Clone, Default)]
pub(super) struct RawOutputs {
    /// Probabilities or values `[n, outputs]`.
    pub outputs: Vec<f32>,
    /// The logits that they are made of, `[n, outputs]`.
    pub logits: Vec<f32>,
    /// The samples that cannot be encoded.
    pub refused: Vec<usize>,
}

/// Predicts samples `x` behind a guard; where it found nothing the outputs are those `without` it.
fn predict_behind(
    predictor: &Predictor,
    clean: &ArrayD<f32>,
    x: &ArrayD<f32>,
    found: &[Vec<ReplacedElement>],
    without: Option<&RawOutputs>,
) -> Result<RawOutputs> {
    let Some(without) = without else { return predict(predictor, clean, x) };
    let rows: Vec<usize> = (0..found.len()).filter(|row| !found[*row].is_empty()).collect();
    let mut all = without.clone();
    if rows.is_empty() {
        return Ok(all);
    }
    let mended = predict(predictor, &clean.select(Axis(0), &rows), &x.select(Axis(0), &rows))?;
    let width = mended.outputs.len() / rows.len();
    for (at, row) in rows.iter().enumerate() {
        let (from, to) = (at * width..(at + 1) * width, row * width..(row + 1) * width);
        all.outputs[to.clone()].copy_from_slice(&mended.outputs[from.clone()]);
        all.logits[to].copy_from_slice(&mended.logits[from]);
    }
    all.refused.retain(|row| !rows.contains(row));
    all.refused.extend(mended.refused.into_iter().map(|at| rows[at]));
    all.refused.sort_unstable();
    Ok(all)
}

/// Predicts `broken` samples. Clean ones stand in for those that cannot be encoded, so that the others make a batch.
pub(super) fn predict(
    predictor: &Predictor,
    clean: &ArrayD<f32>,
    broken: &ArrayD<f32>,
) -> Result<RawOutputs> {
    if let Ok(inputs) = predictor.encode(broken) {
        let logits = predictor.logits_encoded(&inputs)?;
        return Ok(RawOutputs { outputs: predictor.finished(logits.clone()), logits, refused: vec![] });
    }
    let mut mended = broken.clone();
    let mut refused = vec![];
    for row in 0..broken.len_of(Axis(0)) {
        if predictor.encode(&broken.select(Axis(0), &[row])).is_err() {
            mended.index_axis_mut(Axis(0), row).assign(&clean.index_axis(Axis(0), row));
            refused.push(row);
        }
    }
    let logits = predictor.logits(&mended)?;
    Ok(RawOutputs { outputs: predictor.finished(logits.clone()), logits, refused })
}

#[cfg(test)]
mod tests {
    use taxel_data::Labels;

    use super::*;

    #[test]
    fn classes_that_a_fold_did_not_train_are_known_under_faults_too() {
        let classes = ["dry", "oil", "wet"].map(String::from);
        let labels = Labels::of_classes(&classes, &[0, 1, 2]);
        let targets = Targets::Classes { labels, columns: None, steps: None };
        let part = TestPart { fold: 0, rows: vec![0, 2], keys: vec![], untrained: vec![vec![2]] };
        let outputs = vec![0.2, 0.8, 0.0, 0.9, 0.1, 0.0];
        let broken = outcome(&targets, &part, RawOutputs { outputs, ..RawOutputs::default() });
        assert_eq!((broken.untrained(0), broken.labels().1), (&[2][..], &[1, 0][..]));
    }
}
