//! The lines that `taxel stream` writes: decisions and the summary.

use std::io::Write;
use std::time::Duration;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::json;
use taxel::Card;
use taxel::data::Attribute;
use taxel::learn::certainty::AnswerSet;
use taxel::learn::metrics::Levels;
use taxel::stream::{Condition, Decision, Event, LatencyHistogram, StreamCounts};

use super::drift::Drift;
use crate::commands::arguments::certainty::{UNKNOWN, set_of};
use crate::terminal::messages::warn;

/// Writes decisions, with the names that the model knows.
pub struct DecisionWriter {
    attributes: Vec<Attribute>,
    /// Names of the probabilities.
    outputs: Vec<String>,
    /// Units of values; none of classes.
    units: Vec<Option<String>>,
    /// Names of the values of a time step, where the model knows any.
    channels: Vec<String>,
    /// The recording that is replayed.
    pub recording: Option<String>,
    sets: Option<AnswerSet>,
    levels: Levels,
}

/// A decision as it is written.
#[derive(Serialize)]
struct DecisionLine<'a> {
    time: f64,
    reading: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    values: Option<ByName<'a, f32>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    interval: Option<ByName<'a, [f32; 2]>>,
    /// Units of the values.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<ByName<'a, Option<String>>>,
    /// Of values: whether they are of a window that is unlike those of the training.
    #[serde(skip_serializing_if = "Option::is_none")]
    unknown: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    familiarity: Option<f32>,
    #[serde(flatten)]
    labels: Option<PredictedLabels<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
    latency_ms: f64,
    seen: f64,
    dead: Channels<'a, Condition>,
    stuck: Channels<'a, Condition>,
    saturated: Channels<'a, usize>,
}

/// Class and probabilities; nulls where there is no prediction.
#[derive(Serialize)]
struct PredictedLabels<'a> {
    class: Option<LikeliestClasses<'a>>,
    /// Where the class is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    likeliest: Option<LikeliestClasses<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    set: Option<Sets<'a>>,
    probabilities: Option<ByName<'a, f32>>,
}

/// The likeliest class, or that of each attribute by its name.
#[derive(Clone, Copy)]
struct LikeliestClasses<'a> {
    attributes: &'a [Attribute],
    probabilities: &'a [f32],
    /// Whether it stands for a class that the model does not know.
    is_unknown: bool,
}

impl Serialize for LikeliestClasses<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut rest = self.probabilities;
        let mut likeliest = |attribute: &Attribute| {
            let (probabilities, after) = rest.split_at(attribute.classes.len());
            rest = after;
            // The first of equal ones, as everywhere.
            (0..probabilities.len())
                .reduce(|best, at| if probabilities[at] > probabilities[best] { at } else { best })
        };
        match self.attributes {
            _ if self.is_unknown => serializer.serialize_str(UNKNOWN),
            [one] => likeliest(one).map(|at| &one.classes[at]).serialize(serializer),
            several => {
                let mut map = serializer.serialize_map(Some(several.len()))?;
                for attribute in several {
                    let class = likeliest(attribute).map(|at| &attribute.classes[at]);
                    map.serialize_entry(&attribute.name, &class)?;
                }
                map.end()
            }
        }
    }
}

/// The classes that hold the true one as often as the set says: a list, or one of each attribute by its name.
struct Sets<'a>(&'a [Attribute], Vec<Vec<usize>>);

impl Serialize for Sets<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let names = |(attribute, set): (&'_ Attribute, &'_ Vec<usize>)| -> Vec<String> {
            set.iter().map(|class| attribute.classes[*class].clone()).collect()
        };
        match (self.0, &self.1[..]) {
            ([one], [set]) => names((one, set)).serialize(serializer),
            (attributes, sets) => {
                let named = attributes.iter().zip(sets);
                serializer.collect_map(named.map(|both| (&both.0.name, names(both))))
            }
        }
    }
}

/// Outputs of a model by their names.
struct ByName<'a, T>(&'a [String], &'a [T]);

impl<T: Serialize> Serialize for ByName<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().zip(self.1))
    }
}

