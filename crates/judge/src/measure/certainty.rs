//! How sure the rows of a run may be, by the predictions that it stores.

use taxel_learn::certainty::{Certainty, HeldOut, HeldOutParts, UnknownDraw, UnknownScores};

use crate::case::Case;
use crate::error::Result;
use crate::values::{RowCertainty, UnknownMeans};

/// Fits how sure each row may be. Nothing of values, and of rows with fewer than 30 predictions.
///
/// # Errors
/// A damaged `unknown.json`.
pub(super) fn certainty(case: &Case) -> Result<Vec<RowCertainty>> {
    let (levels, results) = (case.levels(), &case.results);
    let parts = HeldOutParts::of(&results.protocol);
    let mut all = vec![];
    for name in case.compared() {
        let Some(held) = HeldOut::of_folds(case.records(name), &case.dataset) else { return Ok(vec![]) };
        let (digest, seed) = (&case.dataset.digest, results.seed);
        let fitted = Certainty::fit_with_reliability(&held, &levels, parts, digest, seed)?;
        let Some((certainty, reliability)) = fitted else { continue };
        all.push(RowCertainty { network: name.into(), certainty, reliability, unknown: None });
    }
    tried(case, &mut all)?;
    Ok(all)
}

/// Adds how well the gate of each row tells classes that it has not learned, as the run folder says now.
///
/// # Errors
/// A damaged `unknown.json`.
pub(super) fn tried(case: &Case, rows: &mut [RowCertainty]) -> Result<()> {
    let tried = case.folder.unknown()?.unwrap_or_default();
    for row in rows {
        row.unknown = tried.iter().find(|scores| scores.network == row.network).and_then(means);
    }
    Ok(())
}

fn means(scores: &UnknownScores) -> Option<UnknownMeans> {
    let draws = scores.draws.len();
    let mean = |value: fn(&UnknownDraw) -> f64| scores.draws.iter().map(value).sum::<f64>() / draws as f64;
    (draws > 0).then(|| UnknownMeans {
        draws,
        auroc: mean(|draw| draw.auroc),
        auroc_softmax: mean(|draw| draw.auroc_softmax),
        refused: mean(|draw| draw.refused),
        false_alarms: mean(|draw| draw.false_alarms),
    })
}
