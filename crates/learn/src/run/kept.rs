//! Values in a folder, each under a digest of all that it depends on.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::json_file::{read_json, write_atomic};

/// A value with its whole digest: the name of its file holds a part of it.
#[derive(Serialize, Deserialize)]
struct Kept<T> {
    of: String,
    // Trainings without some classes were kept under this name.
    #[serde(alias = "without")]
    value: T,
}

/// Reads the value that `folder` keeps under the digest `of`.
///
/// # Errors
/// A damaged file.
pub fn read_kept<T: DeserializeOwned>(folder: &Path, of: &str) -> Result<Option<T>> {
    let kept: Option<Kept<T>> = read_json(&path(folder, of))?;
    Ok(kept.filter(|kept| kept.of == of).map(|kept| kept.value))
}

/// Keeps a value in `folder` under the digest `of`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_kept<T: Serialize>(folder: &Path, of: &str, value: &T) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "written", e))?;
    let path = path(folder, of);
    let text = serde_json::to_string(&Kept { of: of.into(), value });
    let text = text.map_err(|e| Error::damaged(&path, format!("cannot be encoded: {e}")))?;
    write_atomic(&path, text.as_bytes())
}

fn path(folder: &Path, of: &str) -> PathBuf {
    folder.join(format!("{}.json", of.get(..24).unwrap_or(of)))
}
