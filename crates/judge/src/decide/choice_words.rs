//! A choice in sentences.

use taxel_learn::metrics::FEW_GROUPS;
use taxel_report::numbers;

use super::deciding::deciding;
use super::p_value::shown;
use crate::values::{Choice, Evidence, Hardened, Judged, Judgement, MAJORITY, Primary, Stress, Test};

/// Percentage points of mean loss under faults that are worth a word; of values as [`Primary::share`] says.
pub(super) const NOTABLE: f64 = 2.0;

/// Says which network is chosen, how much worse than the best and how much cheaper it is, how it stands faults, and which
/// doubts remain.
pub(super) fn choice_words(choice: &Choice, judgement: &Judgement, hardening: &[Hardened]) -> Vec<String> {
    let evidence_of = |name: &str| choice.evidence.iter().find(|evidence| evidence.network == name);
    let mut words = vec![];
    let Some(chosen) = choice.chosen.as_deref().and_then(evidence_of) else {
        words.push(format!("Nothing suffices: {}.", refusals(choice)));
        words.extend(doubts(choice, judgement, None));
        words.extend(leaks(judgement));
        return words;
    };
    #[expect(clippy::expect_used, reason = "the best is one of the rows")]
    let best = evidence_of(&choice.best).expect("the best has evidence");
    words.push(if chosen.network == best.network {
        is_best(choice, chosen)
    } else {
        suffices(choice, chosen, best)
    });
    if let (Some(small), Some(large)) = (judgement.network(&chosen.network), judgement.network(&best.network))
    {
        if chosen.network != best.network {
            words.extend(saves(small, large));
        }
        if small.baseline {
            words.push(format!(
                "{} is a baseline and no network: no network of this table earns its cost on these data.",
                chosen.network
            ));
        }
    }
    words.extend(faults(chosen, best, judgement));
    words.extend(
        choice
            .passed_over
            .as_deref()
            .and_then(evidence_of)
            .and_then(|cheap| passed_over(choice, cheap, chosen, judgement.stress.as_ref()?)),
    );
    let steadier = choice.steadier.as_deref().and_then(evidence_of);
    words.extend(judgement.stress.as_ref().and_then(|stress| breaks(choice, chosen, steadier, stress)));
    words.extend(hardened(&choice.primary, chosen, hardening).or_else(|| twin(chosen, judgement)));
    words.extend(doubts(choice, judgement, Some(chosen)));
    words.extend(leaks(judgement));
    words
}

/// Says what makes the scores doubtful that the choice rests on.
fn leaks(judgement: &Judgement) -> impl Iterator<Item = String> + '_ {
    judgement.results.leaks.iter().map(|leak| format!("Mind: {leak}."))
}

/// Checks whether a loss larger than `margin` could have stayed unseen, or is seen and not sure. Majority counts:
/// data that cannot tell it from the best tell nothing.
pub(super) fn unseen(primary: &Primary, evidence: &Evidence, margin: f64) -> bool {
    let counts = evidence.refused.is_none()
        || evidence.network == MAJORITY
        || primary.loss(evidence.difference) > margin;
    counts && !evidence.worse && evidence.interval.is_none_or(|bounds| primary.losses(bounds)[1] > margin)
}

fn is_best(choice: &Choice, chosen: &Evidence) -> String {
    let primary = &choice.primary;
    let others = choice.evidence.iter().filter(|evidence| evidence.network != chosen.network);
    let cheaper: Vec<String> = others
        .filter(|evidence| evidence.network != MAJORITY && evidence.cost < chosen.cost)
        .map(|evidence| match (&evidence.refused, evidence.p_holm) {
            (Some(reason), _) => format!("{} {reason}", evidence.network),
            _ if !evidence.worse => format!("{} does not stand faults", evidence.network),
            (_, Some(p)) => {
                let by = primary.with_points(&primary.show_signed()(evidence.difference));
                format!("{} ({by}, p {})", evidence.network, shown(p))
            }
            _ => evidence.network.clone(),
        })
        .collect();
    let beyond = match cheaper.as_slice() {
        [] => "nothing in the table that beats chance is cheaper".into(),
        some => format!("cheaper ones do not suffice: {}", some.join("; ")),
    };
    let score = primary.named_value(chosen.score);
    format!("{} suffices, and is the most accurate ({score}): {beyond}.", chosen.network)
}

