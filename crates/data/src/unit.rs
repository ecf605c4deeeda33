//! Units that differ by a power of ten: `V` and `mV`.
//!
//! # Reference
//! The SI Brochure, 9th edition, Table 7 (prefixes). Own code in place of a crate: those of crates.io convert types that are
//! known when a program is built, not the text of a file.

use std::fmt::{self, Display};

/// Prefixes and their powers of ten.
const PREFIXES: [(&str, i32); 10] = [
    ("p", -12),
    ("n", -9),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("m", -3),
    ("c", -2),
    ("h", 2),
    ("k", 3),
    ("M", 6),
];

/// Units that sensors have, each with other ways to write it.
const UNITS: [&[&str]; 14] = [
    &["V", "volt", "volts"],
    &["A", "ampere", "amperes"],
    &["N", "newton", "newtons"],
    &["Pa", "pascal", "pascals"],
    &["F", "farad", "farads"],
    &["Ω", "Ohm", "ohm", "ohms"],
    &["m", "metre", "metres", "meter", "meters"],
    &["g", "gram", "grams"],
    &["T", "tesla"],
    &["H", "henry"],
    &["C", "coulomb"],
    &["S", "siemens"],
    &["bar"],
    &["Nm", "N·m", "N m"],
];

/// A power of ten between two units of one quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnitFactor {
    from: String,
    to: String,
    power: i32,
}

impl UnitFactor {
    /// Returns the factor from one unit to another of the same quantity; none where it is no power of ten or a unit is not
    /// known.
    pub fn between(from: &str, to: &str) -> Option<Self> {
        let ((unit, power), (other, less)) = (parsed(from)?, parsed(to)?);
        (unit == other).then(|| UnitFactor { from: from.into(), to: to.into(), power: power - less })
    }

    /// Converts a value; rounded once.
    pub fn convert(&self, value: f32) -> f32 {
        let factor = 10_f64.powi(self.power.abs());
        let value = f64::from(value);
        (if self.power < 0 { value / factor } else { value * factor }) as f32
    }
}

impl Display for UnitFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let UnitFactor { from, to, power } = self;
        write!(f, "from {from} to {to} (times 10^{power})")
    }
}

/// Checks whether a text is a unit of the list, with a prefix or without one.
pub(crate) fn is_known(text: &str) -> bool {
    parsed(text).is_some()
}

/// Returns the position of a unit in [`UNITS`] and the power of ten of its prefix.
fn parsed(text: &str) -> Option<(usize, i32)> {
    let named = |text: &str| UNITS.iter().position(|names| names.contains(&text));
    let text = text.trim();
    named(text).map(|unit| (unit, 0)).or_else(|| {
        let mut prefixes = PREFIXES.iter();
        prefixes.find_map(|(prefix, power)| Some((named(text.strip_prefix(prefix)?)?, *power)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes_give_powers_of_ten() {
        for (from, to, power) in [
            ("V", "mV", 3),
            ("mV", "V", -3),
            ("kPa", "hPa", 1),
            ("µN", "mN", -3),
            ("cm", "mm", 1),
            ("volts", "mV", 3),
        ] {
            assert_eq!(UnitFactor::between(from, to).map(|unit| unit.power), Some(power), "{from} {to}");
        }
        for (from, to) in [("V", "N"), ("psi", "kPa"), ("°C", "K"), ("", "V"), ("counts", "mV"), ("m", "M")]
        {
            assert_eq!(UnitFactor::between(from, to), None, "{from} {to}");
        }
    }

    #[test]
    fn a_value_is_rounded_once() {
        let unit = UnitFactor::between("mV", "V").unwrap();
        assert_eq!(unit.convert(123.0), 0.123);
        assert_eq!(unit.to_string(), "from mV to V (times 10^-3)");
    }
}
