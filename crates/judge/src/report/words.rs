//! Sentences that tables, charts and page share.

use taxel_data::{Padding, SourceKind};
use taxel_learn::NetworkResults;
use taxel_learn::metrics::FEW_GROUPS;

use crate::values::{Early, Judged, Judgement, Stress};

/// Returns the kind in words: `simulated` or `real`.
pub(super) fn kind(kind: SourceKind) -> &'static str {
    match kind {
        SourceKind::Simulated => "simulated",
        SourceKind::Real => "real",
    }
}

/// Checks whether a network stands in the first table: all but the smaller rows of a learning curve.
pub(super) fn is_shown(judgement: &Judgement, network: &Judged) -> bool {
    let most = judgement.networks.iter().filter_map(|n| n.results.per_class).max();
    network.results.per_class == most
}

/// Returns the network that a row of a learning curve belongs to.
pub(super) fn few_samples_of(row: &NetworkResults) -> &str {
    let ending = row.per_class.map(|count| format!(".n{count}"));
    ending.and_then(|ending| row.network.strip_suffix(&ending)).unwrap_or(&row.network)
}

/// Says how often each network was timed: `1000`, or `37 to 1000`.
pub(super) fn runs(judgement: &Judgement) -> String {
    let runs = judgement.networks.iter().filter_map(|n| n.speed).map(|s| s.whole.runs);
    match (runs.clone().min(), runs.max()) {
        (Some(least), Some(most)) if least < most => format!("{least} to {most}"),
        (_, most) => most.unwrap_or(0).to_string(),
    }
}

/// Says how many samples, in which range.
pub(super) fn stress_basis(stress: &Stress) -> String {
    let Stress { samples, of, range, chance, primary, .. } = stress;
    let part = if samples < of { format!("{samples} of {of}") } else { samples.to_string() };
    let whose = if range.from_samples { "of the samples; no full scale is known" } else { "of the sensor" };
    let chance = format!("{} {}", primary.chance(), primary.value(*chance));
    format!("{part} test samples, full scale {} to {} ({whose}), {chance}", range.low, range.high)
}

/// Says how often guards replace anything in samples that nobody broke.
pub(super) fn alarms(stress: &Stress) -> String {
    match stress.alarms {
        None => "no guard was tried".into(),
        Some(found) => format!(
            "in unbroken test samples guards replaced something in {} of {} ({:.1} %), {} of {} channels or taxels each \
             on average",
            found.alarmed,
            found.samples,
            100.0 * found.alarmed as f64 / found.samples.max(1) as f64,
            taxel_report::numbers::tenth(found.replaced as f64 / found.alarmed.max(1) as f64),
            found.elements
        ),
    }
}

/// Says how many samples, and what their starts are filled up with.
pub(super) fn early_basis(early: &Early) -> String {
    let Early { samples, of, ticks, padding, .. } = early;
    let part = if samples < of { format!("{samples} of {of}") } else { samples.to_string() };
    let filled = match padding {
        Padding::Zero => "zeros",
        Padding::Edge => "their last reading",
    };
    format!("the starts of {part} test samples of {ticks} readings, filled up with {filled}")
}

/// Says what the intervals of scores are made of.
pub(super) fn interval_words(judgement: &Judgement) -> String {
    let is_percent = judgement.primary().is_percent();
    match judgement.networks.iter().filter_map(|n| n.results.interval_groups).max() {
        Some(groups) => {
            let few = if groups < FEW_GROUPS { " (too few groups)" } else { "" };
            let kind = if is_percent { "Wilson's" } else { "a t interval of the logarithm" };
            format!("95 %, {kind} on as many samples as {groups} groups are worth{few}")
        }
        None if is_percent => "95 %, Wilson's over samples".into(),
        None => "95 %, a t interval of the logarithm over samples".into(),
    }
}

/// Says that there are too few groups, where there are.
pub(super) fn few_groups(judgement: &Judgement) -> Option<String> {
    let groups = judgement.networks.iter().filter_map(|n| n.results.interval_groups).max()?;
    (groups < FEW_GROUPS).then(|| format!("too few groups ({groups}) for a sure interval"))
}