fn suffices(choice: &Choice, chosen: &Evidence, best: &Evidence) -> String {
    let primary = &choice.primary;
    let by = test(chosen.test.unwrap_or(choice.test));
    let p = chosen.p_holm.map_or(String::new(), |p| format!(" ({by}, p {})", shown(p)));
    let (lost, title) = (primary.loss(chosen.difference), primary.title());
    let gives_up = match (lost > 0.0, primary.is_percent()) {
        (true, true) => format!("gives up {} of {title}", points(primary, lost)),
        (true, false) => format!("gives up {} ({title})", points(primary, lost)),
        (false, true) => format!("gives up no {title}"),
        (false, false) => format!("gives up nothing ({title})"),
    };
    let suffices = if unseen(primary, chosen, choice.margin()) {
        "would suffice, but the data are too few to tell"
    } else {
        "suffices"
    };
    format!(
        "{} {suffices}: {}, it {gives_up} against {}, the most accurate ({}); the two cannot be told apart{p}.",
        chosen.network,
        primary.named_value(chosen.score) + if primary.is_percent() { " right" } else { "" },
        best.network,
        primary.named_value(best.score)
    )
}

fn test(test: Test) -> &'static str {
    match test {
        Test::NadeauBengio => "corrected resampled t-test with Holm's correction",
        Test::FreshWorlds => "paired t-test over worlds with Holm's correction",
        Test::McNemar => "McNemar's exact test with Holm's correction",
        Test::GroupedPairs => "test of grouped pairs with Holm's correction",
        Test::Wilcoxon => "Wilcoxon's signed-rank test with Holm's correction",
    }
}

/// Says how much faster and smaller one network is than another.
fn saves(small: &Judged, large: &Judged) -> Option<String> {
    let times = |one: f64, other: f64, more: &str, less: &str| {
        let ratio = other / one;
        match ratio {
            r if !r.is_finite() || (0.95..=1.05).contains(&r) => None,
            r if r > 1.0 => Some(format!("{} times {more}", rounded(r))),
            r => Some(format!("{} times {less}", rounded(1.0 / r))),
        }
    };
    let (one, other) = (small.results.costs, large.results.costs);
    let mut parts = vec![];
    if let (Some(one), Some(other)) = (small.speed, large.speed) {
        parts.extend(times(one.whole.p50_ms, other.whole.p50_ms, "faster", "slower").map(|t| {
            format!("{t} ({} against {} ms)", digits(one.whole.p50_ms), digits(other.whole.p50_ms))
        }));
    }
    parts.extend(
        times(one.bytes as f64, other.bytes as f64, "smaller", "larger")
            .map(|t| format!("{t} ({} against {} kB)", kilobytes(one.bytes), kilobytes(other.bytes))),
    );
    let macs = times(one.macs as f64, other.macs as f64, "fewer", "more")
        .map(|t| format!("needs {t} multiply-accumulates"));
    let is = (!parts.is_empty()).then(|| format!("is {}", listed(&parts)));
    let all: Vec<String> = is.into_iter().chain(macs).collect();
    (!all.is_empty()).then(|| format!("It {}.", all.join(", and ")))
}

/// Says whether faults speak against the chosen network.
fn faults(chosen: &Evidence, best: &Evidence, judgement: &Judgement) -> Option<String> {
    let stress = judgement.stress.as_ref()?;
    let loss = chosen.mean_loss?;
    let verdict = stress.networks.iter().find(|n| n.network == chosen.network).map(|n| n.verdict.as_str());
    let primary = judgement.primary();
    let notable = primary.share(NOTABLE, judgement.chance);
    let cost = points(&primary, loss);
    let against = match best.mean_loss.filter(|_| best.network != chosen.network) {
        Some(other) => {
            let speak = if loss > other + notable { "speak" } else { "do not speak" };
            let other = number(&primary, other);
            format!("Faults {speak} against it: they cost it {cost} on average, {} {other}", best.network)
        }
        None => format!("Faults cost it {cost} on average"),
    };
    Some(match verdict {
        Some(verdict) if !verdict.is_empty() => {
            format!("{against}. {}: {}.", chosen.network, verdict.trim_end_matches('.'))
        }
        _ => format!("{against}."),
    })
}

