//! Where `taxel record` records from.

use std::path::Path;

use taxel::data::is_bag;
use taxel::stream::StreamSource;

use super::sensor::SourceKind;

/// Returns the source that `--input`, or else standard input, names; its name in messages, and how readings come. A `topic` and
/// options of stamps have to suit it.
///
/// # Errors
/// No source, a file that is neither lines nor a bag, options that it has no use for.
pub fn source(
    input: Option<&str>,
    topic: Option<&str>,
    has_stamp_options: bool,
) -> Result<(StreamSource, String, SourceKind), String> {
    let bag = input.filter(|path| is_bag(Path::new(path)));
    if let (Some(topic), None) = (topic, bag) {
        return Err(format!("--topic {topic}: is of a bag, and the source is none; say --input FILE.mcap"));
    }
    if let (Some(path), true) = (bag, has_stamp_options) {
        return Err(format!(
            "--time and --clock are of lines, and messages of {path} bear their time; leave them out"
        ));
    }
    match input {
        None => Err("nothing to record from; say --serial PORT, or --input - for standard input".into()),
        Some("-") => Ok((StreamSource::Input, "standard input".into(), SourceKind::Pipe)),
        #[cfg(feature = "lab")]
        Some(path) if bag.is_some() => Ok((StreamSource::Bag(path.into()), path.into(), SourceKind::File)),
        Some(path) => {
            let source = StreamSource::Path(path.into());
            if !source.has_lines() {
                return Err(format!(
                    "{path}: is no file of lines (.csv, .txt, .jsonl), so its recordings have classes and lengths \
                     already; read it as it is: taxel data check {path}"
                ));
            }
            Ok((source, path.into(), SourceKind::File))
        }
    }
}
