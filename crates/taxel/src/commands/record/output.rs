//! Lines that `taxel record` prints: one for each recording, and at once what is wrong with it.

use serde_json::{Value, json};

use super::faults::ChannelFaults;
use super::opinion::Said;
use super::take::Taken;
use crate::outln;
use crate::terminal::messages::{note, warn};

/// Names that a line lists.
const SHOWN: usize = 8;

/// Prints for people, or for programs.
#[derive(Clone, Copy)]
pub struct Printer {
    pub is_json: bool,
}

/// A recording that was kept, for its line.
pub struct KeptLine<'l> {
    /// How many there are now, and are to be.
    pub number: (usize, usize),
    pub file: &'l str,
    pub label: &'l str,
    pub session: &'l str,
    pub taken: &'l Taken,
    pub rate: f64,
    pub channels: &'l [String],
    pub rest: &'l [f32],
    pub faults: &'l ChannelFaults,
    pub said: Option<&'l Said>,
    /// The label that comes next.
    pub next: Option<&'l str>,
}

impl KeptLine<'_> {
    fn names(&self, channels: &[usize]) -> Vec<&str> {
        channels.iter().map(|at| self.channels[*at].as_str()).collect()
    }

    fn json(&self) -> Value {
        let ((number, of), taken, faults) = (self.number, self.taken, self.faults);
        json!({
            "recording": number, "of": of, "kept": true, "file": self.file, "label": self.label, "session": self.session,
            "readings": taken.times.len(), "rate": self.rate, "rest": self.rest, "missing": taken.missing,
            "evened": taken.is_evened, "dead": self.names(&faults.dead), "stuck": self.names(&faults.stuck),
            "clipped": self.names(&faults.clipped), "touched_at_rest": faults.touched_at_rest,
            "model": self.said.map(|said| said.json.clone()), "next": self.next,
        })
    }

    /// Lists what is odd about the recording.
    fn warnings(&self) -> Vec<String> {
        let listed = |channels: &[usize]| {
            let names = self.names(channels);
            let more = names.len().saturating_sub(SHOWN);
            let names = names[..names.len() - more].join(", ");
            if more > 0 { format!("{names} and {more} more") } else { names }
        };
        let mut warnings = vec![];
        let faults = self.faults;
        for (found, what) in [
            (&faults.dead, "dead, or never touched so far"),
            (&faults.stuck, "stuck"),
            (&faults.clipped, "clipped: pressed harder than the sensor can say"),
        ] {
            if !found.is_empty() {
                warnings.push(format!("{what}: {}", listed(found)));
            }
        }
        if faults.touched_at_rest {
            warnings.push(
                "the sensor was moving at rest: touch it only after the rest, and throw this one away".into(),
            );
        }
        if self.taken.missing > 0 {
            warnings.push(format!("{} readings were missing, and are interpolated", self.taken.missing));
        }
        warnings
    }
}

impl Printer {
    /// Prints a recording that was kept; returns its line for programs.
    pub fn kept(self, line: &KeptLine) -> Value {
        let warnings = line.warnings();
        let ((number, of), rows) = (line.number, line.taken.times.len());
        let json = line.json();
        if self.is_json {
            outln!("{json}");
            return json;
        }
        let said = line.said.map_or(String::new(), |said| format!("  model: {}", said.words));
        outln!("{number} of {of}  {}  {rows} readings at {} Hz{said}", line.file, line.rate);
        warnings.iter().for_each(|words| warn(format!("{}: {words}", line.file)));
        json
    }

    /// Prints that a recording was not kept, and why; returns its line for programs.
    pub fn not_kept(self, label: &str, readings: (usize, usize), why: &str) -> Value {
        let json = json!({ "kept": false, "label": label, "readings": readings.0, "why": why });
        if self.is_json {
            outln!("{json}");
        } else {
            let (came, of) = readings;
            warn(format!("{label}: not kept, {why} (after {came} of {of} readings)"));
        }
        json
    }

    /// Prints that the last recording was thrown away.
    pub fn thrown_away(self, file: &str) {
        if self.is_json {
            outln!("{}", json!({ "kept": false, "file": file, "why": "thrown away" }));
        } else {
            note(format!("{file}: thrown away"));
        }
    }

    /// Prints what was recorded at the end.
    pub fn summary(self, summary: &Value, words: &str) {
        if self.is_json {
            outln!("{}", json!({ "summary": summary }));
        } else {
            note(words);
        }
    }
}
