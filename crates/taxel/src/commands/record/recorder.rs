//! Recording after recording, until all are there or somebody ends it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use taxel::stream::Arrival;

use super::faults::ChannelWatch;
use super::keys::{HELP, Keys, Wish};
use super::live::{LiveRecording, Phase};
use super::opinion::Opinion;
use super::output::{KeptLine, Printer};
use super::plan;
use super::sensor::{Heard, SILENT, Sensor, SourceKind};
use super::set::{RecordedSet, SetFacts};
use super::take::{Progress, Schedule, Take, Taken};
use crate::terminal::messages::note;

/// Time without a time step that ends a recording, at least; and in time steps.
const PAUSE: (Duration, f64) = (Duration::from_millis(500), 20.0);
/// Recordings in a row that may be incomplete where nobody looks on.
const ATTEMPTS: usize = 5;

/// Why recording ended.
pub enum Ended {
    /// All recordings are there.
    Complete,
    /// Somebody wanted it.
    Wish,
    /// Ctrl-C or SIGTERM.
    Signal,
    /// The input ended before.
    Input,
    /// The source broke off, or sends nothing that is whole.
    Broken(String),
}

/// How a recording ended.
enum Outcome {
    Taken(Taken, f64),
    /// It was given up: time steps that had come, and why.
    GivenUp(usize, String),
    /// So was all: the same, and how it ends.
    Over(usize, Ended),
}

/// The wish of a person at the terminal, or of nobody, between two recordings.
enum Turn {
    Record(String),
    End(Ended),
}

/// All that a recording needs.
pub struct Recorder {
    pub set: RecordedSet,
    pub sensor: Sensor,
    pub facts: SetFacts,
    pub kind: SourceKind,
    /// The arrivals show the rate.
    pub is_timed: bool,
    pub labels: Vec<String>,
    /// Recordings of each label.
    pub count: usize,
    pub seed: u64,
    pub pause: Duration,
    pub keys: Option<Keys>,
    pub watch: ChannelWatch,
    pub opinion: Option<Opinion>,
    pub printer: Printer,
    pub live: Option<LiveRecording>,
    pub cancel: Arc<AtomicBool>,
}

