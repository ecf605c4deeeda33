//! Values in the order of other quantities.

use crate::dataset::targets::{Quantity, Values};

/// Name of values whose array says nothing of them.
const NAMELESS: &str = "y";

impl Values {
    /// Returns the values of the quantities that are `wanted`, by name and unit, in that order. Values without a unit are taken to
    /// have that one, and a single quantity without a name of its own is the single one that is wanted.
    ///
    /// # Errors
    /// The quantities that are here, where one that is wanted is not among them.
    pub fn of_quantities(&self, wanted: &[Quantity]) -> Result<Values, String> {
        let here = self.quantities();
        let is_nameless = wanted.len() == 1 && here.len() == 1 && here[0].name == NAMELESS;
        let place = |quantity: &Quantity| {
            let is_same = |other: &Quantity| {
                let alike = quantity.unit == other.unit || other.unit.is_none();
                (is_nameless || quantity.name == other.name) && alike
            };
            here.iter().position(is_same)
        };
        let Some(places) = wanted.iter().map(place).collect::<Option<Vec<usize>>>() else {
            return Err(here.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "));
        };
        let rows = self.values().chunks_exact(here.len().max(1));
        let ordered = rows.flat_map(|row| places.iter().map(|place| row[*place])).collect();
        Ok(Values::new(wanted.to_vec(), ordered))
    }
}
