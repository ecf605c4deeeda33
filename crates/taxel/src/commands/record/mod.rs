//! `taxel record`: from a sensor to a labelled data set.

mod faults;
mod files;
mod keys;
mod live;
mod opinion;
mod output;
mod plan;
mod recorder;
mod sensor;
mod set;
mod source;
mod take;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, ValueEnum, ValueHint};
use serde_json::json;
use taxel::stream::{LineColumns, Pace, SourceSettings, StreamSource, start};
use taxel::{Layout, ReadOptions, SampleSpec};

use crate::CommandResult;
#[cfg(feature = "serial")]
use crate::commands::arguments::lines::PortOptions;
use crate::commands::arguments::lines::StampOptions;
use crate::commands::arguments::output_format::OutputFormat;
use crate::live::ServeOptions;
use crate::terminal::interrupt::{INTERRUPTED, flag};
use crate::terminal::messages::{note, warn};
use faults::ChannelWatch;
use files::FileKind;
use keys::Keys;
use live::LiveRecording;
use opinion::Opinion;
use output::Printer;
use recorder::{Ended, Recorder};
use sensor::{Sensor, SensorFacts, SourceKind};
use set::{RecordedSet, SetFacts};

/// Time to write the last recording after a signal.
const GRACE: Duration = Duration::from_secs(10);
/// Exit code where the input ended before all recordings were there.
const TOO_FEW: u8 = 1;
/// Seconds of a recording where nobody says others.
const SECONDS: f64 = 3.0;
/// Readings at rest: at least, and in seconds.
const REST: (usize, f64) = (10, 0.25);
/// Most values of a recording.
const MOST: usize = 1 << 26;

