//! NumPy arrays as bytes: one `.npy`, or several in an `.npz`.

use std::io::{self, Cursor, Write};

use npyz::npz::NpzWriter;
use npyz::zip::{CompressionMethod, DateTime, write::FileOptions};
use npyz::{AutoSerialize, WriterBuilder};

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
