//! Accuracy under graded faults on raw readings: where each network breaks.

mod words;
mod work;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use taxel_scenes::faults::{Fault, Sensor};
use taxel_trainer::Transform;

use crate::case::Case;
use crate::error::{Error, Result};
use crate::measure::first_fold;
use work::{Answer, Job, Part};

/// What a fault does, for readers of a report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaultInfo {
    /// Name on the command line.
    pub fault: Fault,
    /// What happens, in a few words.
    pub what: String,
    /// Severities 1 to 5.
    pub levels: [f32; 5],
    /// Unit of the levels.
    pub unit: String,
}

/// The range of readings that levels in % of full scale refer to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// The smallest possible reading.
    pub low: f32,
    /// The largest possible reading.
    pub high: f32,
    /// Whether it was taken from the samples, since nobody says what the sensor's is.
    pub from_samples: bool,
}

/// Scores on the same test samples, clean or broken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// In %.
    pub accuracy: f64,
    /// Expected calibration error, 0 to 1.
    pub calibration_error: f64,
    /// Samples that an encoding refused; they count as wrong.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub refused: usize,
}

/// One network under one fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaultCurve {
    /// The fault.
    pub fault: Fault,
    /// Severity (1 to 5) and scores; all five unless one was asked for.
    pub points: Vec<(u8, Score)>,
    /// The first severity at which half of the margin above chance is lost: its breaking point.
    pub breaks_at: Option<u8>,
}

/// One network under all faults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NetworkStress {
    /// Name in the experiment.
    pub network: String,
    /// On the same samples, unbroken.
    pub clean: Score,
    /// In the order of [`Stress::faults`].
    pub curves: Vec<FaultCurve>,
    /// Accuracy lost, in percentage points, mean over faults and severities.
    pub mean_loss: f64,
    /// The largest loss of a fault, in percentage points, mean over its severities.
    pub worst_loss: f64,
    /// Errors relative to the reference's, mean over faults, in % (Hendrycks & Dietterich 2019, mCE).
    pub corruption_error: Option<f64>,
    /// Errors beyond the clean ones relative to the reference's (relative mCE), in %; none where the
    /// reference loses nothing.
    pub relative_corruption_error: Option<f64>,
    /// Mean over faults and severities.
    pub calibration_error: f64,
    /// What the numbers say, in words.
    pub verdict: String,
}

/// Every network under every fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stress {
    /// Seed of the faults.
    pub seed: u64,
    /// Test samples behind every accuracy, over all folds of the first repetition.
    pub samples: usize,
    /// Test samples that there are; more than `samples` where some were left out for time.
    pub of: usize,
    /// The sensor's range.
    pub range: Range,
    /// Accuracy in % of always naming the commonest class.
    pub chance: f64,
    /// The network that corruption errors are relative to.
    pub reference: Option<String>,
    /// In the order of the table.
    pub faults: Vec<FaultInfo>,
    /// Faults without a meaning for these readings, and why.
    pub left_out: BTreeMap<String, String>,
    /// In the order of the run.
    pub networks: Vec<NetworkStress>,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// What is broken, and how much time it may take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StressOptions {
    /// These faults only; all that have a meaning where it is empty.
    pub faults: Vec<Fault>,
    /// This severity only.
    pub severity: Option<u8>,
    /// At most so many test samples of each network; the others are left out evenly. Default 1000.
    pub samples: usize,
    /// Worker threads; results do not depend on them.
    pub threads: usize,
}

impl Default for StressOptions {
    fn default() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, Into::into);
        StressOptions { faults: vec![], severity: None, samples: 1000, threads }
    }
}

