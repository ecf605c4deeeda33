//! The reader of HDF5: its data sets as named arrays.

use crate::Result;
use crate::formats::archive::{self, NamedArrays, Take, Texts};
use crate::formats::hdf5::hdf5::{Archive, Values, Variable, damaged};
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

/// Opens a file, of MATLAB's version 7.3 too.
pub(crate) fn open(path: &Path) -> Result<archive::Archive> {
    Archive::open(path).map(archive::Archive::new)
}

impl NamedArrays for Archive {
    /// Numbers, and more than one.
    fn recordings(&self) -> Vec<String> {
        let is_one =
            |h: &Header| h.kind.is_some() && h.shape.len() > 1 && h.shape.iter().any(|axis| *axis > 1);
        self.variables.iter().filter(|v| is_one(&v.header)).map(|v| v.name.clone()).collect()
    }

    fn described(&mut self) -> Vec<String> {
        self.variables.iter().map(|v| format!("{} {}", v.name, v.header.described())).collect()
    }

    /// Names in counting order: files do not say in which order they were written.
    fn saved(&self) -> Vec<String> {
        self.variables.iter().map(|v| v.name.clone()).collect()
    }

    fn with(&mut self, name: &str, place: &str, take: Take) -> Result<()> {
        let Some(Variable { dataset, header, .. }) = self.variable(name) else { return Ok(()) };
        let bytes = header.shape.iter().try_fold(header.size as u64, |all, axis| all.checked_mul(*axis));
        if bytes.is_none_or(|bytes| bytes > self.most) {
            return Err(damaged(place, "it says that it holds more than the file has bytes for"));
        }
        match header.size {
            1 => take(header, &mut Values::<1>::new(dataset), place),
            2 => take(header, &mut Values::<2>::new(dataset), place),
            4 => take(header, &mut Values::<4>::new(dataset), place),
            8 => take(header, &mut Values::<8>::new(dataset), place),
            _ => take(header, &mut io::empty(), place),
        }
    }

    fn texts(&mut self, array: &str, at: &str, cap: Cap) -> Result<Option<Texts>> {
        text::read(self, array, at, cap)
    }

    /// As MATLAB counts.
    fn counts_from_one(&self) -> bool {
        self.is_matlab
    }
}
