//! What the numbers of a stress test say, in words.

use taxel_scenes::faults::Fault;
use taxel_trainer::Transform;

use super::{FaultCurve, MARGIN, NetworkStress};

/// Percentage points below which a loss is not worth a word.
const SMALL: f64 = 2.0;

/// What breaks a network first, what it stands, and why, where its inputs explain it.
pub(super) fn verdict(network: &NetworkStress, chance: f64, inputs: &[Transform]) -> String {
    if network.clean.accuracy - chance <= MARGIN {
        return "no better than always naming the commonest class; there is nothing to break".into();
    }
    let mut broken: Vec<&FaultCurve> = network.curves.iter().filter(|c| c.breaks_at.is_some()).collect();
    let loss = |curve: &FaultCurve| curve.loss(network.clean);
    broken.sort_by(|a, b| a.breaks_at.cmp(&b.breaks_at).then(loss(b).total_cmp(&loss(a))));
    let mut words = match broken.first() {
        None => "keeps half of its margin above chance under every fault that was tried".to_string(),
        Some(first) => {
            let at = first.breaks_at.unwrap_or_default();
            let level = first.fault.level(at).unwrap_or_default();
            format!("breaks first under {} (severity {at}: {level} {})", first.fault, first.fault.unit())
        }
    };
    if broken.len() > 1 {
        let rest: Vec<String> = broken[1..]
            .iter()
            .map(|c| format!("{} ({})", c.fault, c.breaks_at.unwrap_or_default()))
            .collect();
        words += &format!(", then {}", rest.join(", "));
    }
    let held: Vec<&str> = network.curves.iter().filter(|c| loss(c) < SMALL).map(|c| c.fault.name()).collect();
    if !held.is_empty() {
        words += &format!("; hardly notices {}", held.join(", "));
    }
    let reasons: Vec<String> = network
        .curves
        .iter()
        .filter_map(|c| reason(c.fault, c.breaks_at.is_some(), loss(c) < SMALL, inputs))
        .collect();
    if !reasons.is_empty() {
        words += &format!(". {}", reasons.join(". "));
    }
    words
}

/// What the inputs of a network explain, if the numbers show it.
fn reason(fault: Fault, breaks: bool, held: bool, inputs: &[Transform]) -> Option<String> {
    let blind = |input: &Transform| input.is_blind_to_amplitude();
    let (all, any) = (!inputs.is_empty() && inputs.iter().all(blind), inputs.iter().any(blind));
    match fault {
        Fault::Gain if held && all => Some(
            "Gain: an image scaled per sample cannot see amplitude, so a change of it does little".into(),
        ),
        Fault::Gain if held && any => Some(
            "Gain: the image scaled per sample cannot see amplitude; the other branch can, and is outvoted"
                .into(),
        ),
        Fault::Gain if breaks && any && !all => Some(
            "Gain: the image scaled per sample cannot see amplitude; the branch that can takes it down"
                .into(),
        ),
        Fault::Gain if breaks && all => Some(
            "Gain: channels change by different factors, and one image of all channels sees their proportion"
                .into(),
        ),
        Fault::Gain if breaks => Some("Gain: it reads absolute readings".into()),
        _ => None,
    }
}
