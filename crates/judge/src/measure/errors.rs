//! How far the values of the rows of a run lie from the true ones.

use taxel_data::{Quantity, Targets, Values};
use taxel_learn::Error;
use taxel_learn::certainty::{HeldOutParts, HeldOutValues, Intervals};
use taxel_learn::metrics::{Outcome, Scores, scores};

use super::chance::means;
use crate::case::Case;
use crate::error::Result;
use crate::values::{CoveredShare, QuantityErrors, RowErrors};

/// Points of a scatter plot at most.
const POINTS: usize = 400;

/// Measures the errors of each row over all its test parts. Nothing of classes.
///
/// # Errors
/// Records that do not fit the task.
pub(super) fn errors(case: &Case) -> Result<Vec<RowErrors>> {
    let Some(values) = case.dataset.targets.values() else { return Ok(vec![]) };
    let mut all = vec![];
    for name in case.compared() {
        let Some(held) = HeldOutValues::of_folds(case.records(name), &case.dataset) else {
            return Ok(vec![]);
        };
        if held.is_empty() {
            continue;
        }
        let parts = HeldOutParts::of(&case.results.protocol);
        let intervals = Intervals::fit(&held, parts, &case.dataset.digest);
        let quantities = values.quantities().iter().enumerate();
        let of_quantity = |(at, quantity)| of_quantity(&held, at, quantity, intervals.as_ref());
        all.push(RowErrors {
            network: name.into(),
            quantities: quantities.map(of_quantity).collect::<Result<_>>()?,
        });
    }
    Ok(all)
}

fn of_quantity(
    held: &HeldOutValues,
    at: usize,
    quantity: &Quantity,
    intervals: Option<&Intervals>,
) -> Result<QuantityErrors> {
    let column =
        |values: &[f32]| values.iter().skip(at).step_by(held.quantities).copied().collect::<Vec<f32>>();
    let (truth, predicted) = (column(&held.truth), column(&held.predicted));
    let targets = Targets::Values(Values::new(vec![quantity.clone()], truth.clone()));
    let rows: Vec<usize> = (0..truth.len()).collect();
    let task = targets.task();
    let mean = targets.values().map_or(vec![], means).repeat(rows.len());
    let of_mean = scores(&task, &Outcome::new(&targets, &rows, mean))?;
    let of_row = scores(&task, &Outcome::new(&targets, &rows, predicted.clone()))?;
    let value = |scores: &Scores, name: &str| -> Result<f64> {
        let missing =
            || Error::Metrics { what: "metrics of values", reason: format!("`{name}` is not among them") };
        Ok(scores.get(name).ok_or_else(missing)?)
    };
    let of = |name: &str| value(&of_row, name);
    let points = truth.iter().zip(&predicted).step_by(truth.len().div_ceil(POINTS).max(1));
    let interval = intervals.and_then(|intervals| intervals.at(0.9)).map(|at_90| CoveredShare {
        covered: at_90.covered,
        worst_group: at_90.worst_group,
        width: at_90.width[at],
    });
    Ok(QuantityErrors {
        name: quantity.name.clone(),
        unit: quantity.unit.clone(),
        mae: of("mae")?,
        rmse: of("rmse")?,
        r2: of("r2")?,
        median: of("median_error")?,
        p95: of("p95_error")?,
        relative_mae: of("relative_mae")?,
        of_mean: value(&of_mean, "mae")?,
        interval,
        points: points.map(|(truth, predicted)| [*truth, *predicted]).collect(),
    })
}