/// Scores the saved networks of a run on broken test samples; nothing is trained. `start` hears the
/// number of steps, `tick` each of them.
///
/// Every sample is broken before it is encoded, in the same way for all networks. A sample that an
/// encoding refuses (no contact is found, for example) counts as wrong.
///
/// # Errors
/// A fault without a meaning for these readings, models that are missing, readings that are not finite.
pub fn stress(
    case: &Case,
    options: &StressOptions,
    start: &dyn Fn(u64),
    tick: &(dyn Fn() + Sync),
) -> Result<Stress> {
    let (sensor, range) = case.sensor();
    let (faults, left_out) = faults(case, options, &sensor)?;
    let severities: Vec<u8> = options.severity.map_or_else(|| (1..=5).collect(), |one| vec![one]);
    let names = case.contestants();
    let (parts, of) = work::parts(case, &names, options.samples)?;
    let mut jobs = vec![];
    for part in 0..parts.len() {
        jobs.push(Job { part, broken: None });
        for &fault in &faults {
            jobs.extend(severities.iter().map(|&severity| Job { part, broken: Some((fault, severity)) }));
        }
    }
    start(jobs.len() as u64);
    let answers = work::all(case, &sensor, &parts, &jobs, options.threads, tick)?;
    let chance = chance(case);
    let mut networks = vec![];
    for name in &names {
        let score = |broken| {
            let own: Vec<&Answer> =
                answers.iter().filter(|a| a.network == *name && a.broken == broken).collect();
            score(case, &own)
        };
        let clean = score(None)?;
        let mut curves = vec![];
        for &fault in &faults {
            let points = severities
                .iter()
                .map(|&severity| Ok((severity, score(Some((fault, severity)))?)))
                .collect::<Result<Vec<_>>>()?;
            curves.push(FaultCurve { fault, breaks_at: breaks_at(&points, clean.accuracy, chance), points });
        }
        networks.push(NetworkStress::new(name, clean, curves));
    }
    let reference = REFERENCES.into_iter().find(|name| names.contains(name));
    relate(&mut networks, reference);
    for network in &mut networks {
        network.verdict = words::verdict(network, chance, &transforms(case, &network.network)?);
    }
    Ok(Stress {
        seed: case.results.seed,
        samples: tested(&parts),
        of,
        range,
        chance,
        reference: reference.map(Into::into),
        faults: faults.into_iter().map(FaultInfo::of).collect(),
        left_out,
        networks,
    })
}

/// Baselines and networks that corruption errors are relative to, the first that a run has.
const REFERENCES: [&str; 3] = ["k-nn", "mini-rocket", "mlp"];

impl FaultInfo {
    fn of(fault: Fault) -> Self {
        let (what, unit) = (fault.describe().into(), fault.unit().into());
        FaultInfo { fault, what, levels: fault.severities(), unit }
    }
}

/// The faults to be tested, and those that have no meaning here.
fn faults(
    case: &Case,
    options: &StressOptions,
    sensor: &Sensor,
) -> Result<(Vec<Fault>, BTreeMap<String, String>)> {
    if let Some(severity) = options.severity.filter(|s| !(1..=5).contains(s)) {
        let (name, reason) = ("--severity", "must be in 1..=5".into());
        return Err(Error::Setting { name, value: severity.to_string(), reason });
    }
    let (mut faults, mut left_out) = (vec![], BTreeMap::new());
    for fault in Fault::ALL {
        let asked = options.faults.contains(&fault);
        match fault.refusal(sensor.layout) {
            Some(reason) if asked => {
                let (fault, layout) = (fault.name(), sensor.layout.describe());
                let source = taxel_scenes::Error::Fault { fault, layout, reason };
                return Err(Error::Fault { source_label: case.samples.source.clone(), source });
            }
            Some(reason) => {
                left_out.insert(fault.name().into(), reason.into());
            }
            None if asked || options.faults.is_empty() => faults.push(fault),
            None => {}
        }
    }
    Ok((faults, left_out))
}

/// How the first saved fold of a network encodes its inputs.
fn transforms(case: &Case, network: &str) -> Result<Vec<Transform>> {
    let predictor = case.predictor(&first_fold(network), 1, 1)?;
    Ok(predictor.metadata().inputs.iter().map(|(_, transform)| transform.clone()).collect())
}

/// Different test samples over all parts.
fn tested(parts: &[Part]) -> usize {
    let mut folds: Vec<(usize, usize)> = parts.iter().map(|part| (part.fold, part.len())).collect();
    folds.sort_unstable();
    folds.dedup();
    folds.into_iter().map(|(_, count)| count).sum()
}

