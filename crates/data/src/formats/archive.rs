//! An open file of named arrays, whatever its format.

use crate::formats::npy::{Cap, Header};
use crate::{Error, Result};
use std::io::Read;

/// Takes the header of an array and the stream of its values; `at` names them in messages.
pub(crate) type Take<'t> = &'t mut dyn FnMut(&Header, &mut dyn Read, &str) -> Result<()>;

/// What a format of named arrays has to answer.
pub(crate) trait NamedArrays {
    /// Names in the order in which arrays were saved.
    fn saved(&self) -> Vec<String>;

    /// Arrays that could be one recording, sorted.
    fn recordings(&self) -> Vec<String>;

    /// Name, type and shape of each array.
    fn described(&mut self) -> Vec<String>;

    /// Opens one array and hands it to `take`.
    fn with(&mut self, array: &str, at: &str, take: Take) -> Result<()>;

    /// The texts of an array of texts that is none of numbers; none of any other.
    fn texts(&mut self, _array: &str, _at: &str, _cap: Cap) -> Result<Option<Texts>> {
        Ok(None)
    }

    /// Whether labels are counted from 1.
    fn counts_from_one(&self) -> bool {
        false
    }
}

/// Texts, one after the other in rows `[N]` or `[N, k]`.
pub(crate) struct Texts {
    pub shape: Vec<u64>,
    pub values: Vec<String>,
}

/// An open file of named arrays.
pub(crate) struct Archive {
    held: Box<dyn NamedArrays>,
    arrays: Vec<String>,
}

impl Archive {
    pub fn new(held: impl NamedArrays + 'static) -> Self {
        let mut arrays = held.saved();
        arrays.sort();
        arrays.dedup();
        Self { held: Box::new(held), arrays }
    }

    /// Names, sorted.
    pub fn arrays(&self) -> &[String] {
        &self.arrays
    }

    /// Names in the order in which arrays were saved.
    pub fn saved(&self) -> Vec<String> {
        self.held.saved()
    }

    /// Arrays that could be one recording, sorted.
    pub fn recordings(&self) -> Vec<String> {
        self.held.recordings()
    }

    /// Whether labels are counted from 1.
    pub fn counts_from_one(&self) -> bool {
        self.held.counts_from_one()
    }

    /// Opens one array and hands its header and the stream of its values to `read`.
    pub fn with<T>(
        &mut self,
        file: &str,
        array: &str,
        option: &'static str,
        read: impl FnOnce(&Header, &mut dyn Read, &str) -> Result<T>,
    ) -> Result<T> {
        let (mut read, mut out) = (Some(read), None);
        if self.arrays.iter().any(|name| name == array) {
            self.held.with(array, &format!("{file}: {array}"), &mut |header, stream, at| {
                out = read.take().map(|read| read(header, stream, at)).transpose()?;
                Ok(())
            })?;
        }
        out.ok_or_else(|| Error::missing(file, array, &self.described(), option))
    }

    /// The texts of a variable of MATLAB or HDF5 that is no array of numbers.
    pub fn texts(&mut self, file: &str, array: &str, cap: Cap) -> Result<Option<Texts>> {
        self.held.texts(array, &format!("{file}: {array}"), cap)
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
        self.held.described()
    }
}
