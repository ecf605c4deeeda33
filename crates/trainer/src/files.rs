//! Files that are whole or not there, and the lock on a run folder.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use taxel_data::PART;

use crate::error::{Error, Result};

/// Name of the lock file.
const LOCK: &str = ".lock";

/// Writes a file that is whole or not there.
pub(crate) fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    taxel_data::write_whole(path, bytes).map_err(|e| Error::io(path, "written", e))
}

/// Whether a folder holds nothing but what a killed process leaves before its first file.
pub(crate) fn is_empty(folder: &Path) -> Result<bool> {
    let io = |e| Error::io(folder, "read", e);
    for entry in fs::read_dir(folder).map_err(io)? {
        let name = entry.map_err(io)?.file_name();
        let name = name.to_string_lossy();
        if name != LOCK && !name.ends_with(PART) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Held while a process writes to a run folder; given back when dropped.
#[derive(Debug)]
pub(crate) struct Lock {
    path: PathBuf,
}

impl Lock {
    /// Takes the folder, also from a process that died with it.
    pub fn take(folder: &Path) -> Result<Self> {
        let path = folder.join(LOCK);
        // Twice: once more after a dead process's lock is gone.
        for _ in 0..2 {
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(mut file) => {
                    let written = write!(file, "{}", std::process::id()).and_then(|()| file.sync_all());
                    written.map_err(|e| Error::io(&path, "written", e))?;
                    return Ok(Lock { path });
                }
                Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {
                    let holder = fs::read_to_string(&path).unwrap_or_default();
                    if !is_dead(holder.trim()) {
                        return Err(Error::folder(folder, held_by(holder.trim())));
                    }
                    fs::remove_file(&path).map_err(|e| Error::io(&path, "removed", e))?;
                }
                Err(e) => return Err(Error::io(&path, "created", e)),
            }
        }
        Err(Error::folder(folder, held_by("another")))
    }
}

fn held_by(holder: &str) -> String {
    format!(
        "process {holder} is writing to this run folder ({LOCK}); wait for it, give another --out, or delete \
         the lock file if no such process runs"
    )
}

/// Whether a process is known to be gone; only Linux can tell.
fn is_dead(holder: &str) -> bool {
    let is_pid = holder.parse::<u32>().is_ok();
    cfg!(target_os = "linux") && is_pid && !Path::new("/proc").join(holder).exists()
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Nothing is lost if this fails: the next process sees that this one is gone.
        let _ = fs::remove_file(&self.path);
    }
}
