//! `taxel stream`: predictions for time steps as they come.

mod drift;
mod live;
mod output;

use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum, ValueHint};
use taxel::data::Padding;
use taxel::stream::{
    Arrival, Decider, Event, LineColumns, Next, Pace, ReadingStream, SourceSettings, Stamps, StreamOptions,
    StreamSource, start,
};
use taxel::{Card, Model, ReadOptions};

use crate::CommandResult;
use crate::commands::arguments::certainty::CertaintyOptions;
#[cfg(feature = "serial")]
use crate::commands::arguments::lines::PortOptions;
use crate::commands::arguments::lines::StampOptions;
use crate::commands::arguments::model_recordings::{attributes, resize};
use crate::live::ServeOptions;
use crate::terminal::interrupt::flag;
use crate::terminal::messages::{detail, unwritable, warn};
use live::LiveStream;
use output::{DecisionWriter, StreamSummary};

/// Time to write the last decision and the summary after a signal.
const GRACE: Duration = Duration::from_secs(2);
/// Time without a time step after which signals are looked for.
const QUIET: Duration = Duration::from_millis(20);
/// Difference between the rates of stream and model, as a share, from which on a warning is printed.
const OFF: f64 = 0.1;

/// Predicts on a live stream of time steps: a window slides over them, and each decision is one line of JSON.
///
/// A time step is all values of one instant, in the order of a sample of the model without its time: the channels of a
/// series, the fingers' channels finger by finger, a frame row by row. A model of single images or rows of features reads
/// one sample per line; its window is 1. `taxel inspect MODEL` prints the shape of a sample.
///
/// Lines are numbers separated by commas (or semicolons, tabs or spaces), JSON arrays, or JSON objects. A header, or the keys,
/// may name the columns: one called time, timestamp or t (time_ms: in ms) holds time stamps, the others are found by the
/// names that the model knows; where one of them is missing, the stream is refused. Lines that are no time step are skipped
/// and counted.
///
/// A decision has these keys. time: the time stamp, or else the seconds since the first time step. reading: the number of the
/// last time step of the window, from 0. class and probabilities; where the model's encoding refuses a window, class is null
/// and refused says why. familiarity: the share of held-out samples that were less like what the model has learned; at 0.05 or
/// below (--unknown) class is unknown, and likeliest names the nearest. set: with --set. Of values: values by name, their
/// unit, and interval, which holds the true value in nine of ten windows (--set); unknown is true, and there is no interval, where
/// they are of an unknown window. latency_ms: from the arrival of that time step to the decision. seen: the share of the window that was there. dead, stuck and saturated: channels by position from 0 or by name. A dead channel is at rest and has never
/// moved, a stuck one has stopped moving elsewhere or stopped flickering, a saturated one was at full scale in the window.
///
/// At the end, of the input or by Ctrl-C or SIGTERM, a summary follows on standard error, one line of JSON: time steps,
/// skipped lines, dropped time steps, gaps and jumps of the clock, latencies. A gap of half a window or more begins the
/// window anew.
///
/// --serve shows readings, decisions, sensors and latency on a page of this machine. A slow browser loses frames of it; the stream
/// never waits for one.
///
/// Time steps wait in a queue (1024 at most). When predictions are slower than time steps, or nobody reads the decisions,
/// standard input and files wait and nothing is lost; time steps that come at a fixed rate (--serial, --pace rate) are
/// dropped and counted.
#[derive(Args)]
#[command(after_help = "Examples:  sensor | taxel stream model.safetensors
           taxel stream model.safetensors --serial /dev/ttyUSB0 --baud 115200 --contact
           taxel stream model.safetensors --input press.csv --pace rate --hop 10 --early 0.9
           taxel stream model.safetensors --input recordings.npz --hop 1
           taxel stream model.safetensors --serial /dev/ttyUSB0 --serve 127.0.0.1:8000")]
