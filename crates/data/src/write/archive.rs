//! Writes NumPy arrays as bytes: one `.npy`, or several in an `.npz`.

use std::io::{self, Cursor, Write};

use npyz::npz::file_name_from_array_name;
use npyz::{AutoSerialize, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Writes one array as the bytes of a `.npy`, row-major.
///
/// # Errors
///
/// More or fewer values than `shape` has.
pub fn npy_bytes<T: AutoSerialize + Copy>(shape: &[usize], values: &[T]) -> io::Result<Vec<u8>> {
    let mut bytes = vec![];
    let shape: Vec<u64> = shape.iter().map(|axis| *axis as u64).collect();
    let mut array = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut bytes).begin_nd()?;
    array.extend(values.iter().copied())?;
    array.finish()?;
    Ok(bytes)
}

/// A deflated `.npz` in the making. Equal arrays give equal bytes: members carry no time of day.
pub struct Npz {
    archive: ZipWriter<Cursor<Vec<u8>>>,
}

impl Default for Npz {
    fn default() -> Self {
        Npz { archive: ZipWriter::new(Cursor::new(vec![])) }
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
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default());
        // Written at once: the compressor clears its buffer at every call.
        let bytes = npy_bytes(shape, values)?;
        self.archive.start_file(file_name_from_array_name(name), options)?;
        self.archive.write_all(&bytes)
    }

    /// Returns the bytes of the archive.
    ///
    /// # Errors
    ///
    /// An error of the archiver.
    pub fn finish(self) -> io::Result<Vec<u8>> {
        Ok(self.archive.finish()?.into_inner())
    }
}
