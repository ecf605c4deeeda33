//! Temperature and gate of each part of a split, fitted to the other parts.

use std::collections::BTreeMap;

use crate::certainty::held_out::HeldOut;
use crate::certainty::seen::Seen;
use crate::certainty::temperature::fitted_temperature;
use crate::metrics::Levels;

/// Fits temperature and gate for each part to all others: what each part can be judged with. One part alone has none but its own.
/// The gate is missing where samples are too few.
pub fn fitted_apart(held: &HeldOut, levels: &Levels) -> BTreeMap<u32, (f64, Option<Seen>)> {
    let fit = |part: u32| {
        let others = held.select(|row| held.parts[row] != part);
        let others = if others.is_empty() { held.divided() } else { others.divided() };
        let temperature = fitted_temperature(&others.probabilities, &others.truth, levels.sizes());
        // That of the model which is judged.
        let own = held.places.get(&part);
        let gate = Seen::fit(&others, levels).and_then(|gate| match (gate.places.is_empty(), own) {
            (true, own) => Some(Seen { places: own?.clone(), ..gate }),
            (false, _) => Some(gate),
        });
        (part, (temperature.unwrap_or(1.0), gate))
    };
    held.each_part().into_iter().map(fit).collect()
}
