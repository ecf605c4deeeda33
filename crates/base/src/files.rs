//! Files that are whole or not there: the one way in which the project writes a file.
//!
//! ```
//! use std::io::Write;
//! use taxel_base::files::{Part, write_whole};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("results.json");
//! write_whole(&path, b"[1, 2]")?;
//!
//! // Writing that ends early leaves what was there.
//! let mut part = Part::create(&path)?;
//! part.write_all(b"[3, ")?;
//! drop(part);
//! assert_eq!(std::fs::read(&path)?, b"[1, 2]");
//! assert_eq!(std::fs::read_dir(folder.path())?.count(), 1);
//! # Ok::<(), std::io::Error>(())
//! ```

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, TempPath};

/// Ending of a file that is being written, or that a killed process has left.
pub const PART: &str = ".part";

/// Returns whether `name` is that of a half-written file.
pub fn is_part(name: &OsStr) -> bool {
    name.as_encoded_bytes().ends_with(PART.as_bytes())
}

/// Removes what killed processes have left of the file at `path`. What a living process writes is locked and stays.
///
/// # Errors
///
/// Returns the system's error if the folder cannot be listed or a file not removed.
pub fn remove_parts(path: &Path) -> io::Result<()> {
    let (Some(name), Ok(entries)) = (path.file_name(), fs::read_dir(folder_of(path))) else { return Ok(()) };
    let before = part_prefix(name);
    for entry in entries {
        let entry = entry?;
        let other = entry.file_name();
        if !is_part(&other) || !other.as_encoded_bytes().starts_with(before.as_encoded_bytes()) {
            continue;
        }
        // The lock is held until the file is gone: a writer that has just created it sees that and takes another.
        let Ok(part) = File::open(entry.path()) else { continue };
        if part.try_lock().is_ok() {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Creates a file that [`remove_parts`] of another process leaves alone.
fn create_locked(at: &Path) -> io::Result<File> {
    let file = File::create_new(at)?;
    match file.lock() {
        // tempfile goes on with another name.
        Ok(()) if !at.exists() => Err(io::ErrorKind::AlreadyExists.into()),
        // A file system without locks still writes files.
        _ => Ok(file),
    }
}

fn part_prefix(name: &OsStr) -> OsString {
    let mut prefix = name.to_owned();
    prefix.push(".");
    prefix
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes `bytes` to a temporary file in the same folder, flushes it to disk, then renames it: no reader sees half a
/// file, and of two processes that write at once the later wins. A link is followed. A device or a pipe cannot be
/// replaced and gets the bytes themselves.
///
/// # Errors
///
/// What the system says.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_piecewise(path, |file| file.write_all(bytes))
}

/// As [`write_whole`], without waiting for the disk: a killed process leaves the file whole or not there, a power
/// cut may leave it empty. For what can be done without.
///
/// # Errors
///
/// What the system says.
pub fn write_unflushed(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut part = Part::create(path)?;
    part.write_all(bytes)?;
    part.rename()
}

/// As [`write_whole`], for a file that is too long to be held in memory: `pieces` writes it.
///
/// # Errors
///
/// What the system or `pieces` says.
pub fn write_piecewise<E: From<io::Error>>(
    path: &Path,
    pieces: impl FnOnce(&mut Part) -> Result<(), E>,
) -> Result<(), E> {
    let mut part = Part::create(path)?;
    pieces(&mut part)?;
    Ok(part.finish()?)
}

/// A file that is being written under another name. It gets its own by [`Part::finish`]; dropped before, it is
/// removed.
#[derive(Debug)]
pub struct Part {
    file: BufWriter<File>,
    /// The name it has now and the one it gets; none of a device.
    names: Option<(TempPath, PathBuf)>,
}

impl Part {
    /// Begins the file that will be at `path`, or behind the link there; a device or a pipe is opened itself.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn create(path: &Path) -> io::Result<Self> {
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        if fs::metadata(&path).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
            let device = OpenOptions::new().write(true).open(&path)?;
            return Ok(Part { file: BufWriter::new(device), names: None });
        }
        let prefix = part_prefix(path.file_name().unwrap_or_default());
        // `create_new` gives the permissions of any new file, where tempfile's own are the user's alone.
        let temporary =
            Builder::new().prefix(&prefix).suffix(PART).make_in(folder_of(&path), create_locked)?;
        let (file, part) = temporary.into_parts();
        Ok(Part { file: BufWriter::new(file), names: Some((part, path)) })
    }

    /// Flushes what was written to disk and gives the file its name.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn finish(mut self) -> io::Result<()> {
        self.file.flush()?;
        let Some((_, path)) = &self.names else { return Ok(()) };
        let path = path.clone();
        self.file.get_ref().sync_all()?;
        self.rename()?;
        sync_folder(&path)
    }

    fn rename(mut self) -> io::Result<()> {
        self.file.flush()?;
        match self.names.take() {
            Some((part, path)) => part.persist(path).map_err(|error| error.error),
            None => Ok(()),
        }
    }
}

impl Write for Part {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Flushes the folder that a file was renamed in, so that the new name survives a power cut.
///
/// # Errors
///
/// What the system says.
pub fn sync_folder(path: &Path) -> io::Result<()> {
    match path.parent() {
        // Other systems cannot open a folder.
        Some(folder) if cfg!(unix) && !folder.as_os_str().is_empty() => File::open(folder)?.sync_all(),
        _ => Ok(()),
    }
}
