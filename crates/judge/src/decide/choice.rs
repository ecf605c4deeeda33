//! The smallest network that suffices, on clean samples and under faults, with the evidence.

use taxel_learn::Problem;

use super::choice_words::{NOTABLE, choice_words, unseen};
use super::comparison::{Comparison, Effect};
use super::hardening::hardening;
use super::statistics::holm;
use crate::case::Case;
use crate::error::{Error, Result};
use crate::values::{
    COMMON_FAULTS, Choice, CostKind, Criteria, Evidence, Judged, Judgement, MAJORITY, Primary,
};

/// Chooses the smallest network of a run that suffices: of those that are not significantly worse than the most
/// accurate one, by the primary metric of the task, the cheapest, with the evidence. Baselines take part. Never chosen
/// are majority, which reads nothing, what diverged in training, what is no better than chance, and what seems to lose
/// more than [`Criteria::margin`], significantly or not. Of a learning curve only the rows with the most training
/// samples take part.
///
/// After a stress test what loses half of its margin above chance at severity 1 of a common fault is passed over for
/// the cheapest one that does not. Where all break, the cheapest is chosen, with the steadiest beside it. Of a network
/// and its fault-augmented twin that clean samples cannot tell apart, the twin is chosen.
///
/// # Errors
/// Criteria outside their range, or a limit on losses without a stress test.
///
/// ```no_run
/// use taxel_judge::{Case, Criteria, JudgeOptions, choose, judge};
/// use taxel_learn::RunFolder;
///
/// let dataset = taxel_data::load("presses.npz".as_ref(), &taxel_data::ReadOptions::default())?;
/// let case = Case::new(RunFolder::open("runs/presses".as_ref())?, dataset)?;
/// let judgement = judge(&case, &JudgeOptions::default())?;
/// let choice = choose(&case, &judgement, &Criteria::default())?;
/// println!("{}", choice.words.join("\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn choose(case: &Case, judgement: &Judgement, criteria: &Criteria) -> Result<Choice> {
    decide(&Comparison::of(case), judgement, &case.compared(), criteria)
}

/// Returns the same choice from records and a judgement alone.
pub(super) fn decide(
    comparison: &Comparison,
    judgement: &Judgement,
    compared: &[&str],
    criteria: &Criteria,
) -> Result<Choice> {
    let primary = judgement.primary();
    criteria.check(&primary)?;
    if let (Some(most), None) = (criteria.max_loss, &judgement.stress) {
        let reason = "needs a stress test, and there is none in the judgement; judge the run with one";
        return Err(Problem::new("max_loss", most, reason).into());
    }
    let takes_part = |n: &&Judged| compared.contains(&n.results.network.as_str());
    let rows: Vec<&Judged> = judgement.networks.iter().filter(takes_part).collect();
    let Some(best) = most_accurate(&primary, &rows, criteria.cost) else {
        let (folder, reason) = (judgement.results.name.clone(), "has no finished fold".into());
        return Err(Error::Run { folder, reason });
    };
    let mut evidence =
        rows.iter().map(|row| one(comparison, judgement, row, best, criteria)).collect::<Result<Vec<_>>>()?;
    correct(&primary, &mut evidence, criteria.alpha);
    let margin = criteria.margin_of(&primary, judgement.chance);
    for network in evidence.iter_mut().filter(|network| network.refused.is_none() && !network.worse) {
        let lost = primary.loss(network.difference);
        network.refused = (lost > margin)
            .then(|| format!("seems to lose {}, but the data cannot tell", primary.difference(lost)));
    }
    let best = best.results.network.clone();
    let picked = pick(comparison, judgement, criteria, &evidence)?;
    let enough_data =
        evidence.iter().all(|network| network.network == best || !unseen(&primary, network, margin));
    let mut choice = Choice {
        criteria: Criteria { margin: Some(margin), ..criteria.clone() },
        primary,
        test: comparison.test(),
        best,
        chosen: picked.chosen,
        passed_over: picked.passed_over,
        steadier: picked.steadier,
        enough_data,
        evidence,
        words: vec![],
    };
    choice.words = choice_words(&choice, judgement, &hardening(judgement)?);
    let room = criteria.room.as_ref().zip(choice.chosen.as_deref());
    if let Some(words) = room.and_then(|(room, chosen)| room.words(chosen)) {
        choice.words.insert(1, words);
    }
    Ok(choice)
}

