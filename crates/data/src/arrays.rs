//! Samples, labels and groups by name, from a `.npz` archive or a MATLAB file.

use crate::hash::hash_rows;
use crate::npy::{Cap, Header};
use crate::options::{Limits, Options};
use crate::raw::{Names, Raw, name_of};
use crate::{Error, Result, mat, names_file, npz};
use ndarray::ArrayD;
use std::io::Read;
use std::path::Path;

/// An open file of named arrays.
enum Archive {
    Npz(npz::Archive),
    Mat(mat::Archive),
}

impl Archive {
    fn open(path: &Path) -> Result<Self> {
        match mat::is_named(path) {
            true => mat::Archive::open(path).map(Self::Mat),
            false => npz::Archive::open(path).map(Self::Npz),
        }
    }

    fn arrays(&self) -> &[String] {
        match self {
            Self::Npz(npz) => &npz.arrays,
            Self::Mat(mat) => &mat.arrays,
        }
    }

    /// Opens one array and hands its header and the stream of its values to `read`.
    fn with<T>(
        &mut self,
        file: &str,
        array: &str,
        option: &'static str,
        read: impl FnOnce(&Header, &mut dyn Read, &str) -> Result<T>,
    ) -> Result<T> {
        if !self.arrays().iter().any(|name| name == array) {
            return Err(Error::missing(file, array, self.arrays(), option));
        }
        let at = format!("{file}: {array}");
        match self {
            Self::Npz(npz) => npz.with(array, &at, read),
            Self::Mat(mat) => mat.with(array, &at, read),
        }
    }
}

/// Reads the arrays that `options` names; labels and groups stay as stored.
pub(crate) fn read(path: &Path, options: &Options) -> Result<Raw> {
    read_with(path, options, true)
}

/// The same of a file that may hold no labels: `y` is empty then.
pub(crate) fn read_unlabelled(path: &Path, options: &Options) -> Result<Raw> {
    read_with(path, options, false)
}

fn read_with(path: &Path, options: &Options, needs_labels: bool) -> Result<Raw> {
    let file = path.display().to_string();
    let mut archive = Archive::open(path)?;
    if options.resize.is_some() {
        let why = "applies to a folder of PNG or JPEG files only; leave it out";
        return Err(Error::Option { file, option: "resize", why });
    }
    let (x, dtype) = read_samples(&mut archive, &file, options)?;
    let samples = x.shape()[0];
    let (y, columns, numbered) = match needs_labels || archive.arrays().contains(&options.y) {
        true => read_labels(&mut archive, &file, options, samples)?,
        false => (vec![], 1, None),
    };
    let groups = read_groups(&mut archive, &file, options)?;
    let official = read_official(&mut archive, &file, options)?;
    let used = |name: &String| {
        let is = |array: &Option<(String, Vec<i64>)>| array.as_ref().is_some_and(|(own, _)| own == name);
        *name == options.x || *name == options.y || is(&groups) || is(&official)
    };
    let others = archive.arrays().iter().filter(|n| !used(n)).cloned().collect();
    let row_hash = hash_rows(&x);
    let (names, facts) = names_file::beside(path, &options.limits)?;
    Ok(Raw {
        name: name_of(path),
        format: None,
        dtype,
        origins: (0..samples).map(|i| format!("{}[{i}]", options.x)).collect(),
        x,
        x_name: options.x.clone(),
        y_name: options.y.clone(),
        y,
        columns,
        names: names.or(numbered),
        facts,
        groups,
        official,
        row_hash,
        others,
        is_folder: false,
        file,
    })
}

/// Samples `[N, ...]` and the type that they are stored in; no axis is empty.
fn read_samples(archive: &mut Archive, file: &str, options: &Options) -> Result<(ArrayD<f32>, String)> {
    let limits = &options.limits;
    archive.with(file, &options.x, "x", |header, reader, at| {
        sample_shape(header, at, limits)?;
        Ok((header.read_f32(reader, at, Cap::of_samples(limits))?, header.dtype.clone()))
    })
}

