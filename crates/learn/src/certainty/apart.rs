//! Temperature and gate of each part of a split, fitted to the other parts.

use std::collections::BTreeMap;

use ndarray::{ArrayRef, IxDyn};
use taxel_data::Layout;

use crate::certainty::gate::Gates;
use crate::certainty::held_out::HeldOut;
use crate::certainty::temperature::fitted_temperature;
use crate::metrics::Levels;

/// Fits temperature and gates for each part to all others, rows of the raw samples `x` `[n, ..]` of that layout: what each part can be
/// judged with. One part alone has none but its own. A gate is missing where samples are too few.
pub fn fitted_apart(
    held: &HeldOut,
    raw: (Layout, &ArrayRef<f32, IxDyn>),
    levels: &Levels,
    keeps_groups: bool,
) -> BTreeMap<u32, (f64, Gates)> {
    let fit = |part: u32| {
        let others = held.select(|row| held.parts[row] != part);
        let others = if others.is_empty() { held.divided() } else { others.divided() };
        let temperature = fitted_temperature(&others.probabilities, &others.truth, levels.sizes());
        // That of the model which is judged.
        let own = held.places.get(&part);
        let gates = Gates::fit(&others, raw, levels, keeps_groups, own);
        (part, (temperature.unwrap_or(1.0), gates))
    };
    held.each_part().into_iter().map(fit).collect()
}