/// Returns the names of the common faults that break a network at severity 1, with their levels: `noise (1 % of full scale)`.
fn broken_by(evidence: &Evidence, stress: &Stress) -> String {
    let named = |fault: &taxel_faults::Fault| match stress.faults.iter().find(|info| info.fault == *fault) {
        Some(info) => format!("{fault} ({} {})", info.level(1), info.unit),
        None => fault.to_string(),
    };
    listed(&evidence.breaks_at_1.iter().map(named).collect::<Vec<_>>())
}

/// Says why a cheaper network was not chosen, with the figures of both.
fn passed_over(choice: &Choice, cheap: &Evidence, chosen: &Evidence, stress: &Stress) -> Option<String> {
    let primary = &choice.primary;
    let [cheap_loss, loss] = [cheap.mean_loss?, chosen.mean_loss?].map(|loss| number(primary, loss));
    Some(format!(
        "{} is cheaper and suffices on clean samples ({}), but loses half of its margin at severity 1 of {}. Faults cost \
         it {} on average, {} {loss}.",
        cheap.network,
        primary.named_value(cheap.score),
        broken_by(cheap, stress),
        primary.with_points(&cheap_loss),
        chosen.network,
    ))
}

/// Says that a common fault breaks the chosen network early, and which one stands it better.
fn breaks(
    choice: &Choice,
    chosen: &Evidence,
    steadier: Option<&Evidence>,
    stress: &Stress,
) -> Option<String> {
    if chosen.breaks_at_1.is_empty() {
        return None;
    }
    let primary = &choice.primary;
    let by = broken_by(chosen, stress);
    let beside = match steadier.and_then(|other| Some((other, other.mean_loss?, chosen.mean_loss?))) {
        Some((other, loss, own)) => format!(
            "Steadier: {} ({} on clean samples) loses {} to faults on average, {} {}",
            other.network,
            primary.named_value(other.score),
            points(primary, loss),
            chosen.network,
            number(primary, own)
        ),
        None if choice.criteria.clean_only => "Faults did not weigh in this choice".into(),
        None => "Nothing that suffices is steadier".into(),
    };
    Some(format!("Mind: it loses half of its margin at severity 1 of {by}. {beside}."))
}

/// Says how training under faults changes the loss, for the chosen network.
fn hardened(primary: &Primary, chosen: &Evidence, hardening: &[Hardened]) -> Option<String> {
    let found = hardening.iter().find(|found| [&found.network, &found.clean].contains(&&chosen.network))?;
    let [before, after] = found.loss;
    let (change, signed) = (found.score_change, primary.show_signed());
    let costs = if primary.loss(change.mean) > 0.0 { "costs" } else { "gains" };
    let interval = change.interval.map_or("one fold: no interval".into(), |[low, high]| {
        format!("95 % interval of the difference {} to {}", signed(low), signed(high))
    });
    let by = points(primary, change.mean.abs());
    let clean = format!("{costs} {by} on unbroken samples ({interval})");
    Some(if chosen.network == found.network {
        format!(
            "It was trained under faults, which cost it {} on average and {} without that training; the training \
             {clean}.",
            points(primary, after),
            number(primary, before)
        )
    } else {
        format!(
            "Trained under faults ({}) it loses {} to them on average instead of {}; that {clean}.",
            found.network,
            points(primary, after),
            number(primary, before)
        )
    })
}

/// Says that the chosen network is fault-augmented, where no faults were tried on it.
fn twin(chosen: &Evidence, judgement: &Judgement) -> Option<String> {
    let clean = judgement.clean_twin(judgement.network(&chosen.network)?)?;
    let (name, clean) = (&chosen.network, &clean.results.network);
    Some(format!("{name} was trained under faults; {clean} is the same trained on clean samples."))
}

