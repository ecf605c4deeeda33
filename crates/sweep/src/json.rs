//! Small JSON files, whole or not there.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

pub(crate) fn write(path: &Path, value: &impl Serialize) -> Result<()> {
    let text =
        serde_json::to_string(value).map_err(|e| Error::file(path, format!("cannot be encoded: {e}")))?;
    taxel_files::write_whole(path, format!("{text}\n").as_bytes()).map_err(|e| Error::io(path, "written", e))
}

/// `None` where there is no such file.
pub(crate) fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    let text = match std::fs::read(path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(Error::io(path, "read", e)),
    };
    let damaged = |e| Error::file(path, format!("cannot be read: {e}; delete it and run its trial again"));
    serde_json::from_slice(&text).map(Some).map_err(damaged)
}