/// Returns the most accurate row; of equals the cheaper, and one whose training diverged only where all did.
fn most_accurate<'a>(primary: &Primary, rows: &[&'a Judged], by: CostKind) -> Option<&'a Judged> {
    let cost = |row: &Judged| cost(row, by).unwrap_or(f64::INFINITY);
    let sound = |row: &Judged| row.results.diverged == 0;
    let scored = rows.iter().copied().filter(|row| row.score().is_some());
    scored.max_by(|a, b| {
        let accurate = primary.order(score(a), score(b)).then(cost(b).total_cmp(&cost(a)));
        sound(a).cmp(&sound(b)).then(accurate)
    })
}

/// Returns one row beside the best, before its p is corrected.
fn one(
    comparison: &Comparison,
    judgement: &Judgement,
    row: &Judged,
    best: &Judged,
    criteria: &Criteria,
) -> Result<Evidence> {
    let (name, best_name) = (&row.results.network, &best.results.network);
    let tested = if name == best_name { None } else { comparison.tested(name, best_name, None)? };
    let effect = match tested {
        None if name == best_name => Some(Effect { size: 0.0, interval: None, p: None, error: None }),
        tested => tested.map(|(effect, _)| effect),
    };
    let mean_loss = judgement.stress.as_ref().and_then(|stress| stress.mean_loss(name));
    Ok(Evidence {
        network: name.clone(),
        score: score(row),
        difference: effect.map_or(score(row) - score(best), |e| e.size),
        interval: effect.and_then(|e| e.interval),
        p: effect.and_then(|e| e.p),
        test: tested.map(|(_, test)| test),
        p_holm: None,
        worse: false,
        cost: cost(judgement.clean_twin(row).unwrap_or(row), criteria.cost),
        mean_loss,
        breaks_at_1: breaks_at_1(judgement, name),
        refused: match effect {
            None => Some(format!("has no finished fold in common with {best_name}")),
            Some(_) => refusal(row, judgement, mean_loss, criteria),
        },
    })
}

fn score(row: &Judged) -> f64 {
    row.score().unwrap_or(0.0)
}

/// Returns the cost that is to be small.
fn cost(row: &Judged, by: CostKind) -> Option<f64> {
    match by {
        CostKind::Latency => row.speed.map(|speed| speed.whole.p50_ms),
        CostKind::Size => Some(row.results.costs.bytes as f64),
        CostKind::Macs => Some(row.results.costs.macs as f64),
    }
}

/// Says why a network cannot be chosen, however accurate it is.
fn refusal(
    row: &Judged,
    judgement: &Judgement,
    mean_loss: Option<f64>,
    criteria: &Criteria,
) -> Option<String> {
    let primary = judgement.primary();
    if row.results.zoo == MAJORITY {
        return Some("reads nothing: is here to be beaten".into());
    }
    if row.results.diverged > 0 {
        return Some(format!("diverged in training ({})", row.results.diverged_folds()));
    }
    // To rounding: scores are means over folds.
    if primary.worsening(judgement.chance, score(row)) <= primary.share(1e-9, judgement.chance) {
        return Some(format!("is no better than {}", primary.knowing_nothing()));
    }
    if cost(row, criteria.cost).is_none() {
        return Some("was not timed: its speed is not known".into());
    }
    if let Some(reason) = criteria.room.as_ref().and_then(|room| room.refusal(&row.results.network)) {
        return Some(reason);
    }
    match (criteria.max_loss, mean_loss) {
        (Some(most), Some(loss)) if loss > most => {
            let loss = primary.difference(loss);
            Some(format!("loses {loss} to faults on average, more than {most}"))
        }
        (Some(_), None) => Some("was not tested under faults".into()),
        _ => None,
    }
}

