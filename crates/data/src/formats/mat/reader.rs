//! The reader of MATLAB files, whose variables are named arrays.

use crate::Result;
use crate::formats::archive::{Archive, NamedArrays, Take, Texts};
use crate::formats::mat::mat::{MatArchive, damaged};
use crate::formats::mat::text;
use crate::formats::npy::{Cap, Header};
use crate::layout::arrays::{ArrayFile, OneArray};
use crate::reader::Format;
use std::path::Path;

/// Reads files of MATLAB; those of version 7.3 are HDF5.
pub(crate) const MAT: ArrayFile = ArrayFile {
    format: &Format {
        name: "MATLAB file",
        endings: &["mat"],
        holds: "variables as the arrays of a NumPy archive, of version 5 to 7.3, samples along the first axis \
                (`permute`); in a folder of recordings one array each, or that of `data.x`",
        becomes: "as stored; classes are named `1`, `2`, ..., by the texts or by `labels.json`",
    },
    inside: None,
    recording: Some(OneArray {
        name: "MAT",
        hint: " but for time (channels, time): use the same channels throughout",
    }),
    open: |path| match open_hdf5(path) {
        Some(held) => held,
        None => Ok(Box::new(MatArchive::open(path)?)),
    },
};

/// Opens a file that is HDF5 by its first bytes.
#[cfg(feature = "hdf5")]
fn open_hdf5(path: &Path) -> Option<Result<Box<Archive>>> {
    use crate::formats::hdf5::{hdf5, reader};
    hdf5::is_hdf5(path).then(|| reader::open(path))
}

/// Refuses a file that is HDF5 by its first bytes: this build does without.
#[cfg(not(feature = "hdf5"))]
fn open_hdf5(path: &Path) -> Option<Result<Box<Archive>>> {
    use std::io::Read;
    let file = path.display().to_string();
    let mut start = [0; 10];
    std::fs::File::open(path).ok()?.read_exact(&mut start).ok()?;
    let is_hdf5 = start.starts_with(b"\x89HDF") || start == *b"MATLAB 7.3";
    is_hdf5.then_some(Err(crate::Error::NotBuilt { file, feature: "hdf5" }))
}

impl NamedArrays for MatArchive {
    fn file(&self) -> &str {
        &self.file
    }

    fn saved(&self) -> Vec<String> {
        self.variables.iter().map(|v| v.name.clone()).collect()
    }

    fn header(&mut self, array: &str) -> Option<Header> {
        self.variables.iter().find(|v| v.name == array).map(|v| v.header.clone())
    }

    fn stream(&mut self, name: &str, place: &str, take: Take) -> Result<()> {
        let Some((at, element)) = self.element_of(name)? else { return Ok(()) };
        match element.variable().map_err(|why| why.at(place, at))? {
            Some((_, header, mut values)) => take(&header, &mut values, place),
            None => Err(damaged(place, "has changed while it was read")),
        }
    }

    fn texts(&mut self, array: &str, at: &str, cap: Cap) -> Result<Option<Texts>> {
        text::read(self, array, at, cap)
    }

    fn counts_from_one(&self) -> bool {
        true
    }
}
