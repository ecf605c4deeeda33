//! Checks rows of targets that are values, and rows that belong to time steps.

use crate::dataset::problems::Problems;
use crate::dataset::raw::Raw;
use crate::dataset::spec_of::likeliest_layout;
use crate::dataset::targets::Values;
use crate::dataset::validate::wrong_length;
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::collections::HashMap;

/// Checks that there is a row of values for each sample or time step, and that none is infinite. Returns a number for each
/// row by which copies are compared: equal rows have the same.
pub(crate) fn check_values(raw: &Raw, values: &Values, faults: &mut Problems) -> Result<Vec<u32>> {
    let (rows, width) = (raw.target_rows(), values.quantities().len());
    let given = values.values().len() / width;
    if given != rows {
        return Err(wrong_length(raw, &raw.y_name, given));
    }
    let mut bad = None;
    for (i, value) in values.values().iter().enumerate().filter(|(_, value)| value.is_infinite()) {
        let sample = format!("{}: {}[{}]", raw.file, raw.y_name, i / width);
        faults.more(&mut bad, || Error::NotFinite { sample, index: vec![i % width], value: *value });
    }
    let mut numbers: HashMap<Vec<u32>, u32> = HashMap::new();
    let number = |row: &[f32]| {
        let bits = row.iter().map(|value| value.to_bits()).collect();
        let next = numbers.len() as u32;
        *numbers.entry(bits).or_insert(next)
    };
    Ok(values.values().chunks_exact(width).map(number).collect())
}

/// Refuses targets of time steps that no window takes, or that are not one for each time step.
pub(crate) fn refuse_steps(raw: &Raw, options: &ReadOptions) -> Result<()> {
    let Some(steps) = &raw.steps else { return Ok(()) };
    steps.refuse_without_windows(&raw.file, options.length)?;
    let given = [options.layout, raw.facts.layout, raw.format];
    let layout = likeliest_layout(given, &raw.dtype, raw.x.sample_shape());
    let Some(axis) = layout.time_axis() else {
        return Err(Error::NoTime { file: raw.file.clone(), layout });
    };
    let lengths = raw.x.lengths(axis);
    let differs = |(given, length): (&usize, &usize)| given != length;
    match steps.steps.iter().zip(&lengths).position(differs) {
        None => Ok(()),
        Some(at) => Err(Error::file(
            &raw.file,
            format!(
                "{} has {} targets for {}, which has {} time steps; give each time step one",
                raw.y_name, steps.steps[at], raw.origins[at], lengths[at]
            ),
        )),
    }
}
