//! Converts any data set that can be read to arrays in a `.npz` and a file of names beside it.

use crate::dataset::assemble::{Checked, assemble};
use crate::dataset::dataset::Dataset;
use crate::dataset::spec_of::likeliest_layout;
use crate::ending::has_ending;
use crate::length::length::{Length, Longer, Padding};
use crate::load::open;
use crate::options::{ReadOptions, refuse_set};
use crate::reader::Purpose;
use crate::write::save::write;
use crate::{Error, Result};
use ndarray::{ArrayD, Axis};
use std::io;
use std::path::{Path, PathBuf};

/// The files that [`convert`] has written.
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
/// As [`load`](crate::load), but for unequal lengths; another ending of `output` than `.npz`; a file that cannot be written.
pub fn convert(path: &Path, options: &ReadOptions, output: &Path) -> Result<Converted> {
    let is_other = !has_ending(output, &["npz"]);
    let why = "is the name of a .npz file to write";
    refuse_set(&output.display().to_string(), &[("output", is_other)], why)?;
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

/// Reads the data set, and fills up unequal recordings without a rule to the longest. Then it also returns the time steps of
/// each.
fn read(path: &Path, options: &ReadOptions) -> Result<(Dataset, Option<Vec<usize>>)> {
    let mut raw = open(path, Purpose::Learn, options)?;
    let mut options = options.clone();
    let given = [options.layout, raw.facts.layout, raw.format];
    let time = likeliest_layout(given, &raw.dtype, raw.x.sample_shape()).time_axis();
    let mut is_filled = false;
    if let (Some(axis), None) = (time, options.length) {
        raw.x = std::mem::take(&mut raw.x).without_padding(time);
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

/// Overwrites all that follows the time steps of a recording with NaN.
fn blank(x: &mut ArrayD<f32>, axis: usize, readings: &[usize]) {
    for (mut sample, readings) in x.axis_iter_mut(Axis(0)).zip(readings) {
        sample.slice_axis_mut(Axis(axis), (*readings..).into()).fill(f32::NAN);
    }
}
