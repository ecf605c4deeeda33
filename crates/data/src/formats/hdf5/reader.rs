//! The reader of HDF5, whose data sets are named arrays.

use crate::Result;
use crate::formats::archive::{Archive, NamedArrays, Take, Texts};
use crate::formats::hdf5::hdf5::{Hdf5Archive, ValueStream, Variable, damaged};
use crate::formats::hdf5::text;
use crate::formats::npy::{Cap, Header};
use crate::layout::arrays::{ArrayFile, OneArray};
use crate::reader::Format;
use std::io;
use std::path::Path;

/// Reads files of HDF5.
pub(crate) const HDF5: ArrayFile = ArrayFile {
    format: &Format {
        name: "HDF5",
        endings: &["h5", "hdf5"],
        holds: "data sets as the arrays of a NumPy archive, in groups by their path, `day1/x`; in a folder of \
                recordings one array each, or that of `data.x`",
        becomes: "as stored",
    },
    inside: None,
    recording: Some(OneArray { name: "HDF5", hint: " but for time" }),
    open,
};

/// Opens a file, also of MATLAB's version 7.3.
pub(crate) fn open(path: &Path) -> Result<Box<Archive>> {
    Ok(Box::new(Hdf5Archive::open(path)?))
}

impl NamedArrays for Hdf5Archive {
    fn file(&self) -> &str {
        &self.file
    }

    /// Lists arrays in counting order: files do not say in which order they were written.
    fn saved(&self) -> Vec<String> {
        self.variables.iter().map(|v| v.name.clone()).collect()
    }

    fn header(&mut self, array: &str) -> Option<Header> {
        self.variable(array).map(|variable| variable.header.clone())
    }

    fn stream(&mut self, name: &str, place: &str, take: Take) -> Result<()> {
        let Some(Variable { dataset, header, .. }) = self.variable(name) else { return Ok(()) };
        let bytes = header.shape.iter().try_fold(header.size as u64, |all, axis| all.checked_mul(*axis));
        if bytes.is_none_or(|bytes| bytes > self.most) {
            return Err(damaged(place, "it says that it holds more than the file has bytes for"));
        }
        match header.size {
            1 => take(header, &mut ValueStream::<1>::new(dataset), place),
            2 => take(header, &mut ValueStream::<2>::new(dataset), place),
            4 => take(header, &mut ValueStream::<4>::new(dataset), place),
            8 => take(header, &mut ValueStream::<8>::new(dataset), place),
            _ => take(header, &mut io::empty(), place),
        }
    }

    fn texts(&mut self, array: &str, at: &str, cap: Cap) -> Result<Option<Texts>> {
        text::read(self, array, at, cap)
    }

    /// Checks whether the file is MATLAB's, which counts from 1.
    fn counts_from_one(&self) -> bool {
        self.is_matlab
    }
}
