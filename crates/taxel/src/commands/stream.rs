//! `taxel stream`: what a model says about readings as they come.

use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use taxel::data::{Clock, Padding};
use taxel::stream::{
    Arrival, Columns, Decider, Event, Next, Pace, Source, Stamps, Stream as Readings, Time, Told, start,
};
use taxel::{Model, ReadOptions};

use crate::Outcome;
use crate::commands::asked::{attributes, resize};
use crate::commands::interrupt::flag;
use crate::commands::stream_text::{Answers, Summary, warn};

/// How long nothing may come before signals are looked for.
const QUIET: Duration = Duration::from_millis(20);
/// How far a stream's rate may be off the model's before it is said.
const OFF: f64 = 0.1;

/// Answers readings as they come, with a model that `taxel fit` made: a window slides over them, and each decision is one
/// line of JSON.
///
/// A reading is all values of one instant, in the order of a sample of the model without its time: the channels of a
/// series, the fingers' channels finger by finger, a frame row by row. A model of single images or rows of features reads
/// one sample per line; its window is 1. `taxel inspect MODEL` says what a reading is.
///
/// Lines are numbers parted by commas (or semicolons, tabs or spaces), JSON arrays, or JSON objects. A header, or the keys,
/// may name the columns: one called time, timestamp or t (time_ms: in ms) holds time stamps, the others are found by the
/// names that the model knows. Lines that are no reading are skipped and counted.
///
/// A decision has time (s: the stream's own stamp, else since the first reading), reading (the last one of the window, from
/// 0), class, probabilities, latency_ms (from the arrival of that reading to the decision), seen (share of the window that
/// was there), and channels by position from 0 or by name: dead (at rest, never moved so far), stuck (has stopped moving
/// elsewhere, or stopped flickering), saturated (at full scale within the window). Where the model's encoding refuses a
/// window, class is null and refused says why.
///
/// At the end, of the input or by Ctrl-C or SIGTERM, a summary follows on standard error, one line of JSON: what was read,
/// skipped, dropped, gaps and jumps of the clock, latencies. A gap of half a window or more begins the window anew.
///
/// Readings wait in a queue (1024 at most). When answers are slower than readings, or nobody reads the decisions, standard
/// input and files wait and nothing is lost; what comes at a rate of its own (--serial, --pace rate) is dropped and counted.
#[derive(Args)]
#[command(after_help = "Examples:  sensor | taxel stream model.safetensors
           taxel stream model.safetensors --serial /dev/ttyUSB0 --baud 115200 --contact
           taxel stream model.safetensors --input press.csv --pace rate --hop 10 --early 0.9
           taxel stream model.safetensors --input recordings.npz --hop 1")]
