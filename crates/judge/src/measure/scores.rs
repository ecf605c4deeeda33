//! Scores under faults: the primary metric, breaking points, errors relative to a reference.

use taxel_data::Task;
use taxel_learn::certainty::SureAnswers;
use taxel_learn::metrics::{Levels, Outcome};

use super::parts::PartOutcome;
use crate::error::Result;
use crate::values::{FaultCurve, FoldLoss, NetworkStress, Primary, Score};

/// Computes the scores over all parts.
pub(super) fn score(task: &Task, outcomes: &[&PartOutcome]) -> Result<Score> {
    Ok(Score {
        score: pooled(task, outcomes),
        calibration_error: calibration_error(task, outcomes)?,
        refused: outcomes.iter().map(|a| a.refused).sum(),
        unknown: unknown(outcomes),
    })
}

/// Returns the share of samples that gates of the other folds find unknown; none where a fold has no gate.
fn unknown(outcomes: &[&PartOutcome]) -> Option<f64> {
    let counts = outcomes.iter().map(|part| part.unknown).collect::<Option<Vec<_>>>()?;
    let [unknown, all] = [0, 1].map(|at| counts.iter().map(|count| [count.0, count.1][at]).sum::<usize>());
    (all > 0).then(|| unknown as f64 / all as f64)
}

/// Counts the answers that are 90 % sure, of clean or of broken samples; none of values, and where there are no such samples.
pub(super) fn sure(outcomes: &[&PartOutcome], is_broken: bool) -> Option<SureAnswers> {
    let counts =
        outcomes.iter().filter(|part| part.broken.is_some() == is_broken).filter_map(|part| part.sure);
    let (mut answers, mut sure, mut right) = (0, 0, 0);
    for count in counts {
        (answers, sure, right) = (answers + count.answers, sure + count.sure, right + count.right);
    }
    let share = |part: usize, of: usize| part as f64 / of.max(1) as f64;
    (answers > 0).then(|| SureAnswers { share: share(sure, answers), right: share(right, sure) })
}

/// Returns the primary metric over all samples.
fn pooled(task: &Task, outcomes: &[&PartOutcome]) -> f64 {
    Primary::of(task).metric().pooled(task, outcomes.iter().map(|a| &a.outcome))
}

/// Returns the expected calibration error over all samples; none of values, which have no probability.
fn calibration_error(task: &Task, outcomes: &[&PartOutcome]) -> Result<Option<f64>> {
    let (mut labels, mut all) = (vec![], vec![]);
    for part in outcomes {
        let Outcome::Labels { truth, probabilities, .. } = &part.outcome else { return Ok(None) };
        labels.extend_from_slice(truth);
        all.extend_from_slice(probabilities);
    }
    Ok(Some(Levels::of_task(task).calibration(&all, &labels)?.0))
}

/// Returns score and loss of one network fold by fold.
pub(super) fn folds(task: &Task, outcomes: &[&PartOutcome]) -> Vec<FoldLoss> {
    let mut numbers: Vec<usize> = outcomes.iter().map(|a| a.fold).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let primary = Primary::of(task);
    let of = |fold: usize| {
        let of_fold = || outcomes.iter().filter(move |a| a.fold == fold);
        let score = |a: &&PartOutcome| pooled(task, &[*a]);
        let clean = of_fold().find(|a| a.broken.is_none()).map(score)?;
        let broken: Vec<f64> = of_fold().filter(|a| a.broken.is_some()).map(score).collect();
        let mean = broken.iter().sum::<f64>() / broken.len().max(1) as f64;
        Some(FoldLoss { fold, score: clean, loss: primary.worsening(mean, clean) })
    };
    numbers.into_iter().filter_map(of).collect()
}

/// Percentage points above chance below which there is no margin to lose; of values as [`Primary::share`] says.
const MARGIN: f64 = 2.0;

/// Checks whether a score is enough better than chance for there to be something to lose.
pub(super) fn has_margin(primary: &Primary, clean: f64, chance: f64) -> bool {
    primary.worsening(chance, clean) > primary.share(MARGIN, chance)
}

/// Returns the first severity at which half of the margin above chance is lost; none without a margin.
pub(super) fn breaks_at(primary: &Primary, points: &[(u8, Score)], clean: f64, chance: f64) -> Option<u8> {
    let half = chance + (clean - chance) / 2.0;
    let has_margin = has_margin(primary, clean, chance);
    let broken = |(_, score): &&(u8, Score)| has_margin && !primary.prefers(score.score, half);
    points.iter().find(broken).map(|(severity, _)| *severity)
}

/// Returns one network under all faults, before it is related to another.
pub(super) fn stressed(
    primary: &Primary,
    network: &str,
    clean: Score,
    curves: Vec<FaultCurve>,
) -> NetworkStress {
    let mean = |value: &dyn Fn(&FaultCurve) -> f64| {
        curves.iter().map(value).sum::<f64>() / curves.len().max(1) as f64
    };
    NetworkStress {
        network: network.into(),
        clean,
        mean_loss: mean(&|curve| curve.loss(clean, primary)),
        worst_loss: curves.iter().map(|c| c.loss(clean, primary)).fold(f64::NEG_INFINITY, f64::max),
        corruption_error: None,
        relative_corruption_error: None,
        calibration_error: clean
            .calibration_error
            .map(|_| mean(&|curve| curve.mean(|score| score.calibration_error.unwrap_or(0.0)))),
        sure: None,
        sure_when_broken: None,
        verdict: String::new(),
        curves,
        other: None,
        folds: vec![],
    }
}

/// Sets corruption errors relative to the reference's (Hendrycks & Dietterich 2019, equations 1 and 2): per
/// fault the ratio of errors summed over severities, then the mean over faults.
pub(super) fn relate(primary: &Primary, networks: &mut [NetworkStress], reference: Option<&str>) {
    let Some(reference) = networks.iter().find(|n| Some(n.network.as_str()) == reference).cloned() else {
        return;
    };
    // A metric that says no error leaves nothing finite.
    let error = |curve: &FaultCurve| curve.mean(|score| primary.error(score.score).unwrap_or(f64::NAN));
    // Faults that cost the reference nothing say nothing relative to it.
    let mean = |ratios: Vec<f64>| {
        let finite: Vec<f64> = ratios.into_iter().filter(|r| r.is_finite()).collect();
        (!finite.is_empty()).then(|| 100.0 * finite.iter().sum::<f64>() / finite.len() as f64)
    };
    for network in networks {
        let pairs = || network.curves.iter().zip(&reference.curves);
        let plain = pairs().map(|(one, other)| error(one) / error(other)).collect();
        let beyond = pairs()
            // What rounding leaves is no loss.
            .filter(|(_, other)| other.loss(reference.clean, primary) > 1e-9)
            .map(|(one, other)| one.loss(network.clean, primary) / other.loss(reference.clean, primary))
            .collect();
        (network.corruption_error, network.relative_corruption_error) = (mean(plain), mean(beyond));
    }
}
