//! Recordings that a model is asked about, read as those that it has learned from.

use std::error::Error;
use std::path::Path;

use taxel::data::{Recordings, TableForm, TableOptions, recordings};
use taxel::{Card, Length, ReadOptions};

use crate::commands::reading::with_option_hint;

/// Where they are, and what is said of them.
pub struct Asked<'a> {
    pub data: &'a Path,
    pub reading: &'a ReadOptions,
}

impl Asked<'_> {
    /// The recordings as the model with this card reads them, and how they were read.
    pub fn of(&self, card: &Card) -> Result<(Recordings, ReadOptions), Box<dyn Error>> {
        let spec = &card.spec;
        let options = ReadOptions {
            resize: resize(self.data, spec),
            attributes: attributes(card),
            layout: Some(spec.layout),
            length: self.length(spec)?,
            topics: self.topics(spec)?,
            table: self.table(spec),
            stamped: spec.recorded_rate(),
            ..self.reading.clone()
        };
        let to = spec.layout.time_axis().map(|axis| spec.shape[axis]);
        let read = recordings(self.data, &options, spec.layout.rank());
        Ok((read.map_err(|e| with_option_hint(e, to))?, options))
    }

    /// The model's own rule, or one for a model that has none.
    fn length(&self, spec: &taxel::SampleSpec) -> Result<Option<Length>, String> {
        match (spec.length, self.reading.length) {
            (Some(own), Some(given)) if own != given => {
                Err(format!("--length {given}: the model has its own rule, {own}; leave it out"))
            }
            (own, given) => Ok(own.or(given)),
        }
    }

    /// The columns that the model has learned from, and what is said of these ones.
    fn table(&self, spec: &taxel::SampleSpec) -> TableOptions {
        let own = spec.table.clone().unwrap_or_default();
        let given = self.reading.table.clone();
        if given == TableOptions::default() {
            return own;
        }
        let is_wide = spec.layout.rank() == own.shape.len().max(1);
        let form = if is_wide { TableForm::Wide } else { TableForm::Long };
        TableOptions {
            form: given.form.or(Some(form)),
            recording: given.recording.or(own.recording),
            time: given.time.or(own.time),
            clock: given.clock.or(own.clock),
            columns: if given.columns.is_empty() { own.columns } else { given.columns },
            shape: if given.shape.is_empty() { own.shape } else { given.shape },
            ..given
        }
    }

    /// The topics that the model has learned from, where it reads bags.
    fn topics(&self, spec: &taxel::SampleSpec) -> Result<Vec<String>, String> {
        let given = &self.reading.topics;
        match taxel::data::are_bags(self.data) {
            false => Ok(given.clone()),
            true if spec.topics.is_empty() => Ok(given.clone()),
            true if given.is_empty() || *given == spec.topics => Ok(spec.topics.clone()),
            true => {
                let [own, given] = [&spec.topics, given].map(|topics| topics.join(", "));
                Err(format!("--topic {given}: the model has learned from {own}; leave it out"))
            }
        }
    }
}

/// Names of the attributes where the model answers several.
pub(super) fn attributes(card: &Card) -> Vec<String> {
    match card.task.attributes().as_slice() {
        [_] => vec![],
        several => several.iter().map(|own| own.name.clone()).collect(),
    }
}

/// Image files are brought to the size that the model reads.
pub(super) fn resize(data: &Path, spec: &taxel::SampleSpec) -> Option<[usize; 2]> {
    let holds_images = || taxel::data::are_images(data) || taxel::data::are_bags(data);
    match spec.shape[..] {
        [.., height, width] if spec.layout.has_area() && holds_images() => Some([height, width]),
        _ => None,
    }
}