pub struct Stream {
    /// The model file.
    #[arg(value_hint = ValueHint::FilePath)]
    model: PathBuf,
    /// The file to replay: lines of CSV or JSON, or recordings of anything that `taxel predict` reads, one after the other
    /// [default: lines from standard input].
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
    #[cfg(feature = "serial")]
    #[command(flatten)]
    port: PortOptions,
    /// How fast a file is replayed: by its time stamps or --rate, or as fast as possible.
    #[arg(long, value_enum, default_value = "fast", requires = "input")]
    pace: Speed,
    /// Time steps per second where there are no time stamps [default: the model's].
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    #[command(flatten)]
    stamps: StampOptions,
    /// Time steps from one window to the next [default: a quarter of a window].
    #[arg(long, value_name = "N")]
    hop: Option<usize>,
    /// Starts a window when a value rises above 1.1 or falls below 0.9 times its level at rest; the window fills whatever
    /// comes then, and slides on until all values are back within 1.05 and 0.95. The level at rest is the model's, or the mean
    /// of the first 20 time steps, and follows slow drift. A model whose encoding looks for contact lends its thresholds. Where
    /// rest is 0, the threshold is half a percent of the full scale.
    #[arg(long)]
    contact: bool,
    /// Time steps of a window before the contact that starts it [default: 0; of a model whose encoding looks for contact half of
    /// what it can leave out].
    #[arg(long, value_name = "N", requires = "contact")]
    before: Option<usize>,
    /// Decides before the window is full, once per window, as soon as the likeliest class is this probable, 0 to 1. The rest
    /// is padded. A calibrated model is looked at in tenths of the window, and waits until it is so sure that this share of
    /// early decisions was right in its run. `taxel report` shows the accuracy of early predictions.
    #[arg(long, value_name = "CONFIDENCE", allow_negative_numbers = true)]
    early: Option<f32>,
    /// Fewest time steps of a window that is decided early [default: a tenth of a window].
    #[arg(long, value_name = "N", requires = "early")]
    least: Option<usize>,
    /// Padding of an early window: zeros, or its last time step [default: that of the model's length rule, else its last
    /// time step].
    #[arg(long, value_enum, requires = "early")]
    pad: Option<Filler>,
    /// First readings that are at rest: their mean is taken off, for a model whose training had resting values taken off
    /// [default: as many as there, or 10]. A line that says tare takes the rest anew.
    #[arg(long, value_name = "N")]
    tare_steps: Option<usize>,
    /// The largest possible value [default: the model's]; a value there is saturated.
    #[arg(long, value_name = "VALUE")]
    full_scale: Option<f32>,
    /// Predicts recordings that are not as in training: unit, rate, full scale, layout and bit depth are not compared.
    #[arg(long, requires = "input")]
    as_is: bool,
    #[command(flatten)]
    certainty: CertaintyOptions,
    #[command(flatten)]
    serve: ServeOptions,
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

/// Why a stream ended.
enum End {
    /// The input ended.
    Input,
    /// Ctrl-C or SIGTERM.
    Signal,
    /// Nobody reads the decisions.
    Output,
}

impl Stream {
    pub fn run(self) -> CommandResult {
        let cancel = flag(GRACE)?;
        if self.rate.is_some_and(|rate| !(rate > 0.0 && rate.is_finite())) {
            return Err("--rate is in readings per second (Hz), above 0".into());
        }
        let predictor = Model::open(&self.model)?.predictor(1, 1)?;
        let (unknown, sets) = self.certainty.of(predictor.card())?;
        let interval = self.certainty.interval(predictor.card())?;
        let options = StreamOptions { interval, tare: self.tare(predictor.card()), ..self.options(unknown) };
        let mut decider = Decider::new(predictor, &options)?;
        self.say_how_sure(decider.card());
        if let Some(taxel::Length::Resample { to }) = decider.card().spec.length {
            warn(format!(
                "the model was trained on whole recordings resampled to {to} readings; a window is the last {to} readings as \
                 they come"
            ));
        }
        let page = self.serve.open()?;
        let readings = start(self.source(), self.setup(&decider), |text| warn(text))?;
        let mut answering = Answering {
            stamps: Stamps::new(decider.ticks()),
            writer: DecisionWriter::new(decider.card(), sets),
            summary: StreamSummary::new(decider.card()),
            rate_compared: false,
            no_contact_said: false,
            no_tare_said: false,
            tared: vec![],
            far: vec![],
            first: None,
            line: vec![],
            live: page.map(|page| LiveStream::new(page, &decider, &self.source_name(), self.early)),
        };
        let how = answering.run(&mut decider, &readings, &cancel);
        let (ended, error) = match how {
            Ok(End::Input) => ("input", None),
            Ok(End::Signal) => ("signal", None),
            Ok(End::Output) => ("output", None),
            Err(error) => ("error", Some(error)),
        };
        if let Some(live) = &answering.live {
            live.end(ended);
        }
        let counted = readings.counted();
        if decider.waits_in_vain() {
            warn(
                "--contact: no value has a level at rest above 0, so that no contact was seen; say --full-scale",
            );
        } else if counted.readings > 0 && counted.readings < decider.ticks() as u64 {
            let (came, ticks) = (counted.readings, decider.ticks());
            warn(format!("{came} readings came, a window has {ticks}; --early decides before it is full"));
        }
        // A stream that could not begin has no summary.
        if error.is_none() || counted.readings > 0 {
            answering.summary.write(&counted, decider.contacts(), ended)?;
        }
        error.map_or(Ok(ExitCode::SUCCESS), Err)
    }

