//! The lock on a run folder, and what killed processes leave in one.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;

use taxel_base::files::is_part;

use crate::error::{Error, Result};

/// Name of the lock file.
const LOCK: &str = ".lock";

/// Checks whether a folder holds nothing but what a killed process leaves before its first file.
pub(crate) fn is_empty(folder: &Path) -> Result<bool> {
    let io = |e| Error::io(folder, "read", e);
    for entry in fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        let name = entry.file_name();
        // The run folder's own sub-folders, made before its first file.
        let is_bare = ["folds", "models"].iter().any(|folder| name == *folder)
            && entry.path().is_dir()
            && is_empty(&entry.path())?;
        if name != LOCK && !is_part(&name) && !is_bare {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Held while a process writes to a run folder. The system gives it back when the process ends, however
/// it ends.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Takes the folder, unless another process has it.
    pub(crate) fn take(folder: &Path) -> Result<Self> {
        let path = folder.join(LOCK);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(|e| Error::io(&path, "created", e))?;
        match patiently(|| file.try_lock()) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                // Only for the message.
                let _ = file.read_to_string(&mut holder);
                let holder =
                    if holder.is_empty() { "another process".into() } else { format!("process {holder}") };
                let reason =
                    format!("{holder} is writing to this run folder; wait for it or give another folder");
                return Err(Error::folder(folder, reason));
            }
            Err(TryLockError::Error(e)) => return Err(Error::io(&path, "locked", e)),
        }
        let written = file
            .set_len(0)
            .and_then(|()| file.rewind())
            .and_then(|()| write!(file, "{}", std::process::id()))
            .and_then(|()| file.flush());
        written.map_err(|e| Error::io(&path, "written", e))?;
        Ok(Lock { _file: file })
    }
}

/// Asks again for a moment: a child that a process is just starting holds its locks until it has started.
fn patiently(
    lock: impl Fn() -> std::result::Result<(), TryLockError>,
) -> std::result::Result<(), TryLockError> {
    for _ in 0..10 {
        match lock() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(std::time::Duration::from_millis(20)),
            outcome => return outcome,
        }
    }
    lock()
}

/// Removes what killed processes have left half-written in `folder`; only for the holder of its lock.
pub(crate) fn sweep(folder: &Path) -> Result<()> {
    let io = |e| Error::io(folder, "read", e);
    for entry in fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        let path = entry.path();
        if is_part(&entry.file_name()) {
            fs::remove_file(&path).map_err(|e| Error::io(&path, "removed", e))?;
        }
    }
    Ok(())
}