/// Values of a time step by name or position: those in a condition, or saturated within so many time steps.
struct Channels<'a, T> {
    decision: &'a Decision<'a>,
    names: &'a [String],
    selection: T,
}

impl Serialize for Channels<'_, Condition> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let found = self.decision.health.in_condition(self.selection);
        serializer.collect_seq(found.map(|at| Channel(at, self.names.get(at))))
    }
}

impl Serialize for Channels<'_, usize> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let found = self.decision.health.saturated(self.selection);
        serializer.collect_seq(found.map(|at| Channel(at, self.names.get(at))))
    }
}

struct Channel<'a>(usize, Option<&'a String>);

impl Serialize for Channel<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.1 {
            Some(name) => serializer.serialize_str(name),
            None => serializer.serialize_u64(self.0 as u64),
        }
    }
}

impl DecisionWriter {
    pub fn new(card: &Card, sets: Option<AnswerSet>) -> Self {
        let of_table = || card.spec.table.as_ref().map_or(vec![], |table| table.columns.clone());
        let (before, _, after) = card.spec.around_time();
        // Names of channels are those of values where a channel is one value.
        let of_spec = Some(card.spec.channel_names.clone()).filter(|names| names.len() == before * after);
        let channels = of_spec.filter(|names| !names.is_empty()).unwrap_or_else(of_table);
        DecisionWriter {
            outputs: card.task.output_names(),
            units: card.task.quantities().iter().map(|quantity| quantity.unit.clone()).collect(),
            channels,
            recording: None,
            attributes: card.task.attributes(),
            sets,
            levels: card.levels(),
        }
    }

    /// Writes a decision as one line.
    ///
    /// # Errors
    /// An output that cannot be written.
    pub fn write(
        &self,
        decision: &Decision,
        time: f64,
        latency: Duration,
        out: &mut impl Write,
    ) -> std::io::Result<()> {
        let (outputs, refused) = match decision.probabilities() {
            Ok(outputs) => (Some(outputs), None),
            Err(error) => (None, Some(error.to_string())),
        };
        let has_labels = !self.attributes.is_empty();
        let names = self.channels.as_slice();
        let attributes = self.attributes.as_slice();
        let likeliest = |probabilities| LikeliestClasses { attributes, probabilities, is_unknown: false };
        let classes = outputs.map(likeliest);
        let line = DecisionLine {
            time,
            reading: decision.reading,
            recording: self.recording.as_deref(),
            values: outputs.filter(|_| !has_labels).map(|values| ByName(&self.outputs, values)),
            interval: outputs
                .filter(|_| !decision.intervals.is_empty())
                .map(|_| ByName(&self.outputs, decision.intervals)),
            unit: outputs.filter(|_| !has_labels).map(|_| ByName(&self.outputs, &self.units)),
            unknown: decision.familiarity.filter(|_| !has_labels).map(|_| decision.is_unknown),
            familiarity: decision.familiarity,
            labels: has_labels.then(|| PredictedLabels {
                class: classes.map(|classes| LikeliestClasses { is_unknown: decision.is_unknown, ..classes }),
                likeliest: classes.filter(|_| decision.is_unknown),
                set: outputs.zip(self.sets.as_ref()).map(|(probabilities, sets)| {
                    Sets(&self.attributes, set_of(sets, probabilities, &self.levels, decision.is_unknown))
                }),
                probabilities: outputs.map(|probabilities| ByName(&self.outputs, probabilities)),
            }),
            refused,
            latency_ms: milliseconds(latency),
            seen: decision.seen(),
            dead: Channels { decision, names, selection: Condition::Dead },
            stuck: Channels { decision, names, selection: Condition::Stuck },
            saturated: Channels { decision, names, selection: decision.known },
        };
        serde_json::to_writer(&mut *out, &line).map_err(std::io::Error::from)?;
        out.write_all(b"\n")
    }
}

/// Returns milliseconds, right to the nanosecond.
fn milliseconds(duration: Duration) -> f64 {
    duration.as_nanos() as f64 / 1e6
}