/// Records a labelled data set from a sensor, in folders that every other command reads.
///
/// Each recording is one CSV file, `OUTPUT/LABEL/SESSION/001.csv`: time in seconds, then the channels under their names; or one MCAP
/// file, with --files mcap.
/// `labels.json` beside the folders holds the rate, the unit, the full scale and the names of the channels. Each call is a
/// session of its own unless --session names one; sessions are groups, so that a network is tested on one that it has not seen.
/// The same command goes on where it was stopped; channels, rate and length have to agree.
///
/// At a terminal, the next label is proposed and Enter starts: a countdown, the rest, then the touch. `u` throws the last recording
/// away, `s` begins another session, `q` ends, and the name of a label records that one. Labels come in blocks of all, each in a
/// random order (--seed). Where standard input is no terminal, or with --start now, recordings follow one another by themselves.
///
/// Values are kept as the sensor gives them. The first readings of a recording are at rest (--tare-steps): `labels.json` says so, their
/// mean is taken off when the data set is read, and `taxel stream` takes it off in the same way.
///
/// After each recording dead, stuck and clipped channels are named. A recording in which readings are missing is not kept, and neither
/// is the one under way at Ctrl-C, at SIGTERM or when the cable is pulled; all before stay as they are. Time stamps of the
/// sensor are used where there are some; a recording of uneven ones is brought to equal steps. Without them time is counted, at the
/// rate that was measured or that --rate says.
#[derive(Args)]
#[command(
    after_help = "Examples:  taxel record --serial /dev/ttyUSB0 --label cup --label bottle --seconds 3 --count 20 --output skin/
           taxel record --serial /dev/ttyUSB0 --output skin/ --model skin.safetensors
           taxel record --serial /dev/ttyUSB0 --output skin/ --serve 127.0.0.1:8000
           sensor | taxel record --input - --label cup --count 5 --output skin/ --format json
           taxel record --input drive.mcap --topic /skin --label cup --label bottle --output skin/ --files mcap
           taxel data check skin/"
)]
pub struct Record {
    /// The file to record from: lines, as `taxel stream` reads them, or a bag (.mcap); - for standard input.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::Other)]
    input: Option<String>,
    /// A topic of ROS 2 bags, or a field of one (/joint_states.effort) [default: the one that holds numbers].
    #[arg(long, value_name = "TOPIC")]
    topic: Option<String>,
    #[cfg(feature = "serial")]
    #[command(flatten)]
    port: PortOptions,
    /// A class to record; as often as needed [default: those in the folder].
    #[arg(long = "label", value_name = "LABEL")]
    labels: Vec<String>,
    /// Seconds of a recording, the rest before it not counted [default: 3, or as in the folder].
    #[arg(long, value_name = "SECONDS")]
    seconds: Option<f64>,
    /// Recordings of each label, those in the folder included.
    #[arg(long, value_name = "N", default_value_t = 20)]
    count: usize,
    /// The folder of the data set.
    #[arg(long, short, value_name = "FOLDER")]
    output: PathBuf,
    /// The files of recordings: CSV, or MCAP [default: csv, or as in the folder].
    #[arg(long, value_enum, value_name = "KIND")]
    files: Option<FileKind>,
    /// Name of the session [default: session-1, or the next one].
    #[arg(long, value_name = "NAME")]
    session: Option<String>,
    /// How recordings start: by a key, or one after the other [default: key at a terminal].
    #[arg(long, value_enum, value_name = "HOW")]
    start: Option<Start>,
    /// Seconds before each recording [default: 3 at a terminal, 0 otherwise].
    #[arg(long, value_name = "SECONDS")]
    pause: Option<f64>,
    /// First readings that are at rest, of each recording [default: a quarter of a second, at least 10].
    #[arg(long, value_name = "N")]
    tare_steps: Option<usize>,
    /// Records without readings at rest.
    #[arg(long, conflicts_with = "tare_steps")]
    no_tare: bool,
    /// Unit of the values, such as N or mV.
    #[arg(long, value_name = "UNIT")]
    unit: Option<String>,
    /// The largest possible value [default: not known]; a value there is clipped.
    #[arg(long, value_name = "VALUE")]
    full_scale: Option<f32>,
    /// Time steps per second where there are no time stamps [default: measured].
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    #[command(flatten)]
    stamps: StampOptions,
    /// The model that says after each recording what it takes it for.
    #[arg(long, value_name = "MODEL", value_hint = ValueHint::FilePath)]
    model: Option<PathBuf>,
    /// Seed of every random choice.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    serve: ServeOptions,
    #[command(flatten)]
    format: OutputFormat,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Start {
    Key,
    Now,
}

impl Record {
    pub fn run(self) -> CommandResult {
        let cancel = flag(GRACE)?;
        self.check()?;
        let (source, label, kind) = self.source()?;
        let with_keys = self.with_keys(&source)?;
        let mut set = RecordedSet::open(&self.output, self.session.as_deref())?;
        let labels = self.labels(&set)?;
        let (columns, channels) = LineColumns::any(self.stamps.time.clone(), self.stamps.clock);
        let settings = SourceSettings {
            spec: SampleSpec::new(Layout::Series, &[1, 1]),
            columns,
            pace: Pace::Fast,
            // Stamps that were counted would look like the sensor's.
            rate: None,
            options: ReadOptions { topics: self.topic.iter().cloned().collect(), ..ReadOptions::default() },
            as_is: false,
        };
        let page = self.serve.open()?;
        let stream = start(source, settings, |text| warn(text))?;
        let stopped = || cancel.load(std::sync::atomic::Ordering::Relaxed);
        let heard = Sensor::listen(stream, &channels, label, self.rate, kind, &stopped)?;
        let Some((mut sensor, found)) = heard else { return Ok(ExitCode::from(INTERRUPTED)) };
        let facts = set.agree(self.wanted(&found, &set)?)?.clone();
        sensor.arrange(&found, &facts.channels)?;
        self.say_sensor(&found, &facts);
        let opinion = self.model.as_ref().map(|path| Opinion::open(path, &facts)).transpose()?;
        let live = page.map(|page| LiveRecording::new(page, &self.output, &facts));
        let keys = with_keys.then(Keys::listen).transpose()?;
        let pause = self.pause.unwrap_or(if with_keys { 3.0 } else { 0.0 });
        let mut recorder = Recorder {
            watch: ChannelWatch::new(facts.channels.len(), facts.full_scale.map(|full| full as f32)),
            printer: Printer { is_json: self.format.is_json() },
            pause: Duration::from_secs_f64(pause),
            is_timed: kind != SourceKind::File && self.rate.is_none(),
            count: self.count,
            seed: self.seed,
            facts,
            set,
            sensor,
            kind,
            labels,
            keys,
            opinion,
            live,
            cancel,
        };
        let ended = recorder.run()?;
        self.end(&recorder, ended)
    }

