//! Matches channels by their names.

/// Returns where each `wanted` channel is among those `held`; none where the order is the same, or where one of the two has no
/// names and channels are matched by their place.
///
/// # Errors
///
/// A channel that is missing, in words; names that occur twice say nothing about which is which.
pub(crate) fn places(wanted: &[String], held: &[String]) -> Result<Option<Vec<usize>>, String> {
    if wanted == held || wanted.is_empty() || held.is_empty() {
        return Ok(None);
    }
    let place = |name: &String| {
        let mut at = (0..held.len()).filter(|at| held[*at] == *name);
        match (at.next(), at.next()) {
            (Some(one), None) => Ok(one),
            (None, _) => Err(format!("has no channel {name:?}; it has {}", listed(held))),
            (Some(_), Some(_)) => Err(format!("has two channels {name:?}; rename one")),
        }
    };
    wanted.iter().map(place).collect::<Result<_, _>>().map(Some)
}

/// Returns the names of the channels of columns that hold several numbers each: `force`, `imu[0]`, `imu[1]`; none where
/// a column has no name.
pub(crate) fn numbered<'n>(columns: impl Iterator<Item = (&'n str, usize)>) -> Vec<String> {
    let mut all = vec![];
    for (name, count) in columns {
        match (name, count) {
            ("", _) => return vec![],
            (_, 1) => all.push(name.into()),
            _ => all.extend((0..count).map(|i| format!("{name}[{i}]"))),
        }
    }
    all
}

/// Lists names for a message.
pub(crate) fn listed(names: &[String]) -> String {
    listed_up_to(names, 16)
}

/// Lists `most` names for a message, and counts the others.
pub(crate) fn listed_up_to(names: &[String], most: usize) -> String {
    match names.len().saturating_sub(most) {
        0 => names.join(", "),
        more => format!("{} and {more} more", names[..most].join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_without_names_are_matched_by_place() {
        let names = ["a".to_string(), "b".to_string()];
        assert_eq!(places(&[], &names), Ok(None));
        assert_eq!(places(&names, &[]), Ok(None));
        let turned = ["b".to_string(), "a".to_string()];
        assert_eq!(places(&names, &turned), Ok(Some(vec![1, 0])));
    }
}
