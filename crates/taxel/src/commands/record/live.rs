//! Shows a recording on its live page.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};
use taxel::stream::Arrival;

use super::set::SetFacts;
use crate::live::LivePage;

/// Where a recording is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Somebody has to start it.
    Wait,
    Countdown,
    /// The sensor is at rest.
    Rest,
    /// The sensor is to be touched.
    Touch,
    /// It is written.
    Kept,
}

impl Phase {
    fn name(self) -> &'static str {
        match self {
            Phase::Wait => "wait",
            Phase::Countdown => "countdown",
            Phase::Rest => "rest",
            Phase::Touch => "touch",
            Phase::Kept => "kept",
        }
    }
}

/// The live page of a recording.
pub struct LiveRecording {
    page: LivePage,
    first: Option<Instant>,
}

impl LiveRecording {
    /// Shows what is recorded.
    pub fn new(page: LivePage, folder: &Path, facts: &SetFacts) -> Self {
        page.facts(&json!({
            "title": format!("recording into {}", folder.display()),
            "about": format!("{} readings each, {} of them at rest", facts.rows, facts.rest),
            "channels": facts.channels, "unit": facts.unit, "rate": facts.rate,
        }));
        LiveRecording { page, first: None }
    }

    /// Shows a time step, its values in the order of the set.
    pub fn reading(&mut self, arrival: &Arrival, values: &[f32]) {
        let first = *self.first.get_or_insert(arrival.at);
        let time = arrival.stamp.unwrap_or_else(|| (arrival.at - first).as_secs_f64());
        self.page.reading(values, time, arrival.lost);
    }

    /// Shows where the recording is, and how many of each label there are of so many.
    pub fn phase(
        &self,
        phase: Phase,
        label: &str,
        session: &str,
        (done, of): (usize, usize),
        (counts, count): (BTreeMap<String, usize>, usize),
    ) {
        let line = json!({
            "phase": phase.name(), "label": label, "session": session, "done": done, "of": of, "counts": counts, "count": count,
        });
        self.page.show("phase", &line.to_string());
    }

    /// Shows a recording that was kept, or that was not.
    pub fn taken(&self, line: &Value) {
        self.page.show("take", &line.to_string());
    }

    /// Says how it ended.
    pub fn end(&self, why: &str) {
        self.page.end(why);
    }
}
