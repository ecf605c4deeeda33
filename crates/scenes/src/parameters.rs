//! Tables of parameters: one table for a simulation and for the explanation.
//!
//! # Reference
//!
//! None here: each row names its own source.

use crate::Effect;
use crate::world::Removable;

/// A row of the table that [`explain`](crate::explain) prints and the simulation computes with.
pub(crate) struct Parameter {
    pub(crate) effect: &'static str,
    pub(crate) name: &'static str,
    /// One value, or one per finger, level or step.
    pub(crate) value: &'static [f64],
    pub(crate) unit: &'static str,
    pub(crate) source: &'static str,
    pub(crate) why: &'static str,
}

impl Parameter {
    /// Returns the only value, or the first.
    pub(crate) fn get(&self) -> f64 {
        self.value[0]
    }

    /// Returns the value so far from the lowest to the highest, a share in 0..1.
    pub(crate) fn between(&self, share: f64) -> f64 {
        self.value[0] + (self.value[1] - self.value[0]) * share
    }

    /// Returns the value likewise, with equal steps of the logarithm.
    pub(crate) fn log_between(&self, share: f64) -> f64 {
        self.value[0] * (self.value[1] / self.value[0]).powf(share)
    }
}

/// The source of a value that nobody published.
pub(crate) const ASSUMED: &str = "assumed";

/// Defines the constants of a table and the table in one go, so that none is forgotten.
macro_rules! parameters {
    ($($id:ident: $effect:literal, $name:literal, $value:expr, $unit:literal, $source:expr, $why:expr;)*) => {
        $(pub(super) const $id: Parameter = Parameter {
            effect: $effect, name: $name, value: &$value, unit: $unit, source: $source, why: $why,
        };)*
        const TABLE: &[Parameter] = &[$($id),*];
    };
}
pub(crate) use parameters;

/// Returns the table as [`explain`](crate::explain) gives it.
pub(crate) fn rows(table: &[Parameter], removable: &Removable) -> Vec<Effect> {
    let row = |p: &Parameter| Effect {
        name: p.effect.into(),
        parameter: p.name.into(),
        value: p.value.iter().map(f64::to_string).collect::<Vec<_>>().join(", "),
        unit: p.unit.into(),
        source: p.source.into(),
        why: p.why.into(),
        removable: removable.has(p.effect),
    };
    table.iter().map(row).collect()
}