/// Corrects all p-values by Holm's method and marks the rows that are worse beyond doubt.
fn correct(primary: &Primary, evidence: &mut [Evidence], alpha: f64) {
    let p: Vec<f64> = evidence.iter().filter_map(|network| network.p).collect();
    let tested = evidence.iter_mut().filter(|network| network.p.is_some());
    for (network, corrected) in tested.zip(holm(&p)) {
        network.p_holm = Some(corrected);
        network.worse = corrected < alpha && primary.loss(network.difference) > 0.0;
    }
}

/// Returns the common faults that take half of the margin of a row at severity 1.
fn breaks_at_1(judgement: &Judgement, name: &str) -> Vec<taxel_faults::Fault> {
    let networks = judgement.stress.iter().flat_map(|stress| &stress.networks);
    let curves = networks.filter(|tested| tested.network == name).flat_map(|tested| &tested.curves);
    let breaks = curves.filter(|curve| curve.breaks_at == Some(1)).map(|curve| curve.fault);
    breaks.filter(|fault| COMMON_FAULTS.contains(fault)).collect()
}

/// The chosen one, and those that are named beside it.
#[derive(Default)]
struct Picked {
    chosen: Option<String>,
    passed_over: Option<String>,
    steadier: Option<String>,
}

/// Picks the cheapest that suffices, on clean samples and under faults.
fn pick(
    comparison: &Comparison,
    judgement: &Judgement,
    criteria: &Criteria,
    evidence: &[Evidence],
) -> Result<Picked> {
    let primary = judgement.primary();
    let candidates: Vec<&Evidence> =
        evidence.iter().filter(|network| network.refused.is_none() && !network.worse).collect();
    let Some(clean) = cheapest(&primary, candidates.iter().copied()) else { return Ok(Picked::default()) };
    let named = |network: &Evidence| Some(network.network.clone());
    if criteria.clean_only {
        return Ok(Picked { chosen: named(clean), ..Picked::default() });
    }
    let twin = |of| augmented_twin(comparison, judgement, criteria.alpha, of, &candidates);
    let first = twin(clean)?;
    if first.breaks_at_1.is_empty() {
        return Ok(Picked { chosen: named(first), ..Picked::default() });
    }
    let steady = candidates.iter().copied().filter(|network| network.breaks_at_1.is_empty());
    if let Some(network) = cheapest(&primary, steady) {
        return Ok(Picked { chosen: named(twin(network)?), passed_over: named(clean), steadier: None });
    }
    let notable = primary.share(NOTABLE, judgement.chance);
    let loss = |network: &Evidence| network.mean_loss.unwrap_or(f64::INFINITY);
    let steadiest = candidates.iter().copied().min_by(|a, b| loss(a).total_cmp(&loss(b)));
    let steadier = steadiest.filter(|network| loss(network) + notable < loss(first)).and_then(named);
    Ok(Picked { chosen: named(first), passed_over: None, steadier })
}

/// Returns the fault-augmented twin of a candidate, if it is one too, clean samples cannot tell the two apart and no
/// stress test speaks against it; else the candidate.
fn augmented_twin<'a>(
    comparison: &Comparison,
    judgement: &Judgement,
    alpha: f64,
    of: &'a Evidence,
    candidates: &[&'a Evidence],
) -> Result<&'a Evidence> {
    let primary = judgement.primary();
    for twin in candidates {
        let row = judgement.network(&twin.network);
        if row
            .and_then(|row| judgement.clean_twin(row))
            .is_none_or(|clean| clean.results.network != of.network)
            || twin.mean_loss.zip(of.mean_loss).is_some_and(|(twin, clean)| twin > clean)
        {
            continue;
        }
        let difference = comparison.difference(&twin.network, &of.network, None)?;
        let is_worse = |e: &Effect| primary.loss(e.size) > 0.0 && e.p.is_some_and(|p| p < alpha);
        if difference.is_some_and(|effect| !is_worse(&effect)) {
            return Ok(twin);
        }
    }
    Ok(of)
}

/// Returns the cheapest of the candidates; of equals the more accurate.
fn cheapest<'a>(primary: &Primary, candidates: impl Iterator<Item = &'a Evidence>) -> Option<&'a Evidence> {
    candidates.min_by(|a, b| {
        let cost = |network: &Evidence| network.cost.unwrap_or(f64::INFINITY);
        cost(a).total_cmp(&cost(b)).then(primary.order(b.score, a.score))
    })
}
