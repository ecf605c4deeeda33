//! One recording in a file of its own.

use crate::dataset::digest::{RowHash, hash_row};
use crate::formats::archive::Archive;
use crate::formats::bag::path::is_bag;
use crate::formats::csv_file;
use crate::formats::image_file;
use crate::formats::npy;
use crate::formats::text::read_text;
use crate::options::{Limits, ReadOptions};
use crate::{Error, Result};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use taxel_base::Layout;

/// What a recording may be stored as; a data set holds one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Csv,
    Npy,
    Mat,
    Hdf5,
    Image,
    /// A file of MCAP, or the folder that rosbag2 makes of it.
    Bag,
}

impl Kind {
    pub fn of(path: &Path) -> Option<Self> {
        if is_bag(path) {
            return Some(Self::Bag);
        }
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        match extension.as_str() {
            "csv" => Some(Self::Csv),
            "npy" => Some(Self::Npy),
            "mat" => Some(Self::Mat),
            "h5" | "hdf5" => Some(Self::Hdf5),
            "png" | "jpg" | "jpeg" => Some(Self::Image),
            _ => None,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "CSV",
            Self::Npy => "NPY",
            Self::Mat => "MAT",
            Self::Hdf5 => "HDF5",
            Self::Image => "an image",
            Self::Bag => "a bag",
        }
    }

    /// What the axes of a sample of so many are; none where the file does not say.
    pub fn layout(self, rank: usize) -> Option<Layout> {
        match (self, rank) {
            (Self::Image, 3) => Some(Layout::Colour),
            (Self::Image, _) => Some(Layout::Image),
            (Self::Csv, _) => Some(Layout::Series),
            (Self::Npy | Self::Mat | Self::Hdf5 | Self::Bag, _) => None,
        }
    }

    /// What to do about samples that differ in more than their length.
    pub fn hint(self) -> &'static str {
        match self {
            Self::Csv | Self::Mat => " but for time (channels, time): use the same channels throughout",
            Self::Npy | Self::Hdf5 | Self::Bag => " but for time",
            Self::Image => ": set resize = [height, width], or use grey or colour throughout",
        }
    }
}

/// One recording, read.
pub(crate) struct Sample {
    pub shape: Vec<usize>,
    pub values: Vec<f32>,
    pub hash: RowHash,
    pub dtype: String,
}

/// The shape of an image by the head of its file; one too large to decode is refused.
pub(crate) fn image_shape(path: &Path, options: &ReadOptions) -> Result<Vec<usize>> {
    let file = path.display().to_string();
    refuse_empty(path, &file)?;
    image_file::shape(path, &file, options.resize, &options.limits)
}

fn refuse_empty(path: &Path, file: &str) -> Result<()> {
    let metadata = path.metadata().map_err(|e| Error::Io { file: file.into(), kind: e.kind() })?;
    match metadata.len() {
        0 => Err(Error::EmptyFile { file: file.into() }),
        _ => Ok(()),
    }
}

/// Reads one file.
pub(crate) fn read_sample(path: &Path, kind: Kind, options: &ReadOptions) -> Result<Sample> {
    let limits = &options.limits;
    let file = path.display().to_string();
    let io = |e: std::io::Error| Error::Io { file: file.clone(), kind: e.kind() };
    refuse_empty(path, &file)?;
    match kind {
        Kind::Csv => {
            let (shape, values) = csv_file::read(&read_text(path, limits)?, &file, limits.max_values)?;
            let hash = hash_row(&values);
            Ok(Sample { shape, values, hash, dtype: "csv".into() })
        }
        Kind::Npy => {
            let mut reader = BufReader::new(File::open(path).map_err(io)?);
            let header = npy::read_header(&mut reader, &file)?;
            one(&header, &mut reader, &file, limits)
        }
        Kind::Mat | Kind::Hdf5 => {
            let mut archive = Archive::open(path)?;
            let (held, described) = (archive.recordings(), archive.described());
            let name = match held.as_slice() {
                [one] => one.clone(),
                _ if held.contains(&options.x) => options.x.clone(),
                _ => return Err(Error::missing(&file, &options.x, &described, "x")),
            };
            archive.with(&file, &name, "x", |header, reader, at| one(header, reader, at, limits))
        }
        // Of several together, which have one clock.
        Kind::Bag => Err(Error::OneBag { file }),
        Kind::Image => {
            let picture = image_file::read(path, &file, options.resize, limits)?;
            Ok(Sample {
                shape: picture.shape,
                values: picture.values,
                hash: picture.hash,
                dtype: format!("png/jpeg u{}", picture.bits),
            })
        }
    }
}

/// One array as one recording.
pub(crate) fn one(header: &npy::Header, reader: &mut dyn Read, at: &str, limits: &Limits) -> Result<Sample> {
    let shape = header.shape.clone();
    if !(2..=3).contains(&shape.len()) {
        let wanted = "one recording is [C, T], [H, W] or [T, H, W]";
        return Err(Error::Shape { at: at.into(), shape, wanted });
    }
    if let Some(axis) = shape.iter().position(|axis| *axis == 0) {
        return Err(Error::EmptyAxis { at: at.into(), shape, axis });
    }
    let array = header.read_f32(reader, at, npy::Cap::of_samples(limits))?;
    let shape = array.shape().to_vec();
    let values = array.into_iter().collect::<Vec<f32>>();
    let hash = hash_row(&values);
    Ok(Sample { shape, values, hash, dtype: header.dtype.clone() })
}
