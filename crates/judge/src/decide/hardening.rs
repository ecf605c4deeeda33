//! Fault-augmented networks beside the same trained on clean samples.

use super::statistics::corrected_t;
use crate::error::Result;
use crate::values::{
    Change, FaultCurve, FoldLoss, Hardened, Judged, Judgement, NetworkStress, Stress, UnseenFault,
};

/// Returns every fault-augmented row that has a twin trained on clean samples.
///
/// # Errors
/// Losses that are not finite.
pub fn hardening(judgement: &Judgement) -> Result<Vec<Hardened>> {
    let Some(stress) = &judgement.stress else { return Ok(vec![]) };
    let of = |name: &str| stress.networks.iter().find(|network| network.network == name);
    let mut found = vec![];
    for judged in &judgement.networks {
        let Some(clean) = judged.results.hardening.as_ref().and_then(|how| how.clean.as_deref()) else {
            continue;
        };
        if let (Some(broken), Some(before), Some(twin)) =
            (of(&judged.results.network), of(clean), judgement.network(clean))
        {
            found.push(Hardened {
                unseen: unseen(stress, clean, before, broken, judgement),
                ..compare((twin, before), (judged, broken))?
            });
        }
    }
    Ok(found)
}

fn compare(
    (twin, before): (&Judged, &NetworkStress),
    (judged, after): (&Judged, &NetworkStress),
) -> Result<Hardened> {
    let folds = &judged.results.folds;
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
        train_seconds: [twin.train_seconds, judged.train_seconds],
        unseen: vec![],
    })
}

/// Returns the faults that were left out of trainings of this network, in the order of the table.
fn unseen(
    stress: &Stress,
    clean: &str,
    before: &NetworkStress,
    seen: &NetworkStress,
    judgement: &Judgement,
) -> Vec<UnseenFault> {
    let curve = |network: &NetworkStress, of: &FaultCurve| {
        Some(
            network.curves.iter().find(|curve| curve.fault == of.fault)?.loss(network.clean, &stress.primary),
        )
    };
    let twin = |name: &str| {
        let row = judgement.probes.iter().find(|row| row.network == name)?;
        row.hardening.as_ref()?.clean.clone()
    };
    let probes = stress.unseen.iter().filter(|probe| twin(&probe.network).as_deref() == Some(clean));
    probes
        .filter_map(|probe| {
            let of = probe.curves.first()?;
            Some(UnseenFault {
                fault: of.fault,
                clean: curve(before, of)?,
                unseen: of.loss(probe.clean, &stress.primary),
                seen: curve(seen, of)?,
            })
        })
        .collect()
}
