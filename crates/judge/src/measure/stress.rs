//! Scores under graded faults on raw readings: where each network breaks.

use std::collections::BTreeMap;

use taxel_data::Task;
use taxel_faults::{Fault, Layout};
use taxel_learn::{ModelInput, SensorFacts, require};

use super::chance::chance;
use super::held_out::apart;
use super::parts::{Corruption, PartOutcome, StressOutcomes, TestPart, parts, stressed_parts};
use super::scores::{breaks_at, folds, relate, score, stressed, sure};
use super::verdict::verdict;
use crate::case::Case;
use crate::error::{Error, Result};
use crate::values::{FaultCurve, FaultInfo, NetworkStress, OtherWay, Primary, Score, SensorRange, Stress};

/// Baselines and networks that corruption errors are relative to, the first that a run has.
const REFERENCES: [&str; 4] = ["k-nn", "mini-rocket", "mlp", "ridge"];

/// Faults of a stress test, and limits on its time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StressOptions {
    /// These faults only; all that have a meaning where it is empty.
    pub faults: Vec<Fault>,
    /// This severity only.
    pub severity: Option<u8>,
    /// At most so many test samples of each network; the others are left out evenly. Default 1000.
    pub samples: usize,
    /// Whether each network is tested both with and without a guard: its own, or one that is fitted on the training
    /// part of each fold. Default false.
    pub guard: bool,
    /// Worker threads, at most one per core; results do not depend on them.
    pub threads: usize,
}

impl Default for StressOptions {
    fn default() -> Self {
        StressOptions {
            faults: vec![],
            severity: None,
            samples: 1000,
            guard: false,
            threads: taxel_learn::threads(None),
        }
    }
}

/// Scores the saved networks of a run on broken test samples; nothing is trained. `start` hears the
/// number of steps, `tick` each of them.
///
/// Every sample is broken before it is encoded, in the same way for all networks. A sample that an
/// encoding refuses (no contact is found, for example) counts as wrong; of values as the mean of all samples, which is
/// what knowing nothing says.
///
/// # Errors
/// A fault without a meaning for these readings, models that are missing, readings that are not finite.
pub fn stress(
    case: &Case,
    options: &StressOptions,
    start: &dyn Fn(u64),
    tick: &(dyn Fn() + Sync),
) -> Result<Stress> {
    let everything: Vec<usize> = (0..case.dataset.len()).collect();
    let SensorFacts { sensor, from_samples } = taxel_learn::sensor(&case.dataset, &everything);
    let range = SensorRange { low: sensor.low, high: sensor.high, from_samples };
    let (faults, left_out) = faults(case, options, sensor.layout)?;
    let severities: Vec<u8> = options.severity.map_or_else(|| (1..=5).collect(), |one| vec![one]);
    let (names, probes) = (case.compared(), case.probes());
    let tested: Vec<&str> = names.iter().copied().chain(probes.iter().map(|(name, _)| *name)).collect();
    let (parts, of) = parts(case, &tested, options.samples)?;
    let mut corruptions: Vec<Corruption> = vec![None];
    for &fault in &faults {
        corruptions.extend(severities.iter().map(|&severity| Some((fault, severity))));
    }
    start((parts.len() * corruptions.len()) as u64);
    let threads = taxel_learn::threads(Some(options.threads));
    let apart = apart(case, &names, options.samples, threads)?;
    let how = (options.guard, threads);
    let outcomes = stressed_parts(case, &sensor, &parts, &corruptions, &apart, how, tick)?;
    let chance = chance(&case.dataset)?;
    let mut networks = vec![];
    for name in &names {
        networks.push(network(case, name, &outcomes, (&faults, &severities), chance)?);
    }
    let mut unseen = vec![];
    for (name, fault) in probes.into_iter().filter(|(_, fault)| faults.contains(fault)) {
        unseen.push(network(case, name, &outcomes, (&[fault], &severities), chance)?);
    }
    // In a learning curve rows bear the number of samples too.
    let row = |name: &str| {
        let rows = case.results.networks.iter().filter(|row| names.contains(&row.network.as_str()));
        rows.into_iter().find(|row| row.candidate == name || row.network == name)
    };
    let reference = REFERENCES.into_iter().find_map(|name| Some(row(name)?.network.as_str()));
    let primary = case.primary();
    relate(&primary, &mut networks, reference);
    for network in &mut networks {
        let inputs = inputs(case, &network.network)?;
        network.verdict = verdict(&primary, network, chance, &inputs);
    }
    Ok(Stress {
        seed: case.results.seed,
        primary,
        samples: different(&parts),
        of,
        range,
        chance,
        reference: reference.map(Into::into),
        faults: faults.into_iter().map(FaultInfo::of).collect(),
        left_out,
        networks,
        unseen,
        alarms: outcomes.alarms,
    })
}