impl Recorder {
    /// Records until it ends.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn run(&mut self) -> Result<Ended, Box<dyn std::error::Error>> {
        let mut failed = 0;
        loop {
            let label = match self.turn()? {
                Turn::Record(label) => label,
                Turn::End(ended) => return Ok(ended),
            };
            match self.record(&label) {
                Outcome::Taken(taken, began) => {
                    failed = 0;
                    self.keep(&label, &taken, began)?;
                }
                Outcome::GivenUp(readings, why) => {
                    self.not_kept(&label, readings, &why);
                    failed += 1;
                    if self.keys.is_none() && failed == ATTEMPTS {
                        return Ok(Ended::Broken(format!(
                            "{ATTEMPTS} recordings in a row were not whole: {why}"
                        )));
                    }
                }
                Outcome::Over(readings, ended) => {
                    let why = match &ended {
                        Ended::Broken(why) => why.clone(),
                        Ended::Input => "the input ended".into(),
                        _ => "it was stopped".into(),
                    };
                    if readings > 0 {
                        self.not_kept(&label, readings, &why);
                    }
                    return Ok(ended);
                }
            }
        }
    }

    /// Waits for a person, if there is one, and returns the label to record.
    fn turn(&mut self) -> Result<Turn, Box<dyn std::error::Error>> {
        let mut chosen = None;
        loop {
            let Some(label) = chosen.take().or_else(|| self.next()) else {
                return Ok(Turn::End(Ended::Complete));
            };
            if self.keys.is_none() {
                return Ok(Turn::Record(label));
            }
            self.show(&label, Phase::Wait);
            let (done, of) = self.progress();
            note(format!("{} of {of}: {label} ({}). {HELP}", done + 1, self.set.session()));
            match self.wait_for_wish()? {
                Ok(Wish::Start) => return Ok(Turn::Record(label)),
                Ok(Wish::Label(other)) => chosen = Some(other),
                Ok(Wish::Quit) => return Ok(Turn::End(Ended::Wish)),
                Ok(Wish::Session) => self.set.next_session(),
                Ok(Wish::Undo) => match self.set.throw_away()? {
                    Some(kept) => self.printer.thrown_away(&kept.file),
                    None => note("nothing was recorded since the program began, so nothing is thrown away"),
                },
                Err(ended) => return Ok(Turn::End(ended)),
            }
        }
    }

    /// Waits for a key while readings pass by.
    fn wait_for_wish(&mut self) -> Result<Result<Wish, Ended>, Box<dyn std::error::Error>> {
        loop {
            match self.keys.as_ref().and_then(|keys| keys.wish(&self.labels)) {
                Some(Ok(wish)) => return Ok(Ok(wish)),
                Some(Err(why)) => note(why),
                None => {}
            }
            if let Some(ended) = self.pass() {
                return Ok(Err(ended));
            }
        }
    }

    /// Lets a reading pass by that is not recorded; of a file none does. Returns how it ends, if it does.
    fn pass(&mut self) -> Option<Ended> {
        if self.cancel.load(Ordering::Relaxed) {
            return Some(Ended::Signal);
        }
        if self.kind == SourceKind::File {
            std::thread::sleep(Duration::from_millis(20));
            return None;
        }
        match self.sensor.next() {
            Heard::Reading(arrival, values) => self.pass_on(arrival, &values),
            Heard::Quiet => {}
            Heard::End(why) => return Some(why.map_or(Ended::Input, Ended::Broken)),
        }
        None
    }

    /// Shows a time step, and gives its memory back.
    fn pass_on(&mut self, arrival: Arrival, values: &[f32]) {
        if let Some(live) = &mut self.live {
            live.reading(&arrival, values);
        }
        self.sensor.give_back(arrival);
    }

    /// Shows where the recording is.
    fn show(&self, label: &str, phase: Phase) {
        let Some(live) = &self.live else { return };
        let counts = self.labels.iter().cloned().zip(self.set.counts(&self.labels)).collect();
        live.phase(phase, label, self.set.session(), self.progress(), (counts, self.count));
    }

    fn not_kept(&self, label: &str, readings: usize, why: &str) {
        let line = self.printer.not_kept(label, (readings, self.facts.rows), why);
        if let Some(live) = &self.live {
            live.taken(&line);
        }
    }

    fn next(&self) -> Option<String> {
        let counts = self.set.counts(&self.labels);
        plan::next(&self.labels, &counts, self.count, self.seed).map(|at| self.labels[at].clone())
    }

    /// Counts the recordings that are there, and those that are to be.
    pub fn progress(&self) -> (usize, usize) {
        let counts = self.set.counts(&self.labels);
        (counts.iter().sum(), counts.iter().map(|count| *count.max(&self.count)).sum())
    }

    /// Records once.
    fn record(&mut self, label: &str) -> Outcome {
        let end = Instant::now() + self.pause;
        let mut said = u64::MAX;
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            let seconds = left.as_secs() + 1;
            if self.keys.is_some() && seconds != said {
                said = seconds;
                self.show(label, Phase::Countdown);
                note(format!("{label} in {seconds} ..."));
            }
            if let Some(ended) = self.pass() {
                return Outcome::Over(0, ended);
            }
        }
        if self.keys.is_some() {
            note(if self.facts.rest > 0 { "at rest: do not touch it yet" } else { "now" });
        }
        // What came before belongs to nothing.
        while let Some(heard) = self.sensor.next_waiting() {
            if let Heard::Reading(arrival, values) = heard {
                self.pass_on(arrival, &values);
            }
        }
        self.show(label, if self.facts.rest > 0 { Phase::Rest } else { Phase::Touch });
        self.take(label)
    }

    /// Takes time steps until the recording is complete.
    fn take(&mut self, label: &str) -> Outcome {
        let facts = &self.facts;
        let mut take = Take::new(Schedule {
            rows: facts.rows,
            rest: facts.rest,
            rate: facts.rate,
            is_stamped: facts.is_stamped,
            is_live: self.is_timed,
        });
        let pause = PAUSE.0.max(Duration::from_secs_f64(PAUSE.1 / facts.rate));
        let (begin, mut began) = (Instant::now(), 0.0);
        loop {
            if self.cancel.load(Ordering::Relaxed) {
                return Outcome::Over(take.rows(), Ended::Signal);
            }
            match self.sensor.next() {
                Heard::Reading(arrival, values) => {
                    if take.rows() == 0 {
                        began = now();
                    }
                    let progress = take.push(&arrival, &values);
                    self.pass_on(arrival, &values);
                    match progress {
                        Progress::Going => {}
                        Progress::Rested => {
                            self.show(label, Phase::Touch);
                            if self.keys.is_some() {
                                note("now touch it");
                            }
                        }
                        Progress::Done(taken) => return Outcome::Taken(taken, began),
                        Progress::Broken(why) => return Outcome::GivenUp(take.rows(), why),
                    }
                }
                Heard::Quiet => {
                    if take.silence().is_some_and(|silence| silence > pause) {
                        return Outcome::GivenUp(
                            take.rows(),
                            format!("nothing came for {} s", pause.as_secs_f64()),
                        );
                    }
                    if take.rows() == 0 && begin.elapsed() > SILENT {
                        let why = format!("{}: nothing came for {} s", self.sensor.label(), SILENT.as_secs());
                        return Outcome::Over(0, Ended::Broken(why));
                    }
                }
                Heard::End(why) => {
                    return Outcome::Over(take.rows(), why.map_or(Ended::Input, Ended::Broken));
                }
            }
        }
    }

    /// Writes a recording, and says what is wrong with it.
    fn keep(&mut self, label: &str, taken: &Taken, began: f64) -> Result<(), Box<dyn std::error::Error>> {
        let channels = self.facts.channels.len();
        let rest = means(&taken.values, channels, self.facts.rest);
        let kept = self.set.keep(label, taken, &rest, began)?;
        let faults = self.watch.look(&taken.values, self.facts.rest);
        let said = self.opinion.as_ref().map(|opinion| opinion.of(&self.set.path_of(&kept)));
        let next = self.next();
        let line = self.printer.kept(&KeptLine {
            number: self.progress(),
            file: &kept.file,
            label,
            session: self.set.session(),
            taken,
            rate: self.facts.rate,
            channels: &self.facts.channels,
            rest: &rest,
            faults: &faults,
            said: said.as_ref(),
            next: next.as_deref(),
        });
        if let Some(live) = &self.live {
            live.taken(&line);
        }
        self.show(label, Phase::Kept);
        if let Some(keys) = &self.keys {
            keys.forget();
        }
        Ok(())
    }
}

/// Returns the seconds since 1970.
#[expect(clippy::disallowed_methods, reason = "a date for people; nothing is measured by it")]
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}

/// Returns the mean of each channel over the first `rows` time steps; none of no rows.
fn means(values: &[f32], channels: usize, rows: usize) -> Vec<f32> {
    let mean = |channel: usize| {
        let of = values.iter().skip(channel).step_by(channels.max(1)).take(rows);
        (of.map(|value| f64::from(*value)).sum::<f64>() / rows as f64) as f32
    };
    if rows == 0 { vec![] } else { (0..channels).map(mean).collect() }
}
