//! Samples without a target: refused, or left out where the options say so.

use crate::Error;
use crate::dataset::raw::Raw;
use crate::dataset::targets::Values;
use crate::options::{Drop, ReadOptions};

/// Most samples that a message names.
const NAMED: usize = 5;

/// Checks whether samples without a target are left out.
pub(crate) fn drops_missing(options: &ReadOptions) -> bool {
    options.drop.contains(&Drop::NoTarget)
}

/// Returns the places of the `rows` of which a value is missing.
pub(crate) fn missing_in(values: &Values, rows: &[usize]) -> Vec<usize> {
    let is_missing = |row: usize| values.of(&[row]).iter().any(|value| value.is_nan());
    (0..rows.len()).filter(|at| is_missing(rows[*at])).collect()
}

/// Takes rows of which a value is missing out of those that stay, and counts them.
pub(crate) fn leave_out_missing(keep: &mut [bool], values: &Values) -> usize {
    let rows: Vec<usize> =
        (0..keep.len().min(values.values().len() / values.quantities().len().max(1))).collect();
    let missing = missing_in(values, &rows);
    missing.iter().filter(|row| std::mem::take(&mut keep[**row])).count()
}

/// Refuses samples without a target: those at the places `missing`. `row` is the first one's row of targets, of `samples`.
pub(crate) fn no_target(
    raw: &Raw,
    values: &Values,
    (row, samples): (usize, usize),
    missing: &[usize],
    origins: &[String],
) -> Error {
    let column = values.of(&[row]).iter().position(|value| value.is_nan()).unwrap_or(0);
    let quantity = &values.quantities()[column].name;
    let named: Vec<&str> = missing.iter().take(NAMED).map(|at| origins[*at].as_str()).collect();
    let more = if missing.len() > NAMED { ", .." } else { "" };
    Error::file(
        &raw.file,
        format!(
            "{}[{row}] is NaN in {quantity}: {} of {samples} samples have no target: {}{more}; fill them in, or leave them \
             out with drop = [\"no-target\"] (--drop no-target)",
            raw.y_name,
            missing.len(),
            named.join(", ")
        ),
    )
}
