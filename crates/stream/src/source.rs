//! The sources of time steps, and the thread that reads them.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use taxel_base::FileError;
use taxel_data::{ReadOptions, Recording, RecordingFacts, SampleSpec, whole_recordings};

use crate::columns::LineColumns;
use crate::error::{Error, Result};
use crate::pace::{Pace, Pacer};
use crate::queue::{Feed, ReadingStream, queue};
use crate::replay::Replay;
use crate::text::Text;

/// Endings of files that hold lines; others are recordings.
const LINES: [&str; 7] = ["csv", "tsv", "txt", "log", "json", "jsonl", "ndjson"];

/// A source of time steps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StreamSource {
    /// Lines from standard input.
    Input,
    /// A file, or a folder: lines of a text file, recordings of anything else that can be read.
    Path(PathBuf),
    /// One topic of a bag, message after message, at the times at which they were recorded. The topics of the settings' options name it.
    #[cfg(feature = "mcap")]
    Bag(PathBuf),
    /// A serial port that sends lines.
    #[cfg(feature = "serial")]
    Serial {
        /// Where the port is.
        port: String,
        /// Bits per second.
        baud: u32,
    },
}

impl StreamSource {
    /// Checks whether lines come from it; others are recordings that can be read.
    pub fn has_lines(&self) -> bool {
        match self {
            StreamSource::Path(path) => holds_lines(path),
            #[cfg(feature = "mcap")]
            StreamSource::Bag(_) => false,
            _ => true,
        }
    }
}

/// How a source is read.
#[derive(Debug, Clone)]
pub struct SourceSettings {
    /// The sample that the model reads.
    pub spec: SampleSpec,
    /// Meaning of the numbers of a line.
    pub columns: LineColumns,
    /// How fast files are replayed.
    pub pace: Pace,
    /// Time steps per second where there are no time stamps. Default the model's.
    pub rate: Option<f64>,
    /// How recordings are read.
    pub options: ReadOptions,
    /// Whether recordings of another unit, rate, full scale, layout or bit depth than the training's are read all the same.
    pub as_is: bool,
}

type ReadLoop = Box<dyn FnOnce(&mut Feed) -> Result<()> + Send>;

/// Opens a source and reads it on a separate thread. `say` gets a warning of each kind once.
///
/// Standard input and files wait where predictions are slower than time steps, and nothing is lost. Time steps that come at a
/// fixed rate (a serial port, [`Pace::Rate`]) are dropped when the queue is full, and counted.
///
/// # Errors
/// A source that cannot be opened, recordings that cannot be read.
pub fn start(
    source: StreamSource,
    settings: SourceSettings,
    say: impl Fn(&str) + Send + 'static,
) -> Result<ReadingStream> {
    let each = settings.columns.each();
    let (drops, read_loop): (bool, ReadLoop) = match source {
        StreamSource::Input => {
            (false, lines(std::io::stdin(), "standard input".into(), settings, None, false, say))
        }
        #[cfg(feature = "serial")]
        StreamSource::Serial { port, baud } => {
            let from = crate::serial::open(&port, baud)?;
            (true, lines(from, port, settings, None, true, say))
        }
        StreamSource::Path(path) if holds_lines(&path) => {
            let label = path.display().to_string();
            let file = File::open(&path).map_err(|e| Error::from(FileError::io(&path, "read", &e)))?;
            let (pace, rate) = (settings.pace, settings.rate.or(settings.spec.rate));
            (pace == Pace::Rate, lines(file, label, settings, Some((pace, rate)), false, say))
        }
        #[cfg(feature = "mcap")]
        StreamSource::Bag(path) => {
            let messages = taxel_data::bag_messages(&path, &settings.options)?;
            let (label, pace, columns) = (path.display().to_string(), settings.pace, settings.columns);
            let read_loop = move |feed: &mut Feed| {
                crate::messages::feed(&label, &messages, &columns, Pacer::new(pace), &say, feed)
            };
            (pace == Pace::Rate, Box::new(read_loop))
        }
        StreamSource::Path(path) => {
            let rank = settings.spec.layout.rank();
            let (mut recordings, facts) = whole_recordings(&path, &settings.options, rank)?;
            facts.warnings.iter().for_each(|words| say(words));
            if !settings.as_is {
                convert(&path, &settings.spec, &facts, &mut recordings, &say)?;
            }
            let drops = settings.pace == Pace::Rate;
            let read_loop = move |feed: &mut Feed| {
                let rate = settings.rate.or(settings.spec.rate);
                let (label, pacer) = (path.display().to_string(), Pacer::new(settings.pace));
                Replay { label, spec: settings.spec, pacer, rate, say: &say }.feed(&recordings, feed)
            };
            (drops, Box::new(read_loop))
        }
    };
    let (mut feed, stream) = queue(each, drops);
    let run = move || {
        let how = read_loop(&mut feed);
        feed.end(how);
    };
    let thread = std::thread::Builder::new().name("readings".into()).spawn(run);
    thread.map_err(|e| Error::Source {
        source_label: "a thread".into(),
        why: format!("cannot be started: {e}"),
    })?;
    Ok(stream)
}

/// Brings recordings to the unit of the training.
///
/// # Errors
/// Facts in which they differ from the training's recordings.
fn convert(
    path: &Path,
    spec: &SampleSpec,
    facts: &RecordingFacts,
    recordings: &mut [Recording],
    say: impl Fn(&str),
) -> Result<()> {
    let comparison = spec.compare(facts);
    if let Some(differences) = comparison.refusal() {
        let how = "record as in training, correct what the files say, or predict all the same with --as-is";
        return Err(FileError::new(path, format!("{differences}; {how}")).into());
    }
    if let Some(unit) = comparison.unit {
        say(&format!("{}: values are converted {unit}", path.display()));
        let values = recordings.iter_mut().flat_map(|recording| &mut recording.values);
        values.for_each(|value| *value = unit.convert(*value));
    }
    Ok(())
}

/// Reads lines; `replayed` says how fast and at which rate those of a file, `begins_inside` whether the first may be the end
/// of one.
fn lines(
    from: impl Read + Send + 'static,
    label: String,
    settings: SourceSettings,
    replayed: Option<(Pace, Option<f64>)>,
    begins_inside: bool,
    say: impl Fn(&str) + Send + 'static,
) -> ReadLoop {
    let (pace, rate) = replayed.unwrap_or((Pace::Fast, None));
    Box::new(move |feed: &mut Feed| {
        let pacer = Pacer::new(pace);
        let text = Text { label, columns: settings.columns, pacer, rate, begins_inside, say: &say };
        text.feed(from, feed)
    })
}

fn holds_lines(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| LINES.contains(&ending.as_str())) && !path.is_dir()
}
