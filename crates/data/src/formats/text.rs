//! Reads whole text files, and tables in them.

use crate::options::Limits;
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Reads a text file, refusing large and non-UTF-8 ones.
pub(crate) fn read_text(path: &Path, limits: &Limits) -> Result<String> {
    let file = path.display().to_string();
    let reader = File::open(path).map_err(Error::io(path))?;
    let mut bytes = Vec::new();
    let limit = limits.max_file_bytes;
    reader.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(Error::io(path))?;
    if bytes.len() as u64 > limit {
        // A stream has no length: at least one byte more than allowed came.
        let bytes = path.metadata().map_or(limit + 1, |data| data.len());
        let why = format!("has {bytes} bytes, more than the {limit} allowed; raise limits.max-file-bytes");
        return Err(Error::file(file, why));
    }
    if bytes.is_empty() {
        return Err(Error::EmptyFile { file });
    }
    String::from_utf8(bytes).map_err(|e| {
        let byte = e.utf8_error().valid_up_to();
        Error::file(file, format!("byte {byte} is not UTF-8; save it as plain text"))
    })
}

/// Removes the mark of UTF-8 that some editors write before a text.
pub(crate) fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// Reads a table row by row; cells are trimmed, and without a header rows may have any number of them.
pub(crate) fn csv_reader(text: &str, separator: u8, has_header: bool) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .has_headers(has_header)
        .flexible(!has_header)
        .trim(csv::Trim::All)
        .delimiter(separator)
        .from_reader(without_mark(text).as_bytes())
}

/// Returns the line of a record, whose position is that of the blank lines before it.
pub(crate) fn line_of(text: &str, start: &csv::Position) -> u64 {
    let rest = &text.as_bytes()[start.byte() as usize..];
    let blank = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    start.line() + blank.filter(|byte| **byte == b'\n').count() as u64
}