/// Counts of a stream beside those of its time steps.
pub struct StreamSummary {
    drift: Drift,
    levels: Levels,
    decisions: u64,
    early: u64,
    refused: u64,
    unknown: u64,
    gaps: u64,
    missing: u64,
    jumps: u64,
    repeated: u64,
    wraps: u64,
    anew: u64,
    latencies: LatencyHistogram,
}

impl StreamSummary {
    pub fn new(card: &Card) -> Self {
        StreamSummary {
            drift: Drift::new(card),
            levels: card.levels(),
            decisions: 0,
            early: 0,
            refused: 0,
            unknown: 0,
            gaps: 0,
            missing: 0,
            jumps: 0,
            repeated: 0,
            wraps: 0,
            anew: 0,
            latencies: LatencyHistogram::default(),
        }
    }

    pub fn decided(&mut self, decision: &Decision, latency: Duration) {
        self.decisions += 1;
        self.early += u64::from(decision.is_early());
        self.refused += u64::from(decision.probabilities().is_err());
        self.unknown += u64::from(decision.is_unknown);
        if let Ok(probabilities) = decision.probabilities() {
            let confidence = self.levels.confidence(probabilities);
            self.drift.push(decision.is_unknown, f64::from(confidence));
        }
        self.latencies.push(latency);
    }

    /// Counts an event of the time stamps, and prints the first of each kind.
    pub fn event(&mut self, event: Event, anew: bool) {
        let then = if anew { "; the window begins anew" } else { "" };
        match event {
            Event::Steady => {}
            Event::Repeated => {
                self.repeated += 1;
                if self.repeated == 1 {
                    warn(
                        "a reading has the time stamp of the one before and is dropped. It is said once, the summary counts them",
                    );
                }
            }
            Event::Wrapped => {
                self.wraps += 1;
                if self.wraps == 1 {
                    warn(
                        "the time stamps are a counter that wraps; the window goes on. It is said once, the summary counts them",
                    );
                }
            }
            Event::Gap(missing) => {
                self.gaps += 1;
                self.missing += missing;
                if self.gaps == 1 {
                    warn(format!(
                        "a gap: {missing} readings are missing{then}. It is said once, the summary counts them"
                    ));
                }
            }
            Event::Jump(seconds) => {
                self.jumps += 1;
                if self.jumps == 1 {
                    let seconds =
                        if seconds.abs() < 1e15 { format!("{seconds:.3}") } else { format!("{seconds:.3e}") };
                    warn(format!(
                        "the clock jumps by {seconds} s{then}. It is said once, the summary counts them"
                    ));
                }
            }
        }
        self.anew += u64::from(anew);
    }

    /// Writes the summary on standard error.
    ///
    /// # Errors
    /// None in practice: counts are always JSON.
    pub fn write(&self, counted: &StreamCounts, contacts: u64, ended: &str) -> serde_json::Result<()> {
        // A quantile is right to 1 %.
        let quantile = |share| self.latencies.quantile_ms(share).map(|ms| (1e5 * ms).round() / 1e5);
        let latency = json!({
            "p50": quantile(0.5), "p99": quantile(0.99),
            "max": (self.decisions > 0).then(|| self.latencies.most_ms()),
        });
        let summary = json!({"summary": {
            "ended": ended, "readings": counted.readings, "decisions": self.decisions, "early": self.early,
            "refused": self.refused, "unknown": self.unknown, "contacts": contacts, "lines": counted.lines,
            "skipped": {
                "malformed": counted.malformed, "columns": counted.columns, "not_finite": counted.not_finite,
                "too_long": counted.too_long,
            },
            "dropped": counted.dropped, "gaps": self.gaps, "missing_readings": self.missing,
            "clock_jumps": self.jumps, "repeated_stamps": self.repeated, "clock_wraps": self.wraps,
            "windows_begun_anew": self.anew, "last_windows": self.drift.json(),
            "latency_ms": latency,
        }});
        let _ = writeln!(std::io::stderr(), "{}", serde_json::to_string(&summary)?);
        Ok(())
    }
}