/// Returns the doubts that remain.
fn doubts(choice: &Choice, judgement: &Judgement, chosen: Option<&Evidence>) -> Vec<String> {
    let (primary, margin, mut words) = (&choice.primary, choice.margin(), vec![]);
    if let Some(chosen) = chosen.filter(|network| network.network != choice.best) {
        words.push(match chosen.interval.map(|bounds| primary.losses(bounds)[1]) {
            Some(most) if most > 0.0 => format!(
                "The data could not have excluded that {} is up to {} less accurate than {} (95 % interval).",
                chosen.network,
                primary.difference(most),
                choice.best
            ),
            Some(_) => format!("With 95 % confidence {} is no less accurate.", chosen.network),
            None => format!("How much less accurate {} may be, these data do not say.", chosen.network),
        });
    }
    let is_open = |evidence: &&Evidence| evidence.network != choice.best && unseen(primary, evidence, margin);
    let open: Vec<&Evidence> = choice.evidence.iter().filter(is_open).collect();
    let hidden: Vec<String> = open
        .iter()
        .map(|evidence| match evidence.interval {
            Some(bounds) => {
                format!("{} (up to {})", evidence.network, primary.show()(primary.losses(bounds)[1]))
            }
            None => format!("{} (no interval)", evidence.network),
        })
        .collect();
    if !choice.enough_data {
        words.push(format!(
            "Too few data: a loss of more than {} could have stayed unseen for {}. More samples, folds or \
             repetitions would tell.",
            primary.margin(margin),
            listed(&hidden)
        ));
        words.extend(deciding(choice, judgement, &open));
    }
    let majority = choice.evidence.iter().find(|evidence| evidence.network == MAJORITY && !evidence.worse);
    if majority.is_some_and(|evidence| evidence.network != choice.best) {
        words.push("Not even majority, which reads nothing, can be told from the best.".into());
    } else if choice.best == MAJORITY {
        words.push("Majority, which reads nothing, is the most accurate: nothing has been learned.".into());
    }
    words.extend(circumstances(judgement));
    words
}

/// Returns the circumstances that limit the numbers.
fn circumstances(judgement: &Judgement) -> Vec<String> {
    let mut words = vec![];
    if judgement.stress.is_none() {
        words.push(
            "Not tested under faults: run taxel stress; after taxel report they weigh in the choice.".into(),
        );
    }
    let groups = judgement.networks.iter().filter_map(|n| n.results.interval_groups).max();
    if let Some(groups) = groups.filter(|groups| *groups < FEW_GROUPS) {
        words.push(format!("Too few groups ({groups}): intervals rest on what is usual within groups."));
    }
    if let Some(most) = judgement.networks.iter().filter_map(|n| n.results.per_class).max() {
        let stratum = judgement.primary().stratum();
        words.push(format!("Only the rows with the most training samples per {stratum} ({most}) took part."));
    }
    if judgement.results.task.attributes().len() > 1 {
        let names: Vec<String> = judgement.results.task.attributes().iter().map(|a| a.name.clone()).collect();
        words.push(format!("Accuracy is the mean over {}.", listed(&names)));
    }
    if judgement.results.task.quantities().len() > 1 {
        let title = judgement.primary().heading();
        words.push(format!("{title} is the mean over {}.", listed(&judgement.results.task.output_names())));
    }
    if judgement.unfinished() > 0 {
        words.push("Some folds are not finished: resume the run.".into());
    }
    if !judgement.judged_on.optimised {
        words.push("Speeds are those of a build that is not optimised.".into());
    }
    if judgement.results.source.is_simulated() {
        words.push("Measured on simulated data: recordings may rank networks otherwise.".into());
    }
    words
}

/// Says why none of those that are accurate enough can be chosen.
fn refusals(choice: &Choice) -> String {
    let reasons: Vec<String> = choice
        .evidence
        .iter()
        .filter(|evidence| !evidence.worse)
        .filter_map(|evidence| Some(format!("{} {}", evidence.network, evidence.refused.as_ref()?)))
        .collect();
    match reasons.as_slice() {
        [] => "no network is accurate enough".into(),
        some => some.join("; "),
    }
}

/// Joins parts as `a, b and c`.
fn listed(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

/// Returns a loss without its unit and without the minus of a rounded zero.
fn number(primary: &Primary, value: f64) -> String {
    if primary.is_percent() {
        format!("{:.1}", (10.0 * value).round() / 10.0 + 0.0)
    } else {
        numbers::digits(value)
    }
}

/// Returns the same with its unit: `3.1 points`.
fn points(primary: &Primary, value: f64) -> String {
    primary.with_points(&number(primary, value))
}

fn rounded(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.1}") } else { format!("{ratio:.0}") }
}

/// Returns milliseconds with two significant digits of small numbers.
fn digits(ms: f64) -> String {
    match ms {
        v if v < 0.01 => format!("{v:.4}"),
        v if v < 1.0 => format!("{v:.3}"),
        v if v < 10.0 => format!("{v:.2}"),
        v => format!("{v:.1}"),
    }
}

fn kilobytes(bytes: u64) -> String {
    let kb = bytes as f64 / 1e3;
    if kb < 10.0 { format!("{kb:.1}") } else { format!("{kb:.0}") }
}
