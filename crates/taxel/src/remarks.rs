//! Remarks on exported models, in ONNX and C alike.

use serde_json::json;
use taxel_data::SampleSpec;
use taxel_learn::Card;

/// Says what a program has to take off its readings before it calls an exported model; none of a model that reads what the sensor
/// gives.
pub(crate) fn tare_remark(card: &Card) -> Option<String> {
    let words = card.spec.tare.as_ref()?.words()?;
    Some(format!(
        "The model was trained on readings less their level at rest, and the export does not take it off. Your program has to: from \
         each channel of every reading it takes off {words}, before it calls the model."
    ))
}

/// Returns the tare and the names of the channels as facts of a file, as far as the model has them.
pub(crate) fn sensor_facts(spec: &SampleSpec) -> Vec<(String, String)> {
    let tare = spec.tare.iter().filter(|tare| tare.words().is_some());
    let mut facts: Vec<(String, String)> = tare.map(|tare| ("taxel.tare".into(), tare.to_string())).collect();
    if !spec.channel_names.is_empty() {
        facts.push(("taxel.channels".into(), json!(spec.channel_names).to_string()));
    }
    facts
}
