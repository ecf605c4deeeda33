//! Small JSON files, whole or not there.

use std::io;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

/// Writes a file that is flushed to disk before it gets its name.
pub(crate) fn write(path: &Path, value: &impl Serialize) -> Result<()> {
    put(path, value, taxel_base::files::write_whole)
}

/// Writes a file without flushing it: a power cut may leave it empty.
pub(crate) fn write_unflushed(path: &Path, value: &impl Serialize) -> Result<()> {
    put(path, value, taxel_base::files::write_unflushed)
}

fn put(path: &Path, value: &impl Serialize, write: fn(&Path, &[u8]) -> io::Result<()>) -> Result<()> {
    let text =
        serde_json::to_string(value).map_err(|e| Error::file(path, format!("cannot be encoded: {e}")))?;
    write(path, format!("{text}\n").as_bytes()).map_err(|e| Error::io(path, "written", e))
}

/// Reads a file; `None` where there is none.
pub(crate) fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    let Some(bytes) = bytes(path)? else { return Ok(None) };
    let damaged = |e| Error::file(path, format!("cannot be read: {e}; delete it and run its trial again"));
    serde_json::from_slice(&bytes).map(Some).map_err(damaged)
}

/// Reads a file; `None` where there is none.
pub(crate) fn bytes(path: &Path) -> Result<Option<Vec<u8>>> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(Error::io(path, "read", e)),
    }
}
