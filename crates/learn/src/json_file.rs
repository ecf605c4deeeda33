//! JSON files, whole or not at all.

use std::fs;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use taxel_base::files::write_whole;

use crate::error::{Error, Result};

/// Checks whether a value is the default, which goes without saying: it is left out of files, which then say what
/// they always said.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Writes a file that is whole or not there.
pub(crate) fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    write_whole(path, bytes).map_err(|e| Error::io(path, "written", e))
}

/// Writes `value` as indented JSON and hands back what a later reader will see.
pub(crate) fn write_json<T: Serialize + DeserializeOwned>(path: &Path, value: &T, pretty: bool) -> Result<T> {
    let damaged = |e: serde_json::Error| Error::damaged(path, format!("cannot be encoded: {e}"));
    let mut text = if pretty { serde_json::to_string_pretty(value) } else { serde_json::to_string(value) }
        .map_err(damaged)?;
    text.push('\n');
    write_atomic(path, text.as_bytes())?;
    // JSON may round the last digit of a number: with this, fresh and resumed runs agree to the byte.
    serde_json::from_str(&text).map_err(damaged)
}

/// Reads a JSON file; `None` where there is no such file.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(Error::io(path, "read", e)),
    };
    serde_json::from_str(&text)
        .map(Some)
        .map_err(|e| Error::damaged(path, format!("cannot be read: {e}; delete it and resume the run")))
}
