//! Shows a stream on its live page.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use taxel::stream::Decider;

use crate::live::LivePage;

/// Time between two decisions that are shown; of a decision for every time step most would be drawn over.
const SHOWN: Duration = Duration::from_millis(40);

/// The live page of a stream.
pub struct LiveStream {
    page: LivePage,
    shown: Option<Instant>,
}

impl LiveStream {
    /// Shows what the model is; `early` is the confidence of early decisions.
    pub fn new(page: LivePage, decider: &Decider, source: &str, early: Option<f32>) -> Self {
        let card = decider.card();
        let spec = &card.spec;
        let columns = || spec.table.as_ref().map_or(vec![], |table| table.columns.clone());
        let channels = if spec.channel_names.is_empty() { columns() } else { spec.channel_names.clone() };
        let records = card.certainty.as_ref().map(|certainty| {
            let decided = certainty.early.iter().filter(|record| record.decided > 0);
            decided
                .map(|record| {
                    json!({
                        "confidence": record.confidence, "seen": record.seen, "right": record.right, "chance": record.chance,
                    })
                })
                .collect::<Vec<Value>>()
        });
        page.facts(&json!({
            "title": card.name, "about": format!("on {source}"), "channels": channels, "unit": spec.unit, "rate": spec.rate,
            "window": format!("{} readings", decider.ticks()), "early": records, "early_at": early,
        }));
        LiveStream { page, shown: None }
    }

    /// Shows a time step.
    pub fn reading(&mut self, values: &[f32], time: f64, lost: u64) {
        self.page.reading(values, time, lost);
    }

    /// Shows a decision as it was written.
    pub fn decided(&mut self, line: &[u8]) {
        let is_due = self.shown.is_none_or(|shown| shown.elapsed() >= SHOWN);
        if let (true, Ok(line)) = (is_due, std::str::from_utf8(line)) {
            self.shown = Some(Instant::now());
            self.page.show("decision", line);
        }
    }

    /// Says how the stream ended.
    pub fn end(&self, why: &str) {
        self.page.end(why);
    }
}
