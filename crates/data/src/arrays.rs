//! Samples, labels and groups by name, from a `.npz` archive or a MATLAB file.

use crate::dataset::{Axes, hash_row};
use crate::npy::{Cap, Header};
use crate::options::{Limits, Options};
use crate::raw::{Names, Raw, name_of};
use crate::{Error, Result, labels, mat, npz};
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
            return Err(missing(file, array, self.arrays(), option));
        }
        let at = format!("{file}: {array}");
        match self {
            Self::Npz(npz) => npz.with(array, &at, read),
            Self::Mat(mat) => mat.with(array, &at, read),
        }
    }
}

/// No array of that name among those `held`.
pub(crate) fn missing(file: &str, array: &str, held: &[String], option: &'static str) -> Error {
    Error::MissingArray {
        file: file.into(),
        array: array.into(),
        held: match held {
            [] => "no arrays".into(),
            names => names.join(", "),
        },
        option,
    }
}

/// Reads the arrays that `options` names; labels and groups stay as stored.
pub(crate) fn read(path: &Path, options: &Options) -> Result<Raw> {
    let limits = &options.limits;
    let file = path.display().to_string();
    let mut archive = Archive::open(path)?;
    if options.resize.is_some() {
        return Err(Error::Option {
            file,
            option: "resize",
            why: "applies to a folder of PNG or JPEG files only; leave it out",
        });
    }
    let (x, dtype) = archive.with(&file, &options.x, "x", |header, reader, at| {
        sample_shape(header, at, limits)?;
        Ok((header.read_f32(reader, at, Cap::of_samples(limits))?, header.dtype.clone()))
    })?;
    let (mut y, columns) = archive.with(&file, &options.y, "y", |header, reader, at| {
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
        Ok((header.read_i64(reader, at, Cap::of_labels(limits), wanted)?, columns))
    })?;
    // MATLAB counts from 1.
    let mut numbered = None;
    if matches!(archive, Archive::Mat(_)) && y.iter().min() == Some(&1) {
        y.iter_mut().for_each(|label| *label -= 1);
        let last = |column: usize| y.iter().skip(column).step_by(columns).max().copied().unwrap_or(0);
        // Numbers that no file of so many samples can fill are named nowhere: they are refused as gaps.
        let names =
            |column| (0..=last(column).min(x.shape()[0] as i64)).map(|c| (c + 1).to_string()).collect();
        let columns = (0..columns).map(names).collect();
        numbered = Some(Names { file: options.y.clone(), columns, source: None, full_scale: None });
    }
    let groups = match group_array(&file, &archive, options)? {
        None => None,
        Some(name) => {
            let values = archive.with(&file, &name, "group", |header, reader, at| {
                let header = &header.as_column();
                if header.shape.len() != 1 {
                    return Err(Error::Shape {
                        at: at.into(),
                        shape: header.shape.clone(),
                        wanted: "groups are [N], one whole number per sample",
                    });
                }
                let wanted = "groups are whole numbers: save them as an integer array";
                header.read_i64(reader, at, Cap::of_labels(limits), wanted)
            })?;
            Some((name, values))
        }
    };
    let official = match &options.test {
        None if options.test_above.is_some() => {
            let why = "needs the name of an array in test";
            return Err(Error::Option { file, option: "test-above", why });
        }
        None => None,
        Some(name) => {
            let wanted =
                "marks are 0 for training and 1 for testing: save them as an integer or boolean array";
            let read = |header: &Header, reader: &mut dyn Read, at: &str| {
                header.as_column().read_i64(reader, at, Cap::of_labels(limits), wanted)
            };
            Some((name.clone(), archive.with(&file, name, "test", read)?))
        }
    };
    let used = |name: &String| {
        let is = |array: &Option<(String, Vec<i64>)>| array.as_ref().is_some_and(|(own, _)| own == name);
        *name == options.x || *name == options.y || is(&groups) || is(&official)
    };
    let others = archive.arrays().iter().filter(|n| !used(n)).cloned().collect();
    let rows = x.len() / x.shape()[0].max(1);
    let row_hash =
        x.as_slice().map(|values| values.chunks(rows.max(1)).map(hash_row).collect()).unwrap_or_default();
    Ok(Raw {
        name: name_of(path),
        axes: axes(x.ndim(), &dtype),
        dtype,
        sources: (0..x.shape()[0]).map(|i| format!("{}[{i}]", options.x)).collect(),
        x,
        x_name: options.x.clone(),
        y_name: options.y.clone(),
        y,
        columns,
        names: labels::beside(path, &options.limits)?.or(numbered),
        groups,
        official,
        row_hash,
        others,
        is_folder: false,
        file,
    })
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

/// A `.npz` does not say what its axes are; bytes in three axes are taken for images.
fn axes(rank: usize, dtype: &str) -> Axes {
    match rank {
        2 => Axes::Features,
        3 if dtype.ends_with("u1") => Axes::HeightWidth,
        3 => Axes::ChannelsTime,
        _ => Axes::TimeHeightWidth,
    }
}