    /// Refuses options outside their range.
    fn check(&self) -> Result<(), String> {
        let above_0 = |value: Option<f64>| value.is_none_or(|value| value > 0.0 && value.is_finite());
        if !above_0(self.rate) {
            return Err("--rate is in readings per second (Hz), above 0".into());
        }
        if !above_0(self.seconds) {
            return Err("--seconds is the length of a recording, above 0".into());
        }
        if !above_0(self.full_scale.map(f64::from)) {
            return Err("--full-scale is the largest possible value, above 0".into());
        }
        if self.pause.is_some_and(|pause| !(0.0..=3600.0).contains(&pause)) {
            return Err("--pause is in seconds, 0 to 3600".into());
        }
        if self.count == 0 {
            return Err("--count is the number of recordings of each label, from 1".into());
        }
        if self.tare_steps == Some(0) {
            return Err("--tare-steps is a number of readings, from 1; say --no-tare for none".into());
        }
        for (at, label) in self.labels.iter().enumerate() {
            check_name("--label", label)?;
            if let Some(other) =
                self.labels[..at].iter().find(|other| other.to_lowercase() == label.to_lowercase())
            {
                return Err(format!(
                    "--label {label}: {other:?} is a label already, and some systems take both for one folder"
                ));
            }
        }
        self.session.as_deref().map_or(Ok(()), |session| check_name("--session", session))
    }

    /// Returns the source, its name in messages, and how readings come.
    fn source(&self) -> Result<(StreamSource, String, SourceKind), String> {
        let has_stamps = self.stamps.time.is_some() || self.stamps.clock.is_some();
        #[cfg(feature = "serial")]
        if let (Some(port), None) = (&self.port.serial, &self.topic) {
            let source = StreamSource::Serial { port: port.clone(), baud: self.port.baud };
            return Ok((source, port.clone(), SourceKind::Port));
        }
        source::source(self.input.as_deref(), self.topic.as_deref(), has_stamps)
    }

    /// Checks whether a person starts each recording.
    fn with_keys(&self, source: &StreamSource) -> Result<bool, String> {
        let is_input = *source == StreamSource::Input;
        match self.start {
            Some(Start::Key) if is_input => Err(
                "--start key: standard input is the sensor, so keys cannot come from there; say --start now"
                    .into(),
            ),
            Some(start) => Ok(start == Start::Key),
            None => Ok(!is_input && std::io::stdin().is_terminal()),
        }
    }

    fn labels(&self, set: &RecordedSet) -> Result<Vec<String>, String> {
        let labels = if self.labels.is_empty() { set.labels() } else { self.labels.clone() };
        if labels.is_empty() {
            return Err("no label to record; say --label NAME for each class".into());
        }
        Ok(labels)
    }

    /// Returns the facts of the recordings to come, as the sensor and the options say them.
    fn wanted(&self, found: &SensorFacts, set: &RecordedSet) -> Result<SetFacts, String> {
        let known = set.facts();
        let rate = known.map_or(found.rate, |facts| facts.rate);
        let usual = || known.map_or(REST.0.max((REST.1 * rate).round() as usize), |facts| facts.rest);
        let rest = if self.no_tare { 0 } else { self.tare_steps.unwrap_or_else(usual) };
        let rows = match (self.seconds, known) {
            (None, Some(facts)) => facts.rows - facts.rest + rest,
            (seconds, _) => (seconds.unwrap_or(SECONDS) * rate).round() as usize + rest,
        };
        if rows - rest < 2 {
            let seconds = self.seconds.unwrap_or(SECONDS);
            return Err(format!(
                "--seconds {seconds}: holds less than two readings at {rate} Hz; say more seconds"
            ));
        }
        if rows.saturating_mul(found.channels.len()) > MOST {
            return Err(format!("--seconds: a recording would hold {rows} readings; say fewer seconds"));
        }
        Ok(SetFacts {
            channels: known.map_or_else(|| found.channels.clone(), |facts| facts.channels.clone()),
            rate: found.rate,
            unit: self.unit.clone(),
            full_scale: self.full_scale.map(f64::from),
            rows,
            rest,
            is_stamped: found.is_stamped,
            files: self.files.or(known.map(|facts| facts.files)).unwrap_or_default(),
        })
    }