    fn options(&self, unknown: f32) -> StreamOptions {
        StreamOptions {
            unknown,
            interval: None,
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
            tare: self.tare_steps,
        }
    }

    /// Returns how many first readings are at rest: none where the array of the training is there again.
    fn tare(&self, card: &Card) -> Option<usize> {
        let is_read = card.spec.tare.as_ref().is_some_and(|tare| tare.array().is_some());
        if is_read && self.tare_steps.is_none() && !self.source().has_lines() {
            Some(0)
        } else {
            self.tare_steps
        }
    }

    /// Says what is known of early decisions, if some are asked for.
    fn say_how_sure(&self, card: &Card) {
        let Some(early) = self.early else { return };
        match &card.certainty {
            Some(certainty) if !certainty.tenths.is_empty() => {
                let Some(record) = certainty.early_at(f64::from(early)) else { return };
                let of = record.of;
                if record.decided == 0 {
                    warn(format!(
                        "--early {early}: none of {of} samples that training had not seen was decided early"
                    ));
                } else if record.least > record.confidence {
                    detail(format!(
                        "--early {early} waits for a probability of {:.3}: less sure answers to beginnings were wrong too often",
                        record.least
                    ));
                }
            }
            _ => warn(format!(
                "--early {early}: the model is not calibrated on beginnings, and may be surer of them than it should; fit it \
                 from a run folder that has its models"
            )),
        }
    }

    fn source(&self) -> StreamSource {
        #[cfg(feature = "serial")]
        if let Some(port) = &self.port.serial {
            return StreamSource::Serial { port: port.clone(), baud: self.port.baud };
        }
        self.input.clone().map_or(StreamSource::Input, StreamSource::Path)
    }

    /// Returns the name of the source, for people.
    fn source_name(&self) -> String {
        match self.source() {
            StreamSource::Input => "standard input".into(),
            StreamSource::Path(path) => path.display().to_string(),
            #[cfg(feature = "lab")]
            StreamSource::Bag(path) => path.display().to_string(),
            #[cfg(feature = "serial")]
            StreamSource::Serial { port, .. } => port,
        }
    }