pub struct Stream {
    /// The model.
    model: PathBuf,
    /// Replays a file: lines of CSV or JSON, or recordings of anything that `taxel predict` reads, one after the other
    /// [default: lines from standard input].
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
    /// Reads lines from a serial port.
    #[cfg(feature = "serial")]
    #[arg(long, value_name = "PORT", conflicts_with = "input")]
    serial: Option<String>,
    /// Bits per second of the serial port.
    #[cfg(feature = "serial")]
    #[arg(long, default_value_t = 115_200, requires = "serial")]
    baud: u32,
    /// How fast a file is replayed: at its own rate, by its time stamps or --rate, or as fast as it is answered.
    #[arg(long, value_enum, default_value = "fast", requires = "input")]
    pace: Speed,
    /// Readings per second where no time stamps say it [default: the model's].
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// The column of time stamps: its number, from 1, or its name.
    #[arg(long, value_name = "COLUMN")]
    time: Option<Time>,
    /// Unit of the time stamps: s, ms, us or ns [default: the end of the column's name, else s].
    #[arg(long, value_name = "UNIT", value_parser = clock)]
    clock: Option<Clock>,
    /// Readings from one window to the next [default: a quarter of a window].
    #[arg(long, value_name = "N")]
    hop: Option<usize>,
    /// Starts a window when a value rises above 1.1 or falls below 0.9 times its level at rest; the window fills whatever
    /// comes then, and slides on until all values are back within 1.05 and 0.95. The level at rest is the model's, or the mean
    /// of the first 20 readings, and follows slow drift. A model with a contact judge of its own lends its thresholds. Where
    /// rest is 0, the full scale says what a tenth is: at least half a percent of it.
    #[arg(long)]
    contact: bool,
    /// Readings of a window before the contact that starts it [default: 0; of a model that looks for contact itself half of
    /// what it can leave out].
    #[arg(long, value_name = "N", requires = "contact")]
    before: Option<usize>,
    /// Decides before the window is full, once per window, as soon as the likeliest class is this probable, 0 to 1. What is
    /// missing is padded. `taxel report` shows how right early answers are.
    #[arg(long, value_name = "CONFIDENCE")]
    early: Option<f32>,
    /// Readings that a window has at least before it is decided early [default: a tenth of a window].
    #[arg(long, value_name = "N", requires = "early")]
    least: Option<usize>,
    /// What an early window is filled up with: zeros, or its last reading [default: what the model has learned with, else
    /// its last reading].
    #[arg(long, value_enum, requires = "early")]
    pad: Option<Filler>,
    /// The largest possible reading [default: the model's]: what is there is saturated.
    #[arg(long, value_name = "VALUE")]
    full_scale: Option<f32>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Speed {
    Rate,
    Fast,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Filler {
    Zero,
    Edge,
}

fn clock(name: &str) -> Result<Clock, String> {
    Clock::named(name).ok_or_else(|| "a unit of time is s, ms, us or ns".into())
}

/// Why a stream is over.
enum Over {
    /// Nothing comes any more.
    Input,
    Signal,
    /// Nobody reads the decisions.
    Output,
}

impl Stream {
    pub fn run(self) -> Outcome {
        let cancel = flag()?;
        if self.rate.is_some_and(|rate| !(rate > 0.0 && rate.is_finite())) {
            return Err("--rate is in readings per second (Hz), above 0".into());
        }
        let predictor = Model::open(&self.model)?.predictor(1, 1)?;
        let mut decider = Decider::new(predictor, &self.options())?;
        if let Some(taxel::Length::Resample { to }) = decider.card().spec.length {
            warn(&format!(
                "the model has learned whole recordings resampled to {to} readings; a window is the last {to} readings as \
                 they come"
            ));
        }
        let readings = start(self.source(), self.told(&decider), warn)?;
        let mut work = Work {
            stamps: Stamps::new(decider.ticks()),
            answers: Answers::new(decider.card()),
            summary: Summary::default(),
            said_rate: false,
            said_vain: false,
            first: None,
        };
        let how = work.answer(&mut decider, &readings, &cancel);
        let (ended, error) = match how {
            Ok(Over::Input) => ("input", None),
            Ok(Over::Signal) => ("signal", None),
            Ok(Over::Output) => ("output", None),
            Err(error) => ("error", Some(error)),
        };
        let counted = readings.counted();
        if decider.waits_in_vain() {
            warn(
                "--contact: no value has a level at rest above 0, so that no contact was seen; say --full-scale",
            );
        } else if counted.readings > 0 && counted.readings < decider.ticks() as u64 {
            let (came, ticks) = (counted.readings, decider.ticks());
            warn(&format!("{came} readings came, a window has {ticks}; --early decides before it is full"));
        }
        // Of what could not begin there is nothing to be summed up.
        if error.is_none() || counted.readings > 0 {
            work.summary.write(&counted, decider.contacts(), ended)?;
        }
        error.map_or(Ok(ExitCode::SUCCESS), Err)
    }

    fn options(&self) -> taxel::stream::Options {
        taxel::stream::Options {
            hop: self.hop,
            contact: self.contact,
            before: self.before,
            early: self.early,
            least: self.least,
            padding: self.pad.map(|pad| match pad {
                Filler::Zero => Padding::Zero,
                Filler::Edge => Padding::Edge,
            }),
            full_scale: self.full_scale,
        }
    }

    fn source(&self) -> Source {
        #[cfg(feature = "serial")]
        if let Some(port) = &self.serial {
            return Source::Serial { port: port.clone(), baud: self.baud };
        }
        self.input.clone().map_or(Source::Input, Source::Path)
    }

    fn told(&self, decider: &Decider) -> Told {
        let card = decider.card();
        let spec = card.spec.clone();
        let path = self.input.as_deref();
        let bags = path.is_some_and(taxel::data::are_bags);
        // As `taxel predict` reads recordings, each as long as it is.
        let options = ReadOptions {
            resize: path.and_then(|path| resize(path, &spec)),
            attributes: attributes(card),
            layout: Some(spec.layout),
            topics: if bags { spec.topics.clone() } else { vec![] },
            table: spec.table.clone().unwrap_or_default(),
            ..ReadOptions::default()
        };
        Told {
            columns: Columns::new(&spec, self.time.clone(), self.clock),
            pace: if self.pace == Speed::Rate { Pace::Rate } else { Pace::Fast },
            rate: self.rate,
            options,
            spec,
        }
    }
}

/// A stream on its way.
struct Work {
    stamps: Stamps,
    answers: Answers,
    summary: Summary,
    /// Whether it has been said that the rate is not the model's, and that no contact can be seen.
    said_rate: bool,
    said_vain: bool,
    /// When the first reading came.
    first: Option<Instant>,
}

impl Work {
    fn answer(
        &mut self,
        decider: &mut Decider,
        readings: &Readings,
        cancel: &AtomicBool,
    ) -> Result<Over, Box<dyn std::error::Error>> {
        let mut out = std::io::BufWriter::new(std::io::stdout().lock());
        loop {
            if cancel.load(Ordering::Relaxed) {
                return over(out.flush(), Over::Signal);
            }
            let next = match readings.waiting() {
                // Nothing else is to be done: whoever reads the decisions gets them.
                Next::Quiet => {
                    if let gone @ (Ok(Over::Output) | Err(_)) = over(out.flush(), Over::Input) {
                        return gone;
                    }
                    readings.next(QUIET)
                }
                next => next,
            };
            match next {
                Next::Quiet => {}
                Next::Begin(name) => {
                    decider.begin();
                    self.stamps.begin();
                    self.answers.recording = Some(name);
                }
                Next::Reading(arrival) => {
                    let written = self.reading(decider, &arrival, &mut out);
                    readings.give_back(arrival.values);
                    if let gone @ (Ok(Over::Output) | Err(_)) = over(written, Over::Input) {
                        return gone;
                    }
                }
                Next::End(how) => {
                    let flushed = over(out.flush(), Over::Input);
                    how?;
                    return flushed;
                }
            }
        }
    }

    fn reading(
        &mut self,
        decider: &mut Decider,
        arrival: &Arrival,
        out: &mut impl Write,
    ) -> std::io::Result<()> {
        let first = *self.first.get_or_insert(arrival.at);
        if self.is_torn(decider, arrival) {
            decider.anew();
        }
        if !self.said_vain && decider.waits_in_vain() {
            self.said_vain = true;
            warn(
                "--contact: no value has a level at rest above 0, so that no contact can be seen; say --full-scale",
            );
        }
        let Some(decision) = decider.push(&arrival.values) else { return Ok(()) };
        let latency = arrival.at.elapsed();
        let time = arrival.stamp.unwrap_or_else(|| (arrival.at - first).as_secs_f64());
        self.summary.decided(&decision, latency);
        self.answers.write(&decision, time, latency, out)
    }

    /// Whether what comes before a reading is not what came last.
    fn is_torn(&mut self, decider: &Decider, arrival: &Arrival) -> bool {
        let event = match arrival.stamp {
            Some(stamp) => self.stamps.push(stamp),
            None if arrival.lost > 0 => Event::Gap(arrival.lost),
            None => Event::Steady,
        };
        let anew = self.stamps.begins_anew(event);
        self.summary.event(event, anew);
        if let (Some(own), Some(rate), false) = (self.stamps.rate(), decider.card().spec.rate, self.said_rate)
        {
            self.said_rate = true;
            if (own / rate - 1.0).abs() > OFF {
                warn(&format!("readings come at {own:.1} Hz, the model has learned them at {rate} Hz"));
            }
        }
        anew
    }
}

/// What became of writing: nobody may be there to read.
fn over(written: std::io::Result<()>, otherwise: Over) -> Result<Over, Box<dyn std::error::Error>> {
    match written {
        Ok(()) => Ok(otherwise),
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(Over::Output),
        Err(e) => Err(format!("standard output: cannot be written: {e}").into()),
    }
}
