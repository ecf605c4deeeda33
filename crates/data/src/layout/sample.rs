//! Reads one array of a file as one recording.

use crate::formats::npy;
use crate::options::Limits;
use crate::reader::Sample;
use crate::{Error, Result};
use std::io::Read;

/// Reads one array as one recording.
pub(crate) fn one(header: &npy::Header, reader: &mut dyn Read, at: &str, limits: &Limits) -> Result<Sample> {
    let shape = header.shape.clone();
    if !(2..=3).contains(&shape.len()) {
        let wanted = "one recording is [C, T], [H, W] or [T, H, W]";
        return Err(Error::Shape { at: at.into(), shape, wanted });
    }
    if let Some(axis) = shape.iter().position(|axis| *axis == 0) {
        return Err(Error::EmptyAxis { at: at.into(), shape, axis });
    }
    let array = header.read_f32(reader, at, npy::Cap::of_samples(limits), 0)?;
    let shape = array.shape().to_vec();
    Ok(Sample { shape, values: array.into_iter().collect(), dtype: header.dtype.clone(), is_turned: false })
}
