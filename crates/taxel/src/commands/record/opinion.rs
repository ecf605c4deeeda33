//! Asks a model about a recording that was just made.

use std::error::Error;
use std::path::Path;

use serde_json::{Value, json};
use taxel::data::{FactComparison, RecordingFacts};
use taxel::learn::certainty::FALSE_ALARMS;
use taxel::{Layout, Model, Predictor, ReadOptions};

use super::set::SetFacts;
use crate::commands::arguments::certainty::UNKNOWN;
use crate::commands::arguments::model_recordings::ModelRecordings;

/// A model that is asked after each recording.
pub struct Opinion {
    predictor: Predictor,
    /// How recordings of this set differ from those of the training.
    comparison: FactComparison,
}

/// The words for a recording, and the same for programs.
pub struct Said {
    pub words: String,
    pub json: Value,
}

impl Opinion {
    /// Opens a model for recordings with these facts.
    ///
    /// # Errors
    /// A file that is no model; recordings of another unit, rate or full scale than the training's.
    pub fn open(path: &Path, facts: &SetFacts) -> Result<Self, Box<dyn Error>> {
        let predictor = Model::open(path)?.predictor(1, 1)?;
        let recorded = RecordingFacts {
            dtype: "csv".into(),
            unit: facts.unit.clone(),
            rate: Some(facts.rate),
            full_scale: facts.full_scale.map(|full| full as f32),
            layout: Some(Layout::Series),
            channel_names: facts.channels.clone(),
            ..RecordingFacts::default()
        };
        let comparison = predictor.card().spec.compare(&recorded);
        if let Some(differences) = comparison.refusal() {
            return Err(format!(
                "{}: {differences}; record as in its training, or leave --model out",
                path.display()
            )
            .into());
        }
        Ok(Opinion { predictor, comparison })
    }

    /// Says what the model makes of a recording; a recording that it refuses is no error of the recording.
    pub fn of(&self, recording: &Path) -> Said {
        self.predicted(recording).unwrap_or_else(|error| {
            let why = error.to_string();
            Said { words: format!("the model refuses it: {why}"), json: json!({ "refused": why }) }
        })
    }

    fn predicted(&self, recording: &Path) -> Result<Said, Box<dyn Error>> {
        let card = self.predictor.card();
        let options = ReadOptions::default();
        let (mut read, _) =
            ModelRecordings { data: recording, read_options: &options, as_is: Some(true) }.of(card)?;
        self.comparison.convert(&mut read.x);
        let predictions = self.predictor.predict(&read.x)?;
        let Some(last) = predictions.len().checked_sub(1) else { return Err("it holds no window".into()) };
        let is_unknown = predictions.is_unknown(last, FALSE_ALARMS);
        if !card.task.quantities().is_empty() {
            let values: Vec<String> = predictions
                .values(last)
                .iter()
                .map(|(quantity, value)| format!("{} {value:.3}", quantity.name))
                .collect();
            let json = predictions
                .values(last)
                .iter()
                .map(|(quantity, value)| (quantity.name.clone(), json!(value)))
                .collect();
            let words = values.join(", ");
            let words = if is_unknown { format!("{UNKNOWN} ({words})") } else { words };
            return Ok(Said { words, json: Value::Object(json) });
        }
        let familiarity = predictions.familiarity.as_ref().map(|all| all[last]);
        let predicted = predictions.predicted(last);
        let names: Vec<String> = predicted.iter().map(|one| one.class.to_string()).collect();
        let surest: Vec<String> =
            predicted.iter().map(|one| format!("{} {:.0} %", one.class, 100.0 * one.probability)).collect();
        let words =
            if is_unknown { format!("{UNKNOWN}, like {}", surest.join(", ")) } else { surest.join(", ") };
        let json = json!({
            "class": if is_unknown { UNKNOWN.to_string() } else { names.join(", ") },
            "likeliest": names.join(", "),
            "probabilities": predicted.iter().map(|one| one.probability).collect::<Vec<_>>(),
            "familiarity": familiarity,
        });
        Ok(Said { words, json })
    }
}
