//! Scores under faults: accuracy, breaking points, errors relative to a reference.

use taxel_learn::metrics::Levels;

use super::parts::Answer;
use crate::error::Result;
use crate::values::{FaultCurve, FoldLoss, NetworkStress, Score};

/// Scores over all parts.
pub(super) fn score(levels: &Levels, answers: &[&Answer]) -> Result<Score> {
    let truth: Vec<u32> = answers.iter().flat_map(|a| a.truth.iter().copied()).collect();
    let predicted = answers.iter().flat_map(|a| &a.predicted);
    let right = truth.iter().zip(predicted).filter(|(truth, predicted)| truth == predicted).count();
    let probabilities: Vec<f32> = answers.iter().flat_map(|a| a.probabilities.iter().copied()).collect();
    let (calibration_error, _) = levels.calibration(&probabilities, &truth)?;
    Ok(Score {
        accuracy: 100.0 * right as f64 / truth.len().max(1) as f64,
        calibration_error,
        refused: answers.iter().map(|a| a.refused).sum(),
    })
}

/// Accuracy and loss of one network fold by fold.
pub(super) fn folds(answers: &[&Answer]) -> Vec<FoldLoss> {
    let mut numbers: Vec<usize> = answers.iter().map(|a| a.fold).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let of = |fold: usize| {
        let own = || answers.iter().filter(move |a| a.fold == fold);
        let clean = own().find(|a| a.broken.is_none())?.accuracy();
        let broken: Vec<f64> = own().filter(|a| a.broken.is_some()).map(|a| a.accuracy()).collect();
        let mean = broken.iter().sum::<f64>() / broken.len().max(1) as f64;
        Some(FoldLoss { fold, accuracy: clean, loss: clean - mean })
    };
    numbers.into_iter().filter_map(of).collect()
}

/// Percentage points above chance below which there is no margin to lose.
pub(super) const MARGIN: f64 = 2.0;

/// The first severity at which half of the margin above chance is lost; none without a margin.
pub(super) fn breaks_at(points: &[(u8, Score)], clean: f64, chance: f64) -> Option<u8> {
    let half = chance + (clean - chance) / 2.0;
    let broken = |(_, score): &&(u8, Score)| clean - chance > MARGIN && score.accuracy <= half;
    points.iter().find(broken).map(|(severity, _)| *severity)
}

/// One network under all faults, before it is related to another.
pub(super) fn stressed(network: &str, clean: Score, curves: Vec<FaultCurve>) -> NetworkStress {
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
        other: None,
        folds: vec![],
    }
}

/// Corruption errors relative to the reference's (Hendrycks & Dietterich 2019, equations 1 and 2): per
/// fault the ratio of errors summed over severities, then the mean over faults.
pub(super) fn relate(networks: &mut [NetworkStress], reference: Option<&str>) {
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
