//! Files that are whole or not there: the one way in which the project writes a file.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Ending of a file that is being written.
pub const PART: &str = ".part";

/// Writes `bytes` under another name in the same folder, flushes them to disk, then renames: no
/// reader sees half a file. Where a link stands, what it leads to is written; a device or a pipe cannot be
/// replaced and gets the bytes themselves.
///
/// # Errors
///
/// What the system says.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.into());
    if fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        return OpenOptions::new().write(true).open(path).and_then(|mut device| device.write_all(bytes));
    }
    write_piecewise(path, |file| file.write_all(bytes))
}

/// A file that is too long to be held in memory, whole or not there: `pieces` writes it.
///
/// # Errors
///
/// What the system or `pieces` says.
pub fn write_piecewise<E: From<io::Error>>(
    path: &Path,
    pieces: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), E> {
    let mut part = path.as_os_str().to_owned();
    part.push(PART);
    let part = PathBuf::from(part);
    let written = File::create(&part).map_err(E::from).and_then(|file| {
        let mut file = BufWriter::new(file);
        pieces(&mut file)?;
        file.flush()?;
        file.get_ref().sync_all()?;
        fs::rename(&part, path)?;
        Ok(sync_folder(path)?)
    });
    if written.is_err() {
        // The first error is the one to report.
        let _ = fs::remove_file(&part);
    }
    written
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
