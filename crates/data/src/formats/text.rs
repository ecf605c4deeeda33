//! Reads whole text files, and tables in them.

use crate::options::Limits;
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Reads a text file in UTF-8, or in UTF-16 with its mark; refuses large ones and other encodings. The mark of the
/// encoding is no part of the text.
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
    decoded(bytes).map_err(|why| Error::file(file, why))
}

/// Decodes the bytes of a text file, or says why not and how to fix it.
pub(crate) fn decoded(mut bytes: Vec<u8>) -> Result<String, String> {
    const SAVE: &str = "save it as UTF-8 (in Excel as CSV UTF-8, in Python with encoding=\"utf-8\")";
    if bytes.starts_with(&[0xff, 0xfe, 0, 0]) || bytes.starts_with(&[0, 0, 0xfe, 0xff]) {
        return Err(format!("is UTF-32; {SAVE}"));
    }
    let wide = match bytes.get(..2) {
        Some([0xff, 0xfe]) => Some(u16::from_le_bytes as fn([u8; 2]) -> u16),
        Some([0xfe, 0xff]) => Some(u16::from_be_bytes as fn([u8; 2]) -> u16),
        _ => None,
    };
    if let Some(wide) = wide {
        let (pairs, rest) = bytes[2..].as_chunks::<2>();
        let text = char::decode_utf16(pairs.iter().map(|pair| wide(*pair))).collect::<Result<String, _>>();
        return match (text, rest) {
            (Ok(text), []) => Ok(text),
            _ => Err(format!("begins as UTF-16 and is damaged; copy it again, or {SAVE}")),
        };
    }
    while bytes.starts_with("\u{feff}".as_bytes()) {
        bytes.drain(..3);
    }
    if let Some(at) = bytes.iter().position(|byte| *byte == 0) {
        let why = "holds a zero byte, as UTF-16 without its mark and binary files do";
        return Err(format!("line {} {why}; {SAVE}", line_at(&bytes, at)));
    }
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let (line, byte) = (line_at(e.as_bytes(), at), e.as_bytes()[at]);
        format!("line {line} holds the byte 0x{byte:02X}, which is not UTF-8; {SAVE}")
    })
}

/// Returns the line of a byte, from 1.
fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count()
}

/// Returns the line of a record, whose position is that of the blank lines before it.
pub(crate) fn line_of(text: &str, start: &csv::Position) -> u64 {
    let rest = &text.as_bytes()[start.byte() as usize..];
    let blank = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    start.line() + blank.filter(|byte| **byte == b'\n').count() as u64
}

/// Reads a table row by row; cells are trimmed, and without a header rows may have any number of them.
pub(crate) fn csv_reader(text: &str, separator: u8, has_header: bool) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .has_headers(has_header)
        .flexible(!has_header)
        .trim(csv::Trim::All)
        .delimiter(separator)
        .from_reader(text.as_bytes())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::decoded;

    #[test]
    fn texts_are_decoded_by_their_mark() {
        let utf16 = |mark: [u8; 2], bytes: fn(u16) -> [u8; 2], text: &str| {
            [mark.to_vec(), text.encode_utf16().flat_map(bytes).collect()].concat()
        };
        for text in ["force,label\r\n1.5,weich\n", "é 東 \u{1f600}", ""] {
            assert_eq!(decoded(utf16([0xff, 0xfe], u16::to_le_bytes, text)).unwrap(), text);
            assert_eq!(decoded(utf16([0xfe, 0xff], u16::to_be_bytes, text)).unwrap(), text);
            assert_eq!(decoded(format!("\u{feff}{text}").into_bytes()).unwrap(), text);
            assert_eq!(decoded(format!("\u{feff}\u{feff}{text}").into_bytes()).unwrap(), text);
        }
    }

    #[test]
    fn other_encodings_are_refused_with_their_line_and_a_way_out() {
        for (bytes, why) in [
            (&b"a,b\n1,caf\xe9\n"[..], "line 2 holds the byte 0xE9, which is not UTF-8"),
            (b"a,b\n1,2\n\xc3", "line 3 holds the byte 0xC3"),
            (b"\xff\xfea\0\0", "begins as UTF-16 and is damaged"),
            (b"\xff\xfe\x00\xd8", "begins as UTF-16 and is damaged"),
            (b"\xff\xfe\0\0a\0\0\0", "is UTF-32"),
            (b"a\0,\0b\0", "line 1 holds a zero byte, as UTF-16 without its mark"),
        ] {
            let message = decoded(bytes.to_vec()).unwrap_err();
            assert!(message.contains(why) && message.contains("save it as UTF-8"), "{message}");
        }
    }
}