/// Labels row by row, how many a sample has, and names of labels that a MATLAB file counts from 1.
fn read_labels(
    archive: &mut Archive,
    file: &str,
    options: &Options,
    samples: usize,
) -> Result<(Vec<i64>, usize, Option<Names>)> {
    let (mut y, columns) = archive.with(file, &options.y, "y", |header, reader, at| {
        let header = &header.as_column();
        let columns = match *header.shape.as_slice() {
            [_] => 1,
            [_, columns] if columns > 0 => columns as usize,
            _ => {
                return Err(Error::Shape {
                    at: at.into(),
                    shape: header.shape.clone(),
                    wanted: "labels are [N], or [N, k] for k attributes",
                });
            }
        };
        let wanted = "labels are whole numbers from 0: save y as an integer array";
        Ok((header.read_i64(reader, at, Cap::of_labels(&options.limits), wanted)?, columns))
    })?;
    // MATLAB counts from 1.
    if !matches!(archive, Archive::Mat(_)) || y.iter().min() != Some(&1) {
        return Ok((y, columns, None));
    }
    y.iter_mut().for_each(|label| *label -= 1);
    let names = |column: usize| match y.iter().skip(column).step_by(columns).max() {
        None => vec![],
        // Numbers that no file of so many samples can fill are named nowhere: they are refused as gaps.
        Some(last) => (0..=*last.min(&(samples as i64))).map(|label| (label + 1).to_string()).collect(),
    };
    let columns_of = (0..columns).map(names).collect();
    let names = Names { file: options.y.clone(), columns: columns_of, is_told: false };
    Ok((y, columns, Some(names)))
}

/// Groups and the name of their array.
fn read_groups(archive: &mut Archive, file: &str, options: &Options) -> Result<Option<(String, Vec<i64>)>> {
    let Some(name) = group_array(file, archive, options)? else { return Ok(None) };
    let values = archive.with(file, &name, "group", |header, reader, at| {
        let header = &header.as_column();
        if header.shape.len() != 1 {
            return Err(Error::Shape {
                at: at.into(),
                shape: header.shape.clone(),
                wanted: "groups are [N], one whole number per sample",
            });
        }
        let wanted = "groups are whole numbers: save them as an integer array";
        header.read_i64(reader, at, Cap::of_labels(&options.limits), wanted)
    })?;
    Ok(Some((name, values)))
}

/// Marks of the samples that the authors test on, and the name of their array.
fn read_official(archive: &mut Archive, file: &str, options: &Options) -> Result<Option<(String, Vec<i64>)>> {
    let Some(name) = &options.test else {
        return match options.test_above {
            None => Ok(None),
            Some(_) => {
                let (file, why) = (file.into(), "needs the name of an array in test");
                Err(Error::Option { file, option: "test-above", why })
            }
        };
    };
    let wanted = "marks are 0 for training and 1 for testing: save them as an integer or boolean array";
    let read = |header: &Header, reader: &mut dyn Read, at: &str| {
        header.as_column().read_i64(reader, at, Cap::of_labels(&options.limits), wanted)
    };
    Ok(Some((name.clone(), archive.with(file, name, "test", read)?)))
}

fn group_array(file: &str, archive: &Archive, options: &Options) -> Result<Option<String>> {
    let default = "group".to_string();
    match &options.group {
        Some(name) => Ok(Some(name.clone())),
        None if archive.arrays().contains(&default) => Ok(Some(default)),
        None if options.group_block.is_some() => Err(Error::Option {
            file: file.into(),
            option: "group-block",
            why: "needs an array to divide into blocks; name it with group = \"trial\"",
        }),
        None => Ok(None),
    }
}

fn sample_shape(header: &Header, at: &str, limits: &Limits) -> Result<()> {
    let shape = header.shape.clone();
    if !(2..=4).contains(&shape.len()) {
        return Err(Error::Shape {
            at: at.into(),
            shape,
            wanted: "samples are [N, C, T], [N, H, W] or [N, T, H, W], samples first",
        });
    }
    if shape[0] > limits.max_samples {
        let limit = limits.max_samples;
        return Err(Error::TooManySamples { at: at.into(), samples: shape[0], limit });
    }
    match shape.iter().position(|axis| *axis == 0) {
        Some(0) => Err(Error::NoSamples { at: at.into() }),
        Some(axis) => Err(Error::EmptyAxis { at: at.into(), shape, axis }),
        None => Ok(()),
    }
}
