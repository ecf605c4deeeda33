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
    use super::{across, rank};
    use crate::synthetic::{Setting, player, synthetic};
    use crate::values::{Across, Contest, Judgement, Primary};
    use taxel_data::{Quantity, Task};

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

    fn force() -> Task {
        Task::Values(vec![Quantity { name: "force".into(), unit: Some("N".into()) }])
    }

    /// Makes contests of `a`, `b` and `c`, a row of scores for each data set.
    fn contests(primary: &Primary, rows: &[[f64; 3]]) -> Vec<Contest> {
        let of = |(number, row): (usize, &[f64; 3])| Contest {
            name: number.to_string(),
            primary: primary.clone(),
            scores: ["a", "b", "c"].map(String::from).into_iter().zip(*row).collect(),
        };
        rows.iter().enumerate().map(of).collect()
    }

    #[test]
    fn the_words_say_how_sure_the_ranks_are() {
        let says = |rows: &[[f64; 3]]| {
            rank(&contests(&Primary::default(), rows), 0.05).unwrap().unwrap().words.remove(0)
        };
        let turns = [[3.0, 2.0, 1.0], [1.0, 3.0, 2.0], [2.0, 1.0, 3.0]];
        assert!(says(&[turns, turns].concat()).starts_with("Over 6 data sets no network is better"));
        // Mean ranks 1.2, 2.2 and 2.6: Friedman's statistic 5.2, F 4.333 of 2 and 8, p (1 + 2 · 4.333 / 8)^-4 = 0.053.
        let five = [[3.0, 2.0, 1.0], [3.0, 2.0, 1.0], [3.0, 1.0, 2.0], [3.0, 1.0, 2.0], [2.0, 3.0, 1.0]];
        assert!(says(&five).contains("no network is better"), "{}", says(&five));
        // Mean ranks 1.17, 2.33 and 2.5, p 0.02: the critical difference is 1.353.
        let rows = [
            [3.0, 2.0, 1.0],
            [3.0, 2.0, 1.0],
            [3.0, 1.0, 2.0],
            [3.0, 1.0, 2.0],
            [3.0, 1.0, 2.0],
            [2.0, 3.0, 1.0],
        ];
        let close = says(&rows);
        assert!(close.contains("networks differ") && close.contains("but no single one is worse"), "{close}");
    }

    #[test]
    fn each_network_is_tested_against_the_best() {
        let rows = [7.0, 6.0, 5.0, 4.0, 10.5, 11.0].map(|second| [10.0, second, 0.0]);
        let across = rank(&contests(&Primary::default(), &rows), 0.05).unwrap().unwrap();
        // Signed ranks of 0.5 and 1 against four larger ones: 5 of 64 patterns go as far one way. The third is always last.
        assert_eq!(across.p_holm, [None, Some(0.15625), Some(0.0625)]);
    }

    #[test]
    fn of_errors_the_lowest_ranks_first() {
        let rows: Vec<[f64; 3]> =
            (0..6).map(|set| [3.0, 1.0, 2.0].map(|error| error + f64::from(set))).collect();
        let across = rank(&contests(&Primary::of(&force()), &rows), 0.05).unwrap().unwrap();
        assert_eq!(
            (across.networks, across.friedman.ranks),
            (vec!["b".into(), "c".into(), "a".into()], vec![1.0, 2.0, 3.0])
        );
        assert_eq!(across.scores[0], [1.0, 2.0, 3.0]);
        let mut mixed = contests(&Primary::default(), &rows);
        mixed[5].primary = Primary::of(&force());
        assert_eq!(rank(&mixed, 0.05).unwrap(), None, "errors and accuracies have no common rank");
    }

    #[test]
    fn runs_of_another_metric_are_left_out() {
        let mut all = judgements(7);
        all[5].results.task = force();
        all[6].results.task = force();
        let across = of(&all).unwrap();
        assert_eq!((across.runs.len(), across.words.len()), (5, 2), "{:?}", across.words);
        assert!(
            across.words[1].starts_with("2 runs that are scored by another metric"),
            "{:?}",
            across.words
        );
    }
}
