//! Where `taxel record` records from.

use std::io::IsTerminal;
use std::path::Path;

use taxel::data::is_bag;
use taxel::stream::StreamSource;

use super::sensor::SourceKind;
use super::{Record, Start};

impl Record {
    /// Returns the source, its name in messages, and how readings come.
    pub(super) fn source(&self) -> Result<(StreamSource, String, SourceKind), String> {
        let bag = self.input.as_deref().filter(|path| is_bag(Path::new(path)));
        if let (Some(topic), None) = (&self.topic, bag) {
            return Err(format!(
                "--topic {topic}: is of a bag, and the source is none; say --input FILE.mcap"
            ));
        }
        #[cfg(feature = "serial")]
        if let Some(port) = &self.port.serial {
            return Ok((
                StreamSource::Serial { port: port.clone(), baud: self.port.baud },
                port.clone(),
                SourceKind::Port,
            ));
        }
        match self.input.as_deref() {
            None => Err("nothing to record from; say --serial PORT, or --input - for standard input".into()),
            Some("-") => Ok((StreamSource::Input, "standard input".into(), SourceKind::Pipe)),
            #[cfg(feature = "lab")]
            Some(path) if bag.is_some() => {
                if self.stamps.time.is_some() || self.stamps.clock.is_some() {
                    return Err(format!(
                        "--time and --clock are of lines, and messages of {path} bear their time; leave them out"
                    ));
                }
                Ok((StreamSource::Bag(path.into()), path.into(), SourceKind::File))
            }
            Some(path) => {
                let source = StreamSource::Path(path.into());
                if !source.has_lines() {
                    return Err(format!(
                        "{path}: is no file of lines (.csv, .txt, .jsonl) and no bag, so its recordings have classes and lengths already; read \
                         it as it is: taxel data check {path}"
                    ));
                }
                Ok((source, path.into(), SourceKind::File))
            }
        }
    }

    /// Checks whether a person starts each recording.
    pub(super) fn with_keys(&self, source: &StreamSource) -> Result<bool, String> {
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
}
