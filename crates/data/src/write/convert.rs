//! Any data set that can be read, as one plain form: arrays in a `.npz` and a file of names beside it.

use crate::dataset::assemble::{Checked, assemble};
use crate::dataset::dataset::Dataset;
use crate::dataset::spec_of::time_axis;
use crate::length::length::{Length, Longer, Padding};
use crate::load::open;
use crate::options::ReadOptions;
use crate::reader::Purpose;
use crate::write::save::write;
use crate::{Error, Result};
use ndarray::{ArrayD, Axis};
use std::io;
use std::path::{Path, PathBuf};

/// What [`convert`] has written.
#[derive(Debug, Clone, PartialEq)]
pub struct Converted {
    /// The arrays, and the names beside them.
    pub files: [PathBuf; 2],
    /// Shape of `x`, samples first.
    pub shape: Vec<usize>,
    /// Shortest and longest recording, where shorter ones are filled up with NaN.
    pub padded: Option<[usize; 2]>,
}

/// Reads the data set at `path` and writes it to `output`, a `.npz`, with `<output>.classes.json` beside it:
/// [`load`](crate::load) reads it back with the same digest.
///
/// The files are those of [`Dataset::save`]; recordings of unequal length end in NaN, unless [`ReadOptions::length`] says
/// otherwise.
///
/// # Errors
///
/// As [`load`](crate::load), but for unequal lengths; another ending of `output` than `.npz`; what the system says.
pub fn convert(path: &Path, options: &ReadOptions, output: &Path) -> Result<Converted> {
    if output.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("npz")) {
        let (file, why) = (output.display().to_string(), "is the name of a .npz file to write");
        return Err(Error::Option { file, option: "output", why });
    }
    let (mut data, readings) = read(path, options)?;
    let axis = data.spec.layout.time_axis();
    let padded = match (readings, axis) {
        (Some(readings), Some(axis)) => {
            blank(&mut data.x, axis, &readings);
            Some([readings.iter().min(), readings.iter().max()].map(|n| n.copied().unwrap_or(0)))
        }
        _ => None,
    };
    let failed = |(file, error): (PathBuf, io::Error)| Error::Write {
        file: file.display().to_string(),
        why: error.to_string(),
    };
    let files = write(&data, output).map_err(failed)?;
    Ok(Converted { files, shape: data.x.shape().to_vec(), padded })
}

/// The data set; unequal recordings without a rule are filled up to the longest, and the readings of each said.
fn read(path: &Path, options: &ReadOptions) -> Result<(Dataset, Option<Vec<usize>>)> {
    let mut raw = open(path, Purpose::Learn, options)?;
    let mut options = options.clone();
    let time = time_axis(options.layout, raw.facts.layout, raw.format, &raw.dtype, raw.x.sample_shape());
    let mut is_filled = false;
    if let (Some(axis), None) = (time, options.length) {
        raw.x = std::mem::take(&mut raw.x).without_padding(axis);
        is_filled = raw.x.is_unequal();
        let to = raw.x.sample_shape()[axis];
        let fill = Length::Pad { to, value: Padding::Zero, longer: Longer::Refuse };
        options.length = is_filled.then_some(fill);
    }
    let Checked { dataset, problems, readings, .. } = assemble(raw, &options)?;
    match problems.into_iter().next() {
        Some(problem) => Err(problem.first),
        None => Ok((dataset, readings.filter(|_| is_filled))),
    }
}

/// What follows the readings of a recording becomes NaN.
fn blank(x: &mut ArrayD<f32>, axis: usize, readings: &[usize]) {
    for (mut sample, readings) in x.axis_iter_mut(Axis(0)).zip(readings) {
        sample.slice_axis_mut(Axis(axis), (*readings..).into()).fill(f32::NAN);
    }
}
