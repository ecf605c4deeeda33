//! The numbers of a stress test in words.

use taxel_faults::Fault;
use taxel_learn::ModelInput;

use super::scores::has_margin;
use crate::values::{FaultCurve, FaultInfo, NetworkStress, Primary};

/// Percentage points below which a loss is not worth a word; of values as [`Primary::share`] says.
const SMALL: f64 = 2.0;

/// Says which fault breaks a network first and which faults it stands, with the reason where its inputs explain it.
pub(super) fn verdict(
    primary: &Primary,
    network: &NetworkStress,
    chance: f64,
    inputs: &[ModelInput],
) -> String {
    if !has_margin(primary, network.clean.score, chance) {
        let nothing = primary.knowing_nothing();
        return format!("no better than {nothing}; there is nothing to break");
    }
    let loss = |curve: &FaultCurve| curve.loss(network.clean, primary);
    let small = primary.share(SMALL, chance);
    let mut broken: Vec<(u8, &FaultCurve)> =
        network.curves.iter().filter_map(|curve| Some((curve.breaks_at?, curve))).collect();
    broken.sort_by(|a, b| a.0.cmp(&b.0).then(loss(b.1).total_cmp(&loss(a.1))));
    let mut words = match broken.first() {
        None => format!("keeps half of its {} under every fault that was tried", primary.margin_of_chance()),
        Some((at, first)) => {
            let info = FaultInfo::of(first.fault);
            format!("breaks first under {} (severity {at}: {} {})", info.fault, info.level(*at), info.unit)
        }
    };
    if broken.len() > 1 {
        let rest: Vec<String> = broken[1..].iter().map(|(at, c)| format!("{} ({at})", c.fault)).collect();
        words += &format!(", then {}", rest.join(", "));
    }
    let held: Vec<&str> = network.curves.iter().filter(|c| loss(c) < small).map(|c| c.fault.name()).collect();
    if !held.is_empty() {
        words += &format!("; hardly notices {}", held.join(", "));
    }
    let reasons: Vec<String> = network
        .curves
        .iter()
        .filter_map(|c| reason(c.fault, c.breaks_at.is_some(), loss(c) < small, inputs))
        .collect();
    if !reasons.is_empty() {
        words += &format!(". {}", reasons.join(". "));
    }
    words
}

/// Returns the explanation that the inputs of a network give, if the numbers agree with it.
fn reason(fault: Fault, breaks: bool, held: bool, inputs: &[ModelInput]) -> Option<String> {
    let blind = |input: &ModelInput| input.transform.is_blind_to_amplitude();
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
