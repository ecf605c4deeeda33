//! Recordings for a model, read like those that it was trained on.

use std::error::Error;
use std::path::Path;

use taxel::data::{
    FactComparison, RecordingFacts, Recordings, TableForm, TableOptions, Tare, TaskKind, recordings,
};
use taxel::{Card, Length, ReadOptions};

use crate::commands::arguments::option_hints::with_option_hint;
use crate::terminal::messages::{note, warn};

/// How to go on where facts differ.
pub const AS_IS: &str = ", or predict all the same with --as-is";

/// Recordings on disk, and how the command line says to read them.
pub struct ModelRecordings<'a> {
    pub data: &'a Path,
    pub read_options: &'a ReadOptions,
    /// Whether unit, rate, full scale, layout and bit depth are not compared; none where the command has no such flag.
    pub as_is: Option<bool>,
}

impl ModelRecordings<'_> {
    /// Reads the recordings for the model with this card; also returns the options with which they are the data set that the
    /// model could be trained on.
    pub fn of(&self, card: &Card) -> Result<(Recordings, ReadOptions), Box<dyn Error>> {
        let spec = &card.spec;
        let options = ReadOptions {
            resize: resize(self.data, spec),
            attributes: attributes(card),
            layout: Some(spec.layout),
            length: self.length(spec)?,
            topics: self.topics(spec)?,
            table: self.table(spec),
            channel_names: spec.channel_names.clone(),
            stamped: spec.recorded_rate(),
            recording: self.read_options.recording.clone().or_else(|| spec.recording.clone()),
            // Of a model that reads what the sensor gives nothing is taken off.
            tare: self.read_options.tare.clone().or_else(|| spec.tare.clone()).or(Some(Tare::Off)),
            ..self.read_options.clone()
        };
        let to = spec.layout.time_axis().map(|axis| spec.shape[axis]);
        let read = recordings(self.data, &options, spec.layout.rank());
        let mut recordings = read.map_err(|e| with_option_hint(e, to))?;
        recordings.facts.warnings.iter().for_each(warn);
        if self.as_is != Some(true) {
            let hint = if self.as_is.is_some() { AS_IS } else { "" };
            let comparison = compared(self.data, spec, &recordings.facts, hint)?;
            comparison.convert(&mut recordings.x);
        }
        let are_values = !card.task.quantities().is_empty();
        let task = options.task.or(are_values.then_some(TaskKind::Values));
        Ok((recordings, ReadOptions { channels: spec.channels.clone(), task, ..options }))
    }

    /// Reads labelled recordings for the model with this card; also returns them as a data set, in the unit of the training.
    #[cfg(feature = "lab")]
    pub fn labelled(&self, card: &Card) -> Result<(Recordings, taxel::Dataset), Box<dyn Error>> {
        let (recordings, options) = self.of(card)?;
        let mut dataset = taxel::load(self.data, &options).map_err(|e| with_option_hint(e, None))?;
        if dataset.len() != recordings.x.shape()[0] {
            let (file, labelled, all) = (self.data.display(), dataset.len(), recordings.x.shape()[0]);
            return Err(format!(
                "{file}: {labelled} of {all} samples have labels; label all or leave the others out"
            )
            .into());
        }
        let comparison = card.spec.compare(&recordings.facts);
        if comparison.unit.is_some() {
            comparison.convert(&mut dataset.x);
            dataset.spec.unit.clone_from(&card.spec.unit);
        }
        Ok((recordings, dataset))
    }

    /// Returns the length rule of the model, or the given one where the model has none.
    fn length(&self, spec: &taxel::SampleSpec) -> Result<Option<Length>, String> {
        match (spec.length, self.read_options.length) {
            (Some(rule), Some(given)) if rule != given => {
                Err(format!("--length {given}: the model has its own rule, {rule}; leave it out"))
            }
            (rule, given) => Ok(rule.or(given)),
        }
    }

    /// Returns the columns that the model was trained on, changed by what is said of these recordings.
    fn table(&self, spec: &taxel::SampleSpec) -> TableOptions {
        let trained = spec.table.clone().unwrap_or_default();
        let given = self.read_options.table.clone();
        if given == TableOptions::default() {
            return trained;
        }
        let is_wide = spec.layout.rank() == trained.shape.len().max(1);
        let form = if is_wide { TableForm::Wide } else { TableForm::Long };
        TableOptions {
            form: given.form.or(Some(form)),
            recording: given.recording.or(trained.recording),
            time: given.time.or(trained.time),
            clock: given.clock.or(trained.clock),
            columns: if given.columns.is_empty() { trained.columns } else { given.columns },
            shape: if given.shape.is_empty() { trained.shape } else { given.shape },
            ..given
        }
    }

    /// Returns the topics that the model was trained on, where the recordings are bags.
    fn topics(&self, spec: &taxel::SampleSpec) -> Result<Vec<String>, String> {
        let given = &self.read_options.topics;
        if !taxel::data::are_bags(self.data) || spec.topics.is_empty() {
            return Ok(given.clone());
        }
        if given.is_empty() || *given == spec.topics {
            return Ok(spec.topics.clone());
        }
        let [trained, given] = [&spec.topics, given].map(|topics| topics.join(", "));
        Err(format!("--topic {given}: the model was trained on {trained}; leave it out"))
    }
}

/// Compares recordings with what a model was trained on; says what is converted.
///
/// # Errors
/// Facts that differ, all of them.
pub fn compared(
    data: &Path,
    spec: &taxel::SampleSpec,
    facts: &RecordingFacts,
    hint: &str,
) -> Result<FactComparison, String> {
    let comparison = spec.compare(facts);
    if let Some(differences) = comparison.refusal() {
        let file = data.display();
        return Err(format!(
            "{file}: {differences}; record as in training, or correct what the files say{hint}"
        ));
    }
    if let Some(unit) = &comparison.unit {
        note(format!("{}: values are converted {unit}", data.display()));
    }
    Ok(comparison)
}

/// Returns the names of the attributes where the model predicts several.
pub fn attributes(card: &Card) -> Vec<String> {
    match card.task.attributes().as_slice() {
        [_] => vec![],
        several => several.iter().map(|attribute| attribute.name.clone()).collect(),
    }
}

/// Returns the size that image files are brought to: that of the model.
pub fn resize(data: &Path, spec: &taxel::SampleSpec) -> Option<[usize; 2]> {
    let holds_images = || taxel::data::are_images(data) || taxel::data::are_bags(data);
    match spec.shape[..] {
        [.., height, width] if spec.layout.has_area() && holds_images() => Some([height, width]),
        _ => None,
    }
}