    fn setup(&self, decider: &Decider) -> SourceSettings {
        let card = decider.card();
        let spec = card.spec.clone();
        let path = self.input.as_deref();
        let bags = path.is_some_and(taxel::data::are_bags);
        // As `taxel predict` reads recordings, but each at its full length.
        let options = ReadOptions {
            resize: path.and_then(|path| resize(path, &spec)),
            attributes: attributes(card),
            layout: Some(spec.layout),
            topics: if bags { spec.topics.clone() } else { vec![] },
            table: spec.table.clone().unwrap_or_default(),
            channel_names: spec.channel_names.clone(),
            tare: spec.tare.clone().filter(|_| self.tare(card) == Some(0)),
            ..ReadOptions::default()
        };
        SourceSettings {
            columns: LineColumns::new(&spec, self.stamps.time.clone(), self.stamps.clock),
            pace: if self.pace == Speed::Rate { Pace::Rate } else { Pace::Fast },
            rate: self.rate,
            as_is: self.as_is,
            options,
            spec,
        }
    }
}

/// A stream that is being predicted.
struct Answering {
    stamps: Stamps,
    writer: DecisionWriter,
    summary: StreamSummary,
    /// Whether the rate was compared with the model's.
    rate_compared: bool,
    /// Whether it was said that no contact can be seen.
    no_contact_said: bool,
    /// Whether it was said that nothing is taken off.
    no_tare_said: bool,
    /// A time step less the level at rest.
    tared: Vec<f32>,
    /// Channels of which a value far outside the training's was said.
    far: Vec<usize>,
    /// Time at which the first time step came.
    first: Option<Instant>,
    /// A decision as it is written.
    line: Vec<u8>,
    live: Option<LiveStream>,
}

impl Answering {
    /// Predicts until the stream ends.
    fn run(
        &mut self,
        decider: &mut Decider,
        readings: &ReadingStream,
        cancel: &AtomicBool,
    ) -> Result<End, Box<dyn std::error::Error>> {
        let mut out = std::io::BufWriter::new(std::io::stdout().lock());
        loop {
            if cancel.load(Ordering::Relaxed) {
                return ended(out.flush(), End::Signal);
            }
            let next = match readings.waiting() {
                // While nothing waits, the reader gets the decisions so far.
                Next::Quiet => {
                    if let gone @ (Ok(End::Output) | Err(_)) = ended(out.flush(), End::Input) {
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
                    self.writer.recording = Some(name);
                }
                Next::Tare => {
                    if !decider.tare() && !std::mem::replace(&mut self.no_tare_said, true) {
                        warn("tare: the model reads what the sensor gives, so nothing is taken off");
                    }
                }
                Next::Reading(arrival) => {
                    let written = self.reading(decider, &arrival, &mut out);
                    readings.give_back(arrival.values);
                    if let gone @ (Ok(End::Output) | Err(_)) = ended(written, End::Input) {
                        return gone;
                    }
                }
                Next::End(how) => {
                    let flushed = ended(out.flush(), End::Input);
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
        let event = self.event(arrival);
        if event == Event::Repeated {
            self.summary.event(event, false);
            return Ok(());
        }
        if self.is_torn(decider, event) {
            decider.anew();
        }
        if !self.no_contact_said && decider.waits_in_vain() {
            self.no_contact_said = true;
            warn(
                "--contact: no value has a level at rest above 0, so that no contact can be seen; say --full-scale",
            );
        }
        self.say_far_values(decider, &arrival.values);
        let time = arrival.stamp.unwrap_or_else(|| (arrival.at - first).as_secs_f64());
        if let Some(live) = &mut self.live {
            live.reading(&arrival.values, time, arrival.lost);
        }
        let Some(decision) = decider.push(&arrival.values) else { return Ok(()) };
        let latency = arrival.at.elapsed();
        self.summary.decided(&decision, latency);
        self.line.clear();
        self.writer.write(&decision, time, latency, &mut self.line)?;
        if let Some(live) = &mut self.live {
            live.decided(&self.line);
        }
        out.write_all(&self.line)
    }

    /// Says each channel once that has a value far outside those of the training.
    fn say_far_values(&mut self, decider: &Decider, values: &[f32]) {
        let card = decider.card();
        // Ranges are those of tared readings.
        let Some(values) = decider.tared(values, &mut self.tared) else { return };
        for outside in card.trained_on.ranges.outside(values) {
            if self.far.contains(&outside.channel) {
                continue;
            }
            self.far.push(outside.channel);
            let words = outside.words(&card.spec.channel_names);
            warn(format!("{words}: far outside those of the training; compare unit, full scale and sensor"));
        }
    }

    /// Returns what the time stamp of a time step says.
    fn event(&mut self, arrival: &Arrival) -> Event {
        match arrival.stamp {
            Some(stamp) => self.stamps.push(stamp),
            None if arrival.lost > 0 => Event::Gap(arrival.lost),
            None => Event::Steady,
        }
    }

    /// Checks whether so many time steps are missing before one that the window begins anew.
    fn is_torn(&mut self, decider: &Decider, event: Event) -> bool {
        let anew = self.stamps.begins_anew(event);
        self.summary.event(event, anew);
        if let (Some(found), Some(rate), false) =
            (self.stamps.rate(), decider.card().spec.rate, self.rate_compared)
        {
            self.rate_compared = true;
            if (found / rate - 1.0).abs() > OFF {
                warn(format!("readings come at {found:.1} Hz, the model has learned them at {rate} Hz"));
            }
        }
        anew
    }
}

/// Returns how a stream goes on after writing: it ends where nobody reads.
fn ended(written: std::io::Result<()>, otherwise: End) -> Result<End, Box<dyn std::error::Error>> {
    match written {
        Ok(()) => Ok(otherwise),
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(End::Output),
        Err(e) => Err(unwritable(&e).into()),
    }
}