/// The share of samples in % that is right by always naming the commonest class; with several attributes
/// the mean over them.
pub(crate) fn chance(case: &Case) -> f64 {
    let levels = case.levels();
    let width = levels.sizes().len().max(1);
    let truth = case.samples.labels.of(&(0..case.samples.len()).collect::<Vec<_>>());
    let share = |attribute: usize, size: usize| {
        let mut counts = vec![0usize; size];
        truth.iter().skip(attribute).step_by(width).for_each(|&label| counts[label as usize] += 1);
        counts.iter().max().copied().unwrap_or(0) as f64 / case.samples.len().max(1) as f64
    };
    let sum: f64 = levels.sizes().iter().enumerate().map(|(i, &size)| share(i, size)).sum();
    100.0 * sum / width as f64
}

/// Scores over all parts.
fn score(case: &Case, answers: &[&Answer]) -> Result<Score> {
    let truth: Vec<u32> = answers.iter().flat_map(|a| a.truth.iter().copied()).collect();
    let predicted = answers.iter().flat_map(|a| &a.predicted);
    let right = truth.iter().zip(predicted).filter(|(truth, predicted)| truth == predicted).count();
    let probabilities: Vec<f32> = answers.iter().flat_map(|a| a.probabilities.iter().copied()).collect();
    let (calibration_error, _) = case.levels().calibration(&probabilities, &truth)?;
    Ok(Score {
        accuracy: 100.0 * right as f64 / truth.len().max(1) as f64,
        calibration_error,
        refused: answers.iter().map(|a| a.refused).sum(),
    })
}

/// Percentage points above chance below which there is no margin to lose.
const MARGIN: f64 = 2.0;

/// The first severity at which half of the margin above chance is lost; none without a margin.
fn breaks_at(points: &[(u8, Score)], clean: f64, chance: f64) -> Option<u8> {
    let half = chance + (clean - chance) / 2.0;
    let broken = |(_, score): &&(u8, Score)| clean - chance > MARGIN && score.accuracy <= half;
    points.iter().find(broken).map(|(severity, _)| *severity)
}

impl FaultCurve {
    /// Accuracy lost, in percentage points, mean over the severities.
    pub fn loss(&self, clean: Score) -> f64 {
        self.mean(|score| clean.accuracy - score.accuracy)
    }

    fn mean(&self, value: impl Fn(&Score) -> f64) -> f64 {
        self.points.iter().map(|(_, score)| value(score)).sum::<f64>() / self.points.len().max(1) as f64
    }
}

impl NetworkStress {
    fn new(network: &str, clean: Score, curves: Vec<FaultCurve>) -> Self {
        let mean = |value: &dyn Fn(&FaultCurve) -> f64| {
            curves.iter().map(value).sum::<f64>() / curves.len().max(1) as f64
        };
        NetworkStress {
            network: network.into(),
            clean,
            mean_loss: mean(&|curve| curve.loss(clean)),
            worst_loss: curves.iter().map(|c| c.loss(clean)).fold(f64::NEG_INFINITY, f64::max),
            corruption_error: None,
            relative_corruption_error: None,
            calibration_error: mean(&|curve| curve.mean(|score| score.calibration_error)),
            verdict: String::new(),
            curves,
        }
    }
}

/// Corruption errors relative to the reference's (Hendrycks & Dietterich 2019, equations 1 and 2): per
/// fault the ratio of errors summed over severities, then the mean over faults.
fn relate(networks: &mut [NetworkStress], reference: Option<&str>) {
    let Some(reference) = networks.iter().find(|n| Some(n.network.as_str()) == reference).cloned() else {
        return;
    };
    let error = |curve: &FaultCurve| curve.mean(|score| 100.0 - score.accuracy);
    // Faults that cost the reference nothing say nothing relative to it.
    let mean = |ratios: Vec<f64>| {
        let finite: Vec<f64> = ratios.into_iter().filter(|r| r.is_finite()).collect();
        (!finite.is_empty()).then(|| 100.0 * finite.iter().sum::<f64>() / finite.len() as f64)
    };
    for network in networks {
        let pairs = || network.curves.iter().zip(&reference.curves);
        let plain = pairs().map(|(own, other)| error(own) / error(other)).collect();
        let beyond = pairs()
            // What rounding leaves is no loss.
            .filter(|(_, other)| other.loss(reference.clean) > 1e-9)
            .map(|(own, other)| own.loss(network.clean) / other.loss(reference.clean))
            .collect();
        (network.corruption_error, network.relative_corruption_error) = (mean(plain), mean(beyond));
    }
}
