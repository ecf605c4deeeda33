//! How many test samples would decide what is open.

use taxel_base::thousands;

use super::statistics::samples_to_decide;
use crate::values::{Choice, Evidence, Judgement, Test};

/// Level of significance of one comparison, and the share of cases in which a loss that is there is to be found.
const ALPHA: f64 = 0.05;
const POWER: f64 = 0.8;

/// Says with how many test samples, or groups where whole groups are tested, a loss of the margin would show for all of `open`; none where no
/// interval says how much their differences vary.
pub(super) fn deciding(choice: &Choice, judgement: &Judgement, open: &[&Evidence]) -> Option<String> {
    // Where samples of one group are on both sides of a cut, it is samples that are drawn.
    let by_group = choice.test == Test::GroupedPairs || judgement.results.protocol.keeps_groups();
    let groups = judgement.networks.iter().filter_map(|network| network.results.interval_groups).max();
    let groups = groups.filter(|_| by_group);
    let (units, called) = match groups {
        Some(groups) => (groups, "groups"),
        None => (judgement.results.samples, "samples"),
    };
    let of = |evidence: &&Evidence| {
        samples_to_decide(units as u64, choice.margin(), evidence.interval?, ALPHA, POWER)
    };
    let needed = open.iter().filter_map(of).max().filter(|needed| *needed > units as u64)?;
    let (needed, units) = (thousands(rounded(needed)), thousands(units as u64));
    let margin = choice.primary.margin(choice.margin());
    Some(format!(
        "A loss of {margin} would show with about {needed} {called} like these, where there are {units}."
    ))
}

/// Rounds a number up to two digits: it rests on an estimate.
pub fn rounded(count: u64) -> u64 {
    let mut unit = 1;
    while count / unit >= 100 {
        unit *= 10;
    }
    count.div_ceil(unit) * unit
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn estimates_have_two_digits() {
        assert_eq!([7, 99, 101, 1234, 99_999].map(rounded), [7, 99, 110, 1300, 100_000]);
    }
}
