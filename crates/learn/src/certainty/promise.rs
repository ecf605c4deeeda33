//! The number of groups from which a share of samples can be promised for a new group.

use crate::certainty::fitted::FittedOn;

/// Returns the fewest groups with which sets or intervals of a `share` of samples, 0..1, can be promised for a new group: a new one is
/// the worst of n + 1 in one of n + 1 cases.
///
/// # Reference
/// Lee, Barber and Willett 2023, hierarchical conformal prediction.
///
/// ```
/// assert_eq!([0.8, 0.9, 0.95, 0.99].map(taxel_learn::certainty::groups_needed), [4, 9, 19, 99]);
/// ```
pub fn groups_needed(share: f64) -> usize {
    // 0.9 / 0.1 is a little more than 9.
    (share / (1.0 - share) - 1e-6).ceil() as usize
}

impl FittedOn {
    /// Says that a `share` of samples cannot be promised for a new group, and how many groups that needs. None where there are
    /// enough, or none at all.
    pub fn unpromised(&self, share: f64) -> Option<String> {
        let (groups, needed) = (self.groups?, groups_needed(share));
        let noun = if groups == 1 { "group" } else { "groups" };
        (groups < needed).then(|| {
            format!(
                "with {groups} {noun} {:.0} % cannot be promised for a new one, which needs {needed} groups",
                100.0 * share
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::certainty::fitted::HeldOutParts;

    use super::*;

    #[test]
    fn few_groups_promise_nothing() {
        let of = |groups| FittedOn { samples: 90, groups, parts: HeldOutParts::Groups, digest: "d".into() };
        let words = of(Some(3)).unpromised(0.9).unwrap_or_default();
        assert_eq!(words, "with 3 groups 90 % cannot be promised for a new one, which needs 9 groups");
        assert!(of(Some(8)).unpromised(0.9).is_some() && of(Some(9)).unpromised(0.9).is_none());
        assert!(of(Some(9)).unpromised(0.95).is_some_and(|words| words.contains("needs 19")));
        assert_eq!(of(Some(4)).unpromised(0.8), None);
        assert_eq!(of(None).unpromised(0.99), None, "samples without groups");
    }
}