/// Computes the scores of one network, clean and under every fault.
fn network(
    case: &Case,
    name: &str,
    outcomes: &StressOutcomes,
    tried: (&[Fault], &[u8]),
    chance: f64,
) -> Result<NetworkStress> {
    fn of<'a>(outcomes: &'a [PartOutcome], name: &str) -> Vec<&'a PartOutcome> {
        outcomes.iter().filter(|outcome| outcome.network == name).collect()
    }
    let (saved, switched) = (of(&outcomes.saved, name), of(&outcomes.other, name));
    let (task, primary) = (case.task(), case.primary());
    let clean = under(task, &saved, None)?;
    let curves = curves(task, &saved, tried, (clean, chance))?;
    let other = if switched.is_empty() {
        None
    } else {
        let curves = self::curves(task, &switched, tried, (clean, chance))?;
        let losses = curves.iter().map(|curve| curve.loss(clean, &primary)).sum::<f64>();
        let first = case.first_repetition(name).next();
        let card = first.map(|first| case.card(&first.key)).transpose()?;
        Some(OtherWay {
            is_guarded: card.is_none_or(|card| card.guard.is_none()),
            clean: under(task, &switched, None)?,
            mean_loss: losses / curves.len().max(1) as f64,
            curves,
        })
    };
    Ok(NetworkStress {
        folds: folds(task, &saved),
        sure: sure(&saved, false),
        sure_when_broken: sure(&saved, true),
        other,
        ..stressed(&primary, name, clean, curves)
    })
}

/// Computes the scores of one network on samples that are broken so.
fn under(task: &Task, outcomes: &[&PartOutcome], broken: Corruption) -> Result<Score> {
    score(task, &outcomes.iter().copied().filter(|a| a.broken == broken).collect::<Vec<_>>())
}

/// Computes the scores of one network under every fault, beside what it has on unbroken samples.
fn curves(
    task: &Task,
    outcomes: &[&PartOutcome],
    (faults, severities): (&[Fault], &[u8]),
    (clean, chance): (Score, f64),
) -> Result<Vec<FaultCurve>> {
    let (primary, mut curves) = (Primary::of(task), vec![]);
    for &fault in faults {
        let point = |&severity: &u8| Ok((severity, under(task, outcomes, Some((fault, severity)))?));
        let points: Vec<(u8, Score)> = severities.iter().map(point).collect::<Result<_>>()?;
        curves.push(FaultCurve {
            fault,
            breaks_at: breaks_at(&primary, &points, clean.score, chance),
            points,
        });
    }
    Ok(curves)
}

/// Returns the inputs of the first saved fold of a network.
fn inputs(case: &Case, network: &str) -> Result<Vec<ModelInput>> {
    match case.first_repetition(network).next() {
        Some(first) => Ok(case.card(&first.key)?.inputs.clone()),
        None => Ok(vec![]),
    }
}

/// Returns the faults to be tested, and those that have no meaning here.
fn faults(
    case: &Case,
    options: &StressOptions,
    layout: Layout,
) -> Result<(Vec<Fault>, BTreeMap<String, String>)> {
    if let Some(severity) = options.severity {
        require((1..=5).contains(&severity), "severity", severity, "must be in 1..=5")?;
    }
    let (mut faults, mut left_out) = (vec![], BTreeMap::new());
    for fault in Fault::ALL {
        let is_wanted = options.faults.contains(&fault);
        match fault.refusal(layout) {
            Some(reason) if is_wanted => {
                let (fault, layout) = (fault.name(), layout.describe());
                let source = taxel_faults::Error::Fault { fault, layout, reason };
                return Err(Error::Fault { source_label: case.dataset.source.to_string(), source });
            }
            Some(reason) => {
                left_out.insert(fault.name().into(), reason.into());
            }
            None if is_wanted || options.faults.is_empty() => faults.push(fault),
            None => {}
        }
    }
    Ok((faults, left_out))
}

/// Counts the different test samples of all parts.
fn different(parts: &[TestPart]) -> usize {
    let mut folds: Vec<(usize, usize)> = parts.iter().map(|part| (part.fold, part.len())).collect();
    folds.sort_unstable();
    folds.dedup();
    folds.into_iter().map(|(_, count)| count).sum()
}