    /// Says what was found at the source.
    fn say_sensor(&self, found: &SensorFacts, facts: &SetFacts) {
        let time = if found.is_stamped { "by its time stamps" } else { "counted" };
        let names = facts.channels.iter().take(8).cloned().collect::<Vec<_>>().join(", ");
        let more = if facts.channels.len() > 8 { ", ..." } else { "" };
        note(format!(
            "{} channels ({names}{more}) at {} Hz, {time}; a recording has {} readings, {} of them at rest",
            facts.channels.len(),
            facts.rate,
            facts.rows,
            facts.rest
        ));
        if let Some(said) = unnamed(found, facts) {
            note(said);
        }
        if !found.left_out.is_empty() {
            note(format!("no channels, they count lines: {}", found.left_out.join(", ")));
        }
    }

    /// Prints the summary; returns the exit code.
    fn end(&self, recorder: &Recorder, ended: Ended) -> CommandResult {
        let ((done, of), kept) = (recorder.progress(), recorder.set.kept.len());
        let (word, code) = match &ended {
            Ended::Complete => ("complete", 0),
            Ended::Wish => ("wish", 0),
            Ended::Signal => ("signal", INTERRUPTED),
            Ended::Input => ("input", TOO_FEW),
            Ended::Broken(_) => ("error", 2),
        };
        if let Some(live) = &recorder.live {
            live.end(word);
        }
        let folder = self.output.display();
        let counts: serde_json::Map<_, _> = recorder
            .labels
            .iter()
            .zip(recorder.set.counts(&recorder.labels))
            .map(|(label, count)| (label.clone(), json!(count)))
            .collect();
        let summary = json!({
            "ended": word, "recorded": kept, "recordings": counts, "of_each": self.count, "folder": self.output,
        });
        let next = if done < of { "the same command goes on" } else { "next: taxel data check, taxel run" };
        recorder
            .printer
            .summary(&summary, &format!("{folder}: {done} of {of} recordings, {kept} of them new; {next}"));
        match ended {
            Ended::Broken(why) => Err(why.into()),
            _ => Ok(ExitCode::from(code)),
        }
    }
}

/// Says which names channels have whose source names none: a header that was sent before this program listened is lost.
fn unnamed(found: &SensorFacts, facts: &SetFacts) -> Option<String> {
    if found.is_named {
        return None;
    }
    let names = match facts.channels.as_slice() {
        [first, .., last] => format!("{first} to {last}, in this order"),
        all => all.join(", "),
    };
    Some(format!(
        "the source names no channels, so they are {names}; a header that it sent before this program listened is lost: if it sends \
         one, begin this command first and start the sensor then"
    ))
}

/// Refuses a name that is no name of a folder on every system, or that readers would take for something else.
fn check_name(flag: &str, name: &str) -> Result<(), String> {
    let odd = |c: char| c.is_control() || r#"/\<>:"|?*"#.contains(c);
    let is_folder = !name.is_empty()
        && name.len() <= 120
        && !name.contains(odd)
        && Path::new(name).components().count() == 1;
    if is_folder && name.trim() == name && !name.starts_with('.') && !name.ends_with(['.', '~']) {
        return Ok(());
    }
    Err(format!(
        "{flag} {name:?}: is the name of a folder: at most 120 letters, no / \\ < > : \" | ? *, no point at either end"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_names_of_folders() {
        for good in ["cup", "soft cup", "Äpfel", "shore-00", "1"] {
            assert!(check_name("--label", good).is_ok(), "{good}");
        }
        for wrong in ["", " cup", "a/b", "..", ".hidden", "a\\b", "tab\t", "cup~", "cup.", &"x".repeat(121)] {
            assert!(check_name("--label", wrong).is_err(), "{wrong:?}");
        }
    }
}
