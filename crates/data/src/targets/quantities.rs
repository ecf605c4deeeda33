//! Names and units of quantities, from the names of their arrays or columns.

use crate::dataset::raw::Raw;
use crate::dataset::targets::{Quantity, Values};
use crate::options::ReadOptions;
use crate::unit::is_known;
use crate::{Error, Result};

impl Quantity {
    /// Makes quantities of names. A known unit at the end of a name is taken for the unit: `force_N`, `force [N]`, `force (N)`.
    /// Names that would then be equal keep their full text.
    ///
    /// ```
    /// let force = &taxel_data::Quantity::named(&["force_N"])[0];
    /// assert_eq!((force.name.as_str(), force.unit.as_deref()), ("force", Some("N")));
    /// ```
    pub fn named(names: &[impl AsRef<str>]) -> Vec<Self> {
        let each: Vec<(&str, usize)> = names.iter().map(|name| (name.as_ref(), 1)).collect();
        named_after(&each)
    }
}

/// Returns quantities that are called after their arrays or columns, each of so many numbers a row. A known unit at the end of a name is taken
/// for the unit: `force_N`, `force [N]`, `force (N)`. Names that would then be equal keep their full text.
pub(crate) fn named_after(arrays: &[(&str, usize)]) -> Vec<Quantity> {
    let of_array = |(array, width): &(&str, usize)| {
        let (stem, unit) = without_unit(array);
        let numbered = |name: &str, i: usize| match width {
            1 => name.to_string(),
            _ => format!("{name}-{i}"),
        };
        let unit = unit.map(String::from);
        (0..*width).map(|i| (numbered(array, i), numbered(stem, i), unit.clone())).collect::<Vec<_>>()
    };
    let all: Vec<(String, String, Option<String>)> = arrays.iter().flat_map(of_array).collect();
    let is_shared = |at: usize| {
        let others = all.iter().enumerate().filter(|(other, _)| *other != at);
        others.into_iter().any(|(_, (full, stem, _))| *stem == all[at].1 || *full == all[at].1)
    };
    let one = |(at, (full, stem, unit)): (usize, &(String, String, Option<String>))| Quantity {
        name: if is_shared(at) { full.clone() } else { stem.clone() },
        unit: unit.clone(),
    };
    all.iter().enumerate().map(one).collect()
}

/// Parts a name from the unit at its end. Of several units, as in `stiffness_N_mm`, none is taken: the last alone would be
/// wrong.
fn without_unit(name: &str) -> (&str, Option<&str>) {
    let bracketed = [('[', ']'), ('(', ')')].into_iter().find_map(|(open, close)| {
        let (stem, unit) = name.trim_end().strip_suffix(close)?.rsplit_once(open)?;
        Some((stem.trim_end(), unit.trim()))
    });
    if let Some((stem, unit)) = bracketed {
        let is_unit = is_known(unit) && !stem.is_empty();
        return if is_unit { (stem, Some(unit)) } else { (name, None) };
    }
    let ends_in_unit = |text: &str| {
        text.rsplit_once('_').is_some_and(|(_, last)| is_known(last) || matches!(last, "per" | "s" | "ms"))
    };
    match name.rsplit_once('_') {
        Some((stem, unit)) if !stem.is_empty() && is_known(unit) && !ends_in_unit(stem) => (stem, Some(unit)),
        _ => (name, None),
    }
}

/// Says that targets were read as values, and how to read them as classes; nothing where the options ask for values.
pub(crate) fn values_said(quantities: &[Quantity], options: &ReadOptions) -> Option<String> {
    let names: Vec<String> = quantities.iter().map(|quantity| format!("{:?}", quantity.name)).collect();
    let names = names.join(", ");
    (!options.wants_values()).then(|| {
        format!("{names} are values, as they have fractions; to make them classes, list them in labels.json under classes")
    })
}

/// Returns the values under the names that the options give; refuses names for targets that are no values, and another number of
/// them.
pub(crate) fn renamed(values: Option<Values>, raw: &Raw, options: &ReadOptions) -> Result<Option<Values>> {
    let Some(names) = &options.quantities else { return Ok(values) };
    let refuse = |why: String| Err(Error::file(&raw.file, format!("quantities = {:?} {why}", names.each())));
    let Some(values) = values else {
        return refuse(
            "name values, and the targets are classes; say task = \"values\" or leave it out".into(),
        );
    };
    let (given, held) = (names.each().len(), values.quantities().len());
    if given != held {
        return refuse(format!("are {given} names for {held} columns of {}; give one of each", raw.y_name));
    }
    Ok(Some(Values::new(Quantity::named(names.each()), values.values().to_vec())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(arrays: &[(&str, usize)]) -> Vec<String> {
        let text = |quantity: Quantity| match quantity.unit {
            Some(unit) => format!("{} in {unit}", quantity.name),
            None => quantity.name,
        };
        named_after(arrays).into_iter().map(text).collect()
    }

    #[test]
    fn a_known_unit_at_the_end_of_a_name_is_taken() {
        for (name, read) in [
            ("force_N", "force in N"),
            ("depth_mm", "depth in mm"),
            ("force [N]", "force in N"),
            ("force(mN)", "force in mN"),
            ("weight_kg", "weight in kg"),
            ("y", "y"),
            ("_N", "_N"),
            ("force_n", "force_n"),
            ("slip_speed_cm_s", "slip_speed_cm_s"),
            ("stiffness_N_mm", "stiffness_N_mm"),
            ("lines_per_mm", "lines_per_mm"),
            ("stiffness [N/mm]", "stiffness [N/mm]"),
        ] {
            assert_eq!(named(&[(name, 1)]), [read]);
        }
    }

    #[test]
    fn names_that_would_be_equal_keep_their_full_text() {
        assert_eq!(named(&[("force_N", 1), ("force_mN", 1)]), ["force_N in N", "force_mN in mN"]);
        assert_eq!(named(&[("force_N", 1), ("force", 1)]), ["force_N in N", "force"]);
        assert_eq!(
            named(&[("place_mm", 2), ("force_N", 1)]),
            ["place-0 in mm", "place-1 in mm", "force in N"]
        );
    }
}
