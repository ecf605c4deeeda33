//! Networks over several data sets: who is better beyond one of them.

use super::p_value::shown;
use super::statistics::{friedman, holm, nemenyi, wilcoxon};
use crate::error::Result;
use crate::values::{Across, Contest, Judgement, MAJORITY, Primary};

/// Data sets below which ranks say too little (Demsar 2006 asks for more than five).
const LEAST: usize = 5;

/// Ranks the networks that all `judgements` share over their data sets; several runs on the same samples
/// count once, the first of them, and runs of another metric than the first not at all. Majority is left out: it
/// always loses, and would make any table significant. `None` with fewer than five data sets or three shared networks.
///
/// # Errors
/// An `alpha` outside (0, 1).
pub fn across(judgements: &[&Judgement], alpha: f64) -> Result<Option<Across>> {
    let mut sets: Vec<&Judgement> = vec![];
    let primary = judgements.first().map(|first| first.primary()).unwrap_or_default();
    let (alike, others): (Vec<&Judgement>, Vec<&Judgement>) =
        judgements.iter().partition(|judgement| judgement.primary() == primary);
    for judgement in &alike {
        if sets.iter().all(|known| known.results.data_digest != judgement.results.data_digest) {
            sets.push(judgement);
        }
    }
    let contest = |set: &&Judgement| {
        let networks = set.networks.iter().filter(|n| n.results.zoo != MAJORITY);
        let scores = networks.filter_map(|n| Some((n.results.network.clone(), n.score()?)));
        Contest { name: set.results.name.clone(), primary: set.primary(), scores: scores.collect() }
    };
    let mut across = rank(&sets.iter().map(contest).collect::<Vec<_>>(), alpha)?;
    let left_out = alike.len() - sets.len();
    if let Some(across) = across.as_mut().filter(|_| left_out > 0) {
        across.words.push(format!("{left_out} runs on samples that another run has were left out."));
    }
    if let Some(across) = across.as_mut().filter(|_| !others.is_empty()) {
        let (count, metric) = (others.len(), primary.head());
        across
            .words
            .push(format!("{count} runs that are scored by another metric than {metric} were left out."));
    }
    Ok(across)
}

/// Ranks the networks that all data sets of `sets` share. `None` with fewer than five data sets or three shared
/// networks, and where data sets are scored by different metrics.
///
/// # Errors
/// An `alpha` outside (0, 1).
pub fn rank(sets: &[Contest], alpha: f64) -> Result<Option<Across>> {
    let Some(first) = sets.first().filter(|_| sets.len() >= LEAST) else { return Ok(None) };
    let primary = &first.primary;
    if sets.iter().any(|set| set.primary != *primary) {
        return Ok(None);
    }
    let mut networks: Vec<String> = first
        .scores
        .iter()
        .map(|(name, _)| name.clone())
        .filter(|name| sets.iter().all(|set| set.of(name).is_some()))
        .collect();
    if networks.len() < 3 {
        return Ok(None);
    }
    let table = |names: &[String]| -> Vec<Vec<f64>> {
        sets.iter().map(|set| names.iter().filter_map(|name| set.of(name)).collect()).collect()
    };
    let ranks = friedman(&merits(primary, &table(&networks)))?.ranks;
    let mut order: Vec<usize> = (0..networks.len()).collect();
    order.sort_by(|&a, &b| ranks[a].total_cmp(&ranks[b]));
    networks = order.into_iter().map(|at| networks[at].clone()).collect();
    let scores = table(&networks);
    let test = friedman(&merits(primary, &scores))?;
    let against = |at: usize| wilcoxon(&scores.iter().map(|row| row[at] - row[0]).collect::<Vec<_>>());
    let p = (1..networks.len()).map(against).collect::<Result<Vec<_>>>()?;
    let p_holm = std::iter::once(None).chain(holm(&p).into_iter().map(Some)).collect();
    let mut across = Across {
        runs: sets.iter().map(|set| set.name.clone()).collect(),
        critical_difference: nemenyi(networks.len(), sets.len(), alpha)?,
        networks,
        primary: primary.clone(),
        scores,
        friedman: test,
        alpha,
        p_holm,
        words: vec![],
    };
    across.words = words(&across);
    Ok(Some(across))
}

