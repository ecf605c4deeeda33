//! Reads one `.npy` file as an array.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ndarray::{ArrayD, Axis};

use crate::dataset::raw::{Raw, name_of};
use crate::formats::npy::{Cap, Header, read_header};
use crate::layout::arrays::sample_shape;
use crate::layout::sample;
use crate::options::{Limits, ReadOptions};
use crate::reader::{FileFormat, Format, Place, Purpose, Reader, Sample};
use crate::{Error, Result};

/// Reads a `.npy` file of many samples, for a model whose samples have one axis less.
pub(crate) struct NpyBatch;

impl Reader for NpyBatch {
    fn formats(&self) -> &'static [Format] {
        &[]
    }

    fn recognises(&self, place: &Place, _: &ReadOptions) -> bool {
        let Purpose::Predict { rank } = place.purpose else { return false };
        // A file that cannot be opened is refused when it is read.
        Npy.takes(place.path)
            && open(place.path).map_or(true, |(_, _, header)| header.shape.len() == rank + 1)
    }

    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw> {
        let (file, mut reader, header) = open(place.path).map_err(|e| place.with_advice(e))?;
        sample_shape(&header, &file, &options.limits)?;
        let x = header.read_f32(&mut reader, &file, Cap::of_samples(&options.limits), 1)?;
        let name = name_of(place.path);
        let origins = (0..x.len_of(Axis(0))).map(|i| format!("{name}[{i}]")).collect();
        Ok(Raw { name, file, dtype: header.dtype, x: x.into(), origins, ..Raw::default() })
    }
}

/// Reads `.npy` files of which each is one recording.
pub(crate) struct Npy;

impl FileFormat for Npy {
    fn name(&self) -> &'static str {
        "NPY"
    }

    fn format(&self) -> &'static Format {
        &Format {
            name: "NumPy array",
            endings: &["npy"],
            holds: "one recording [C, T], [H, W] or [T, H, W]; for `taxel predict` also a batch [N, ...]",
            becomes: "as stored",
        }
    }

    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Sample> {
        let (file, mut reader, header) = open(path)?;
        sample::one(&header, &mut reader, &file, &options.limits)
    }
}

/// Reads one array.
pub(crate) fn array(path: &Path) -> Result<ArrayD<f32>> {
    let (file, mut reader, header) = open(path)?;
    header.read_f32(&mut reader, &file, Cap::of_samples(&Limits::default()), 1)
}

fn open(path: &Path) -> Result<(String, BufReader<File>, Header)> {
    let file = path.display().to_string();
    let mut reader = BufReader::new(File::open(path).map_err(Error::io(path))?);
    let header = read_header(&mut reader, &file)?;
    Ok((file, reader, header))
}
