//! NumPy files in and out.

use std::io::{BufWriter, Write};
use std::path::Path;

use ndarray::ArrayD;
use npyz::WriterBuilder;

/// Writes a row-major f32 array as `.npy`, whole or not at all.
pub fn write_npy(path: &Path, array: &ArrayD<f32>) -> Result<(), String> {
    whole(path, |file| npy(file, array.shape(), array.iter().copied()))
}

/// One named array of a `.npz`.
pub enum Column {
    /// Real values of any shape.
    Floats(ArrayD<f32>),
    /// One integer per sample.
    Integers(Vec<u32>),
}

/// Writes named arrays as a deflated `.npz`, whole or not at all.
pub fn write_npz(path: &Path, columns: &[(String, Column)]) -> Result<(), String> {
    whole(path, |file| {
        let mut archive = npyz::npz::NpzWriter::new(file);
        for (name, column) in columns {
            let options = npyz::zip::write::FileOptions::default();
            match column {
                Column::Floats(values) => {
                    let shape: Vec<u64> = values.shape().iter().map(|s| *s as u64).collect();
                    let mut array = archive.array(name, options)?.default_dtype().shape(&shape).begin_nd()?;
                    array.extend(values.iter().copied())?;
                    array.finish()?;
                }
                Column::Integers(values) => {
                    let mut array = archive
                        .array(name, options)?
                        .default_dtype()
                        .shape(&[values.len() as u64])
                        .begin_nd()?;
                    array.extend(values.iter().copied())?;
                    array.finish()?;
                }
            }
        }
        Ok(())
    })
}

fn npy(file: &mut dyn Seekable, shape: &[usize], values: impl Iterator<Item = f32>) -> std::io::Result<()> {
    let shape: Vec<u64> = shape.iter().map(|s| *s as u64).collect();
    let mut array = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(file).begin_nd()?;
    array.extend(values)?;
    array.finish()
}

/// A file that can be written and rewound, as archives need.
trait Seekable: Write + std::io::Seek {}
impl<T: Write + std::io::Seek> Seekable for T {}

/// Writes under a temporary name in the same folder, then renames: no reader sees half a file.
fn whole(path: &Path, body: impl FnOnce(&mut dyn Seekable) -> std::io::Result<()>) -> Result<(), String> {
    let refuse = |e: std::io::Error| format!("{}: cannot be written: {e}", path.display());
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(refuse)?;
    let mut buffered = BufWriter::new(file.as_file_mut());
    body(&mut buffered).and_then(|()| buffered.flush()).map_err(refuse)?;
    drop(buffered);
    file.as_file().sync_all().map_err(refuse)?;
    file.persist(path).map_err(|e| refuse(e.error))?;
    Ok(())
}
