//! Writes files that are whole or not there.
//!
//! ```
//! use std::io::Write;
//! use taxel_base::files::{PartFile, write_whole};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("results.json");
//! write_whole(&path, b"[1, 2]")?;
//!
//! // Writing that ends early leaves the old file.
//! let mut part = PartFile::create(&path)?;
//! part.write_all(b"[3, ")?;
//! drop(part);
//! assert_eq!(std::fs::read(&path)?, b"[1, 2]");
//! assert_eq!(std::fs::read_dir(folder.path())?.count(), 1);
//! # Ok::<(), std::io::Error>(())
//! ```

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, TempPath};

/// Ending of a file that is being written, or that a killed process has left.
pub const PART: &str = ".part";

/// Checks whether `name` is that of a half-written file.
pub fn is_part(name: &OsStr) -> bool {
    name.as_encoded_bytes().ends_with(PART.as_bytes())
}

/// Reads a text that a person wrote, of at most `limit` bytes. A device or pipe without an end is not read to its end.
///
/// # Errors
///
/// Returns the system's error, or `InvalidData` for a longer text or one that is not UTF-8.
pub fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(limit + 1).read_to_string(&mut text)?;
    if text.len() as u64 > limit {
        let problem = format!("it holds more than {limit} bytes; is this the right file?");
        return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
    }
    Ok(text)
}

/// Reads all bytes of a regular file; a device or pipe without an end would fill the memory.
///
/// # Errors
///
/// Returns the system's error, or `InvalidInput` for what is no regular file.
pub fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    if !file.metadata()?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no regular file; copy it to one"));
    }
    let mut bytes = vec![];
    BufReader::new(file).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Removes half-written files that killed processes have left of the file at `path`. Those of living processes are locked
/// and stay. A folder that cannot be opened holds none.
///
/// # Errors
///
/// Returns the system's error if the folder cannot be read further or a file not removed.
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
            match fs::remove_file(entry.path()) {
                // Its writer has just given it its name.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                outcome => outcome?,
            }
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
/// The error of the system.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_piecewise(path, |file| file.write_all(bytes))
}

/// Writes a file as [`write_whole`], without waiting for the disk: a killed process leaves it whole or not there, a power cut
/// may leave it empty. For files that are not essential.
///
/// # Errors
///
/// The error of the system.
pub fn write_unflushed(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut part = PartFile::create(path)?;
    part.write_all(bytes)?;
    part.rename()
}

/// Writes a file as [`write_whole`] that is too long for memory: `pieces` writes it.
///
/// # Errors
///
/// The error of the system or of `pieces`.
pub fn write_piecewise<E: From<io::Error>>(
    path: &Path,
    pieces: impl FnOnce(&mut PartFile) -> Result<(), E>,
) -> Result<(), E> {
    let mut part = PartFile::create(path)?;
    pieces(&mut part)?;
    Ok(part.finish()?)
}

/// A file that is being written under another name. [`PartFile::finish`] gives it its name; dropped before, it is
/// removed.
#[derive(Debug)]
pub struct PartFile {
    file: BufWriter<File>,
    /// Its temporary and its final name; none of a device.
    names: Option<(TempPath, PathBuf)>,
}

impl PartFile {
    /// Begins the file that will be at `path`, or behind the link there; a device or a pipe is opened itself.
    ///
    /// # Errors
    ///
    /// The error of the system.
    pub fn create(path: &Path) -> io::Result<Self> {
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        if fs::metadata(&path).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
            let device = OpenOptions::new().write(true).open(&path)?;
            return Ok(PartFile { file: BufWriter::new(device), names: None });
        }
        let prefix = part_prefix(path.file_name().unwrap_or_default());
        // `create_new` gives the permissions of any new file, where tempfile's own are the user's alone.
        let temporary =
            Builder::new().prefix(&prefix).suffix(PART).make_in(folder_of(&path), create_locked)?;
        let (file, part) = temporary.into_parts();
        Ok(PartFile { file: BufWriter::new(file), names: Some((part, path)) })
    }

    /// Flushes the file to disk and gives it its name.
    ///
    /// # Errors
    ///
    /// The error of the system.
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

impl Write for PartFile {
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
/// The error of the system.
pub fn sync_folder(path: &Path) -> io::Result<()> {
    match path.parent() {
        // Other systems cannot open a folder.
        Some(folder) if cfg!(unix) && !folder.as_os_str().is_empty() => File::open(folder)?.sync_all(),
        _ => Ok(()),
    }
}
