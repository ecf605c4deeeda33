//! An open file of named arrays: a `.npz` archive, a MATLAB file or HDF5.

use crate::formats::hdf5;
use crate::formats::hdf5_text;
use crate::formats::mat;
use crate::formats::mat_text;
use crate::formats::npy::{Cap, Header};
use crate::formats::npz;
use crate::{Error, Result};
use std::io::Read;
use std::path::Path;

/// The archive of a data set that is a folder.
pub(crate) const DATA: &str = "data.npz";

/// An open file of named arrays.
pub(crate) enum Archive {
    Npz(npz::Archive),
    Mat(mat::Archive),
    Hdf5(hdf5::Archive),
}

impl Archive {
    pub fn open(path: &Path) -> Result<Self> {
        if hdf5::is_named(path) {
            return hdf5::Archive::open(path).map(Self::Hdf5);
        }
        match mat::is_named(path) {
            true => mat::Archive::open(path).map(Self::Mat),
            false => npz::Archive::open(path).map(Self::Npz),
        }
    }

    /// Names, sorted.
    pub fn arrays(&self) -> &[String] {
        match self {
            Self::Npz(npz) => &npz.arrays,
            Self::Mat(mat) => &mat.arrays,
            Self::Hdf5(hdf5) => &hdf5.arrays,
        }
    }

    /// Names in the order in which arrays were saved.
    pub fn saved(&self) -> Vec<String> {
        match self {
            Self::Npz(npz) => npz.saved.clone(),
            Self::Mat(mat) => mat.saved(),
            Self::Hdf5(hdf5) => hdf5.saved(),
        }
    }

    /// Arrays that could be one recording, sorted.
    pub fn recordings(&self) -> Vec<String> {
        match self {
            Self::Npz(npz) => npz.arrays.clone(),
            Self::Mat(mat) => mat.recordings(),
            Self::Hdf5(hdf5) => hdf5.recordings(),
        }
    }

    /// Whether labels are counted from 1.
    pub fn counts_from_one(&self) -> bool {
        match self {
            Self::Npz(_) => false,
            Self::Mat(_) => true,
            Self::Hdf5(hdf5) => hdf5.is_matlab(),
        }
    }

    /// Opens one array and hands its header and the stream of its values to `read`.
    pub fn with<T>(
        &mut self,
        file: &str,
        array: &str,
        option: &'static str,
        read: impl FnOnce(&Header, &mut dyn Read, &str) -> Result<T>,
    ) -> Result<T> {
        if !self.arrays().iter().any(|name| name == array) {
            return Err(Error::missing(file, array, &self.described(), option));
        }
        let at = format!("{file}: {array}");
        match self {
            Self::Npz(npz) => npz.with(array, &at, read),
            Self::Mat(mat) => mat.with(array, &at, read),
            Self::Hdf5(hdf5) => hdf5.with(array, &at, read),
        }
    }

    /// The texts of a variable of MATLAB or HDF5 that is no array of numbers.
    pub fn texts(&mut self, file: &str, array: &str, cap: Cap) -> Result<Option<mat_text::Texts>> {
        match self {
            Self::Npz(_) => Ok(None),
            Self::Mat(mat) => mat_text::read(mat, array, &format!("{file}: {array}"), cap),
            Self::Hdf5(hdf5) => hdf5_text::read(hdf5, array, &format!("{file}: {array}"), cap),
        }
    }

    /// Shape of an array as stored; empty of one that cannot be read.
    pub fn shape(&mut self, array: &str) -> Vec<u64> {
        self.with("", array, "x", |header, _, _| Ok(header.shape.clone())).unwrap_or_default()
    }

    /// Whether an array has rows and columns: more than one number per sample, or what looks like it.
    pub fn is_table(&mut self, array: &str) -> bool {
        self.with("", array, "x", |header, _, _| Ok(header.as_column().shape.len() != 1 && !header.matlab))
            .unwrap_or(false)
    }

    /// Entries along the first axis, or of a row; none of one that cannot be read.
    pub fn entries(&mut self, array: &str) -> Option<u64> {
        self.with("", array, "y", |header, _, _| Ok(header.as_column().shape.first().copied())).ok().flatten()
    }

    /// What the file holds: name, type and shape of each array.
    pub fn described(&mut self) -> Vec<String> {
        match self {
            Self::Npz(npz) => npz.described(),
            Self::Mat(mat) => mat.described(),
            Self::Hdf5(hdf5) => hdf5.described(),
        }
    }
}
