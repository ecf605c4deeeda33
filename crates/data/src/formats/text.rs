//! One text file, whole.

use crate::options::Limits;
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Reads a text file, refusing large and non-UTF-8 ones.
pub(crate) fn read_text(path: &Path, limits: &Limits) -> Result<String> {
    let file = path.display().to_string();
    let io = |e: std::io::Error| Error::Io { file: file.clone(), kind: e.kind() };
    let reader = File::open(path).map_err(io)?;
    let mut bytes = Vec::new();
    let limit = limits.max_file_bytes;
    reader.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > limit {
        // Of a stream without a length, at least one byte more than allowed came.
        let bytes = path.metadata().map_or(limit + 1, |data| data.len());
        return Err(Error::FileTooLarge { at: file, bytes, limit });
    }
    if bytes.is_empty() {
        return Err(Error::EmptyFile { file });
    }
    String::from_utf8(bytes).map_err(|e| Error::NotUtf8 { file, byte: e.utf8_error().valid_up_to() })
}
