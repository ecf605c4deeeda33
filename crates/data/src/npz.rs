//! A `.npz` archive: samples, labels and groups by name.

use crate::dataset::{Axes, hash_row};
use crate::npy::{self, Cap, Header};
use crate::options::{Limits, Options};
use crate::raw::{Raw, name_of};
use crate::{Error, Result, labels};
use npyz::npz::NpzArchive;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

struct Archive {
    file: String,
    npz: NpzArchive<BufReader<File>>,
    arrays: Vec<String>,
}

impl Archive {
    fn open(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let io = |e: std::io::Error| Error::Io { file: file.clone(), kind: e.kind() };
        let mut start = Vec::new();
        let open = File::open(path).map_err(io)?;
        open.take(4).read_to_end(&mut start).map_err(io)?;
        if start.is_empty() {
            return Err(Error::EmptyFile { file });
        }
        let reader = BufReader::new(File::open(path).map_err(io)?);
        let npz = NpzArchive::new(reader).map_err(|e| {
            let (file, why) = (file.clone(), e.to_string().to_lowercase());
            if start.starts_with(b"PK") {
                Error::DamagedArchive { file, why }
            } else {
                Error::NotAnArchive { file, why }
            }
        })?;
        let mut arrays: Vec<String> = npz.array_names().map(str::to_string).collect();
        arrays.sort();
        Ok(Self { file, npz, arrays })
    }

    /// Opens one array and hands its header and the stream of its values to `read`.
    fn with<T>(
        &mut self,
        array: &str,
        option: &'static str,
        read: impl FnOnce(&Header, &mut dyn Read, &str) -> Result<T>,
    ) -> Result<T> {
        if !self.arrays.iter().any(|name| name == array) {
            return Err(Error::MissingArray {
                file: self.file.clone(),
                array: array.into(),
                held: match self.arrays.as_slice() {
                    [] => "no arrays".into(),
                    names => names.join(", "),
                },
                option,
            });
        }
        let at = format!("{}: {array}", self.file);
        let damaged = |why: String| Error::Damaged { at: at.clone(), why };
        let entry = npyz::npz::file_name_from_array_name(array);
        let mut entry =
            self.npz.zip_archive().by_name(&entry).map_err(|e| damaged(e.to_string().to_lowercase()))?;
        let header = npy::read_header(&mut entry, &at)?;
        read(&header, &mut entry, &at)
    }
}

/// Reads the arrays that `options` names; labels and groups stay as stored.
pub(crate) fn read(path: &Path, options: &Options) -> Result<Raw> {
    let limits = &options.limits;
    let mut archive = Archive::open(path)?;
    if options.resize.is_some() {
        return Err(Error::Option {
            file: archive.file,
            option: "resize",
            why: "applies to a folder of PNG or JPEG files only; leave it out",
        });
    }
    let (x, dtype) = archive.with(&options.x, "x", |header, reader, at| {
        sample_shape(header, at, limits)?;
        Ok((header.read_f32(reader, at, Cap::of_samples(limits))?, header.dtype.clone()))
    })?;
    let (y, columns) = archive.with(&options.y, "y", |header, reader, at| {
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
    let groups = match group_array(&archive, options)? {
        None => None,
        Some(name) => {
            let values = archive.with(&name, "group", |header, reader, at| {
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
            return Err(Error::Option { file: path.display().to_string(), option: "test-above", why });
        }
        None => None,
        Some(name) => {
            let wanted =
                "marks are 0 for training and 1 for testing: save them as an integer or boolean array";
            let read = |header: &Header, reader: &mut dyn Read, at: &str| {
                header.read_i64(reader, at, Cap::of_labels(limits), wanted)
            };
            Some((name.clone(), archive.with(name, "test", read)?))
        }
    };
    let used = |name: &String| {
        let is = |array: &Option<(String, Vec<i64>)>| array.as_ref().is_some_and(|(own, _)| own == name);
        *name == options.x || *name == options.y || is(&groups) || is(&official)
    };
    let others = archive.arrays.iter().filter(|n| !used(n)).cloned().collect();
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
        names: labels::beside(path, &options.limits)?,
        groups,
        official,
        row_hash,
        others,
        is_folder: false,
        file: archive.file,
    })
}

fn group_array(archive: &Archive, options: &Options) -> Result<Option<String>> {
    let default = "group".to_string();
    match &options.group {
        Some(name) => Ok(Some(name.clone())),
        None if archive.arrays.contains(&default) => Ok(Some(default)),
        None if options.group_block.is_some() => Err(Error::Option {
            file: archive.file.clone(),
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
