//! One `.npy` file as an array.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ndarray::ArrayD;

use crate::formats::npy::{Cap, Header, read_header};
use crate::layout::arrays::sample_shape;
use crate::options::Limits;
use crate::{Error, Result};

/// Reads a `.npy` of integers or floats as f32, C order, any rank.
///
/// # Errors
///
/// A file that is missing, cut short or no NumPy array, another dtype, or a value that f32 cannot hold.
pub fn read_npy(path: &Path) -> Result<ArrayD<f32>> {
    let (file, mut reader, header) = open(path)?;
    header.read_f32(&mut reader, &file, Cap::of_samples(&Limits::default()))
}

/// Samples `[N, ...]` of `rank` axes each; none where the array has another number of axes.
pub(crate) fn read_batch(path: &Path, rank: usize, limits: &Limits) -> Result<Option<ArrayD<f32>>> {
    let (file, mut reader, header) = open(path)?;
    if header.shape.len() != rank + 1 {
        return Ok(None);
    }
    sample_shape(&header, &file, limits)?;
    header.read_f32(&mut reader, &file, Cap::of_samples(limits)).map(Some)
}

fn open(path: &Path) -> Result<(String, BufReader<File>, Header)> {
    let file = path.display().to_string();
    let handle = File::open(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => Error::NotFound { file: file.clone() },
        kind => Error::Io { file: file.clone(), kind },
    })?;
    let mut reader = BufReader::new(handle);
    let header = read_header(&mut reader, &file)?;
    Ok((file, reader, header))
}
