//! True values of a scene: their names and units.
//!
//! # Reference
//!
//! None.

/// Endings of names and the units that they stand for; longer ones first.
const ENDINGS: [(&str, &str); 9] = [
    ("_kpa_per_mm", "kPa/mm"),
    ("_n_per_mm", "N/mm"),
    ("_mpa", "MPa"),
    ("_deg", "°"),
    ("_bit", "bits"),
    ("_mm", "mm"),
    ("_n", "N"),
    ("_s", "s"),
    ("shore", "Shore A"),
];

/// Returns the quantity of a true value: its name without the unit, and the unit; none of a ratio, a number or a level.
///
/// ```
/// use taxel_scenes::quantity_of;
///
/// assert_eq!(quantity_of("stiffness_n_per_mm"), ("stiffness", Some("N/mm")));
/// assert_eq!(quantity_of("shore"), ("shore", Some("Shore A")));
/// assert_eq!(quantity_of("hardness_level"), ("hardness_level", None));
/// ```
pub fn quantity_of(name: &str) -> (&str, Option<&'static str>) {
    let ending = ENDINGS.iter().find_map(|(ending, unit)| Some((name.strip_suffix(ending)?, *unit)));
    match ending {
        Some(("", unit)) => (name, Some(unit)),
        Some((stem, unit)) => (stem, Some(unit)),
        None => (name, None),
    }
}