/// Turns scores into numbers that are higher for the better.
fn merits(primary: &Primary, scores: &[Vec<f64>]) -> Vec<Vec<f64>> {
    scores.iter().map(|row| row.iter().map(|score| primary.merit(*score)).collect()).collect()
}

/// Returns the result in sentences.
fn words(across: &Across) -> Vec<String> {
    let (count, best) = (across.runs.len(), &across.networks[0]);
    let p = shown(across.friedman.p_iman_davenport);
    let mut words = vec![];
    if across.friedman.p_iman_davenport >= across.alpha {
        words.push(format!(
            "Over {count} data sets no network is better than another beyond chance (Friedman, Iman and \
             Davenport's p {p})."
        ));
    } else {
        let far =
            |at: &usize| across.friedman.ranks[*at] - across.friedman.ranks[0] >= across.critical_difference;
        let worse: Vec<&str> =
            (1..across.networks.len()).filter(far).map(|at| across.networks[at].as_str()).collect();
        let beaten = match worse.as_slice() {
            [] => "but no single one is worse than the best by the critical difference".into(),
            some => format!("{best} ranks better than {} beyond doubt", some.join(", ")),
        };
        words.push(format!("Over {count} data sets networks differ (p {p}); {beaten}."));
    }
    words
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::across;
    use crate::synthetic::{Setting, player, synthetic};
    use crate::values::{Across, Judgement};

    const GOOD: &[usize] = &[2, 3, 2, 2, 1];
    const FAIR: &[usize] = &[12, 13, 12, 12, 11];
    const POOR: &[usize] = &[32, 33, 32, 32, 31];
    const HALF: &[usize] = &[50; 5];

    fn judgements(count: usize) -> Vec<Judgement> {
        let one = |number: usize| {
            let players = vec![
                player("poor", 0.1, POOR),
                player("majority", 0.01, HALF),
                player("good", 1.0, GOOD),
                player("fair", 0.5, FAIR),
            ];
            let (_, mut judgement) = synthetic(&Setting::default(), players);
            judgement.results.name = format!("run{number}");
            judgement.results.data_digest = number.to_string();
            judgement
        };
        (0..count).map(one).collect()
    }

    fn of(judgements: &[Judgement]) -> Option<Across> {
        across(&judgements.iter().collect::<Vec<_>>(), 0.05).unwrap()
    }

    #[test]
    fn shared_networks_are_ranked_over_data_sets() {
        let across = of(&judgements(6)).unwrap();
        assert_eq!(across.networks, ["good", "fair", "poor"]);
        assert_eq!(across.friedman.ranks, [1.0, 2.0, 3.0]);
        assert_eq!(across.scores[0], [98.0, 88.0, 68.0]);
        // Six of six one way: 2 / 64, twice for two comparisons.
        assert_eq!(across.p_holm, [None, Some(0.0625), Some(0.0625)]);
        assert!((across.critical_difference - 1.353).abs() < 1e-3, "{}", across.critical_difference);
        assert!(across.words[0].contains("good ranks better than poor beyond doubt"), "{:?}", across.words);
    }

    #[test]
    fn too_few_or_the_same_data_sets_are_not_ranked() {
        assert_eq!(of(&judgements(4)), None);
        let mut same = judgements(6);
        same[5].results.data_digest = "0".into();
        let across = of(&same).unwrap();
        assert_eq!(across.runs.len(), 5);
        assert!(across.words[1].starts_with("1 runs on samples"), "{:?}", across.words);
        same[4].results.data_digest = "0".into();
        assert_eq!(of(&same), None);
        let mut missing = judgements(5);
        missing[3].networks.remove(3);
        assert_eq!(of(&missing), None, "two shared networks are no table");
    }
}
