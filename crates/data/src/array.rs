//! One `.npy` file as an array.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ndarray::ArrayD;

use crate::npy::{Cap, read_header};
use crate::options::Limits;
use crate::{Error, Result};

/// Reads a `.npy` of integers or floats as f32, C order, any rank.
///
/// # Errors
///
/// A file that is missing, cut short or no NumPy array, another dtype, or a value that f32 cannot hold.
pub fn read_npy(path: &Path) -> Result<ArrayD<f32>> {
    let file = path.display().to_string();
    let handle = File::open(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => Error::NotFound { file: file.clone() },
        kind => Error::Io { file: file.clone(), kind },
    })?;
    let mut reader = BufReader::new(handle);
    let header = read_header(&mut reader, &file)?;
    header.read_f32(&mut reader, &file, Cap::of_samples(&Limits::default()))
}
