//! Where readings come from, and the thread that reads them.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use taxel_data::{ReadOptions, SampleSpec, whole_recordings};

use crate::columns::Columns;
use crate::error::{Error, Result};
use crate::pace::{Pace, Pacer};
use crate::queue::{Feed, Stream, queue};
use crate::replay::Replay;
use crate::text::Text;

/// Endings of files that hold lines; others are recordings.
const LINES: [&str; 7] = ["csv", "tsv", "txt", "log", "json", "jsonl", "ndjson"];

/// Where readings come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// Lines from standard input.
    Input,
    /// A file, or a folder: lines of a text file, recordings of anything else that can be read.
    Path(PathBuf),
    /// A serial port that sends lines.
    #[cfg(feature = "serial")]
    Serial {
        /// Where the port is.
        port: String,
        /// Bits per second.
        baud: u32,
    },
}

/// What is known of the readings.
#[derive(Debug, Clone)]
pub struct Told {
    /// What the model reads.
    pub spec: SampleSpec,
    /// What the numbers of a line are.
    pub columns: Columns,
    /// How fast files are replayed.
    pub pace: Pace,
    /// Readings per second of what bears no time stamps. Default what the model says.
    pub rate: Option<f64>,
    /// How recordings are read.
    pub options: ReadOptions,
}

type Work = Box<dyn FnOnce(&mut Feed) -> Result<()> + Send>;

/// Opens a source and reads it on a thread of its own. `say` hears what is odd in it, once of each kind.
///
/// What comes from standard input and from files waits where answers are slower than readings, and nothing is lost; what
/// comes at a rate of its own (a serial port, [`Pace::Rate`]) is dropped when the queue is full, and counted.
///
/// # Errors
/// A source that cannot be opened, recordings that cannot be read.
pub fn start(source: Source, told: Told, say: impl Fn(&str) + Send + 'static) -> Result<Stream> {
    let each = told.columns.each();
    let (drops, work): (bool, Work) = match source {
        Source::Input => (false, lines(std::io::stdin(), "standard input".into(), told, None, say)),
        #[cfg(feature = "serial")]
        Source::Serial { port, baud } => {
            let from = crate::serial::open(&port, baud)?;
            (true, lines(from, port, told, None, say))
        }
        Source::Path(path) if holds_lines(&path) => {
            let label = path.display().to_string();
            let why = |e: std::io::Error| Error::Source { source_label: label.clone(), why: e.to_string() };
            let file = File::open(&path).map_err(why)?;
            let (pace, rate) = (told.pace, told.rate.or(told.spec.rate));
            (pace == Pace::Rate, lines(file, label, told, Some((pace, rate)), say))
        }
        Source::Path(path) => {
            let recordings = whole_recordings(&path, &told.options, told.spec.layout.rank())?;
            let drops = told.pace == Pace::Rate;
            let work = move |feed: &mut Feed| {
                let rate = told.rate.or(told.spec.rate);
                let (label, pacer) = (path.display().to_string(), Pacer::new(told.pace));
                Replay { label, spec: told.spec, pacer, rate, say: &say }.feed(&recordings, feed)
            };
            (drops, Box::new(work))
        }
    };
    let (mut feed, stream) = queue(each, drops);
    let run = move || {
        let how = work(&mut feed);
        feed.end(how);
    };
    let thread = std::thread::Builder::new().name("readings".into()).spawn(run);
    thread.map_err(|e| Error::Source {
        source_label: "a thread".into(),
        why: format!("cannot be started: {e}"),
    })?;
    Ok(stream)
}

/// Reads lines; `replayed` says how fast and at which rate those of a file.
fn lines(
    from: impl Read + Send + 'static,
    label: String,
    told: Told,
    replayed: Option<(Pace, Option<f64>)>,
    say: impl Fn(&str) + Send + 'static,
) -> Work {
    let (pace, rate) = replayed.unwrap_or((Pace::Fast, None));
    Box::new(move |feed: &mut Feed| {
        let text = Text { label, columns: told.columns, pacer: Pacer::new(pace), rate, say: &say };
        text.feed(from, feed)
    })
}

fn holds_lines(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| LINES.contains(&ending.as_str())) && !path.is_dir()
}
