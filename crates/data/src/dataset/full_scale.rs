//! Compares the highest possible value that is stated with the values.

use crate::{Error, Result};
use ndarray::ArrayViewD;

/// Values up to so many times the full scale are an offset or an overshoot.
const OVERSHOOT: f32 = 2.0;
/// One value in so many may be a damaged reading. Zeros do not count: most taxels of a skin touch nothing.
const DAMAGED: usize = 1000;

/// Refuses a full scale far below the values `x`: it is of another unit or depth, and all that is scaled by it is wrong.
pub(crate) fn refuse_far_below(at: &str, x: ArrayViewD<f32>, full_scale: Option<f32>) -> Result<()> {
    let Some(full_scale) = full_scale else { return Ok(()) };
    let (mut above, mut all, mut highest) = (0usize, 0usize, 0.0f32);
    for value in x.iter().map(|value| value.abs()).filter(|value| *value > 0.0 && value.is_finite()) {
        all += 1;
        above += usize::from(value > OVERSHOOT * full_scale);
        highest = highest.max(value);
    }
    if above * DAMAGED <= all {
        return Ok(());
    }
    let wanted = format!(
        "values reach {highest}, {:.1} % of those that are not 0 above {OVERSHOOT} times as much; say the highest value \
         of the sensor in the unit of the samples",
        100.0 * above as f64 / all as f64
    );
    Err(Error::Fact { at: at.into(), key: "full_scale", value: full_scale.to_string(), wanted })
}
