//! Files that are whole or not there: the one way in which the project writes a file.
//!
//! ```
//! use std::io::Write;
//! use taxel_base::files::{Part, part_of, write_whole};
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
//! assert!(!part_of(&path).exists());
//! # Ok::<(), std::io::Error>(())
//! ```

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Ending of a file that is being written.
pub const PART: &str = ".part";

/// Where a file is while it is being written: the same folder, and [`PART`] behind its name.
pub fn part_of(path: &Path) -> PathBuf {
    let mut part = path.as_os_str().to_owned();
    part.push(PART);
    part.into()
}

/// Writes `bytes` under another name in the same folder, flushes them to disk, then renames: no
/// reader sees half a file. Where a link stands, what it leads to is written; a device or a pipe cannot be
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
    names: Option<(PathBuf, PathBuf)>,
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
        let part = part_of(&path);
        Ok(Part { file: BufWriter::new(File::create(&part)?), names: Some((part, path)) })
    }

    /// Flushes what was written to disk and gives the file its name.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn finish(mut self) -> io::Result<()> {
        self.file.flush()?;
        let Some((_, path)) = self.names.clone() else { return Ok(()) };
        self.file.get_ref().sync_all()?;
        self.rename()?;
        sync_folder(&path)
    }

    fn rename(mut self) -> io::Result<()> {
        self.file.flush()?;
        if let Some((part, path)) = &self.names {
            fs::rename(part, path)?;
        }
        self.names = None;
        Ok(())
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

impl Drop for Part {
    fn drop(&mut self) {
        if let Some((part, _)) = &self.names {
            // What ended the writing is the error to report.
            let _ = fs::remove_file(part);
        }
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
