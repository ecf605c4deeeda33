//! NumPy files out, whole or not at all.

use std::path::Path;

#[cfg(feature = "lab")]
use ndarray::ArrayD;

#[cfg(feature = "lab")]
/// Writes a row-major f32 array as `.npy`.
pub fn write_npy(path: &Path, array: &ArrayD<f32>) -> Result<(), String> {
    let values = array.as_standard_layout();
    let bytes = taxel_data::npy_bytes(array.shape(), values.as_slice().unwrap_or_default());
    write(path, bytes)
}

/// Writes encoded bytes, or says that the file cannot be written.
pub fn write(path: &Path, bytes: std::io::Result<Vec<u8>>) -> Result<(), String> {
    let written = bytes.and_then(|bytes| taxel_data::write_whole(path, &bytes));
    written.map_err(|e| format!("{}: cannot be written: {e}", path.display()))
}
