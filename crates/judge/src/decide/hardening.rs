//! What training under faults changes, network by network.

use super::statistics::corrected_t;
use crate::error::Result;
use crate::values::{
    Change, FaultCurve, FoldLoss, Hardened, Judged, Judgement, NetworkStress, Stress, Unmet,
};

/// Every row that was trained under faults and has a twin that was trained on clean samples.
///
/// # Errors
/// Losses that are not finite.
pub fn hardening(judgement: &Judgement) -> Result<Vec<Hardened>> {
    let Some(stress) = &judgement.stress else { return Ok(vec![]) };
    let of = |name: &str| stress.networks.iter().find(|own| own.network == name);
    let mut found = vec![];
    for own in &judgement.networks {
        let Some(clean) = own.results.hardening.as_ref().and_then(|how| how.clean.as_deref()) else {
            continue;
        };
        if let (Some(broken), Some(before), Some(twin)) =
            (of(&own.results.network), of(clean), judgement.network(clean))
        {
            found.push(Hardened {
                unmet: unmet(stress, clean, before, broken, judgement),
                ..compare((twin, before), (own, broken))?
            });
        }
    }
    Ok(found)
}

fn compare(
    (twin, before): (&Judged, &NetworkStress),
    (own, after): (&Judged, &NetworkStress),
) -> Result<Hardened> {
    let folds = &own.results.folds;
    let ratios = folds.iter().map(|fold| fold.test_samples as f64 / fold.train_samples.max(1) as f64);
    let ratio = ratios.sum::<f64>() / folds.len().max(1) as f64;
    let change = |value: fn(&FoldLoss) -> f64, whole: f64| -> Result<Change> {
        let differences: Vec<f64> = after
            .folds
            .iter()
            .filter_map(|fold| {
                Some(value(fold) - value(before.folds.iter().find(|other| other.fold == fold.fold)?))
            })
            .collect();
        if differences.len() < 2 {
            return Ok(Change { mean: whole, interval: None });
        }
        let test = corrected_t(&differences, ratio, 0.95)?;
        Ok(Change { mean: test.mean, interval: test.interval })
    };
    let scores = [before.clean.score, after.clean.score];
    let loss = [before.mean_loss, after.mean_loss];
    Ok(Hardened {
        network: after.network.clone(),
        clean: before.network.clone(),
        scores,
        score_change: change(|fold| fold.score, scores[1] - scores[0])?,
        loss,
        loss_change: change(|fold| fold.loss, loss[1] - loss[0])?,
        train_seconds: [twin.train_seconds, own.train_seconds],
        unmet: vec![],
    })
}

/// The faults that trainings of this network were spared, in the order of the table.
fn unmet(
    stress: &Stress,
    clean: &str,
    before: &NetworkStress,
    met: &NetworkStress,
    judgement: &Judgement,
) -> Vec<Unmet> {
    let curve = |own: &NetworkStress, of: &FaultCurve| {
        Some(own.curves.iter().find(|curve| curve.fault == of.fault)?.loss(own.clean, &stress.primary))
    };
    let twin = |name: &str| {
        let row = judgement.probes.iter().find(|row| row.network == name)?;
        row.hardening.as_ref()?.clean.clone()
    };
    let own = stress.unmet.iter().filter(|probe| twin(&probe.network).as_deref() == Some(clean));
    own.filter_map(|probe| {
        let of = probe.curves.first()?;
        Some(Unmet {
            fault: of.fault,
            clean: curve(before, of)?,
            unmet: of.loss(probe.clean, &stress.primary),
            met: curve(met, of)?,
        })
    })
    .collect()
}
