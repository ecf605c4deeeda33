//! Files that are whole or not there, and NumPy arrays in them.

use std::fs::{self, File};
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};

use npyz::npz::NpzWriter;
use npyz::zip::{CompressionMethod, DateTime, write::FileOptions};
use npyz::{AutoSerialize, WriterBuilder};

/// Ending of a file that is being written.
pub const PART: &str = ".part";

/// Writes `bytes` under another name in the same folder, flushes them to disk, then renames: no
/// reader sees half a file.
///
/// # Errors
///
/// What the system says.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut part = path.as_os_str().to_owned();
    part.push(PART);
    let part = PathBuf::from(part);
    let written = File::create(&part).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    let written = written.and_then(|()| fs::rename(&part, path)).and_then(|()| sync_folder(path));
    if written.is_err() {
        // The first error is the one to report.
        let _ = fs::remove_file(&part);
    }
    written
}

/// Flushes the folder that a file was renamed in, so that the new name survives a power cut.
fn sync_folder(path: &Path) -> io::Result<()> {
    match path.parent() {
        // Other systems cannot open a folder.
        Some(folder) if cfg!(unix) && !folder.as_os_str().is_empty() => File::open(folder)?.sync_all(),
        _ => Ok(()),
    }
}

/// One array as the bytes of a `.npy`, row-major.
///
/// # Errors
///
/// More or fewer values than `shape` has.
pub fn npy_bytes<T: AutoSerialize + Copy>(shape: &[usize], values: &[T]) -> io::Result<Vec<u8>> {
    let mut bytes = vec![];
    let mut array =
        npyz::WriteOptions::new().default_dtype().shape(&long(shape)).writer(&mut bytes).begin_nd()?;
    array.extend(values.iter().copied())?;
    array.finish()?;
    Ok(bytes)
}

/// A deflated `.npz` in the making. Equal arrays give equal bytes: members carry no time of day.
pub struct Npz {
    archive: NpzWriter<Cursor<Vec<u8>>>,
}

impl Default for Npz {
    fn default() -> Self {
        Npz { archive: NpzWriter::new(Cursor::new(vec![])) }
    }
}

impl Npz {
    /// Adds an array, row-major.
    ///
    /// # Errors
    ///
    /// More or fewer values than `shape` has.
    pub fn add<T: AutoSerialize + Copy>(
        &mut self,
        name: &str,
        shape: &[usize],
        values: &[T],
    ) -> io::Result<()> {
        let options = FileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default());
        // In one piece: the compressor clears its buffer at every call.
        let bytes = npy_bytes(shape, values)?;
        let zip = self.archive.zip_writer();
        zip.start_file(npyz::npz::file_name_from_array_name(name), options)?;
        zip.write_all(&bytes)
    }

    /// The archive's bytes.
    ///
    /// # Errors
    ///
    /// What the archiver says.
    pub fn finish(mut self) -> io::Result<Vec<u8>> {
        Ok(self.archive.zip_writer().finish()?.into_inner())
    }
}

fn long(shape: &[usize]) -> Vec<u64> {
    shape.iter().map(|axis| *axis as u64).collect()
}
