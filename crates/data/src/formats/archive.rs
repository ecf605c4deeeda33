//! An open file of named arrays, whatever its format.

use crate::formats::npy::{Cap, Header};
use crate::layout::order::natural;
use crate::{Error, Result};
use std::io::Read;

/// Takes the header of an array and the stream of its values; `at` names them in messages.
pub(crate) type Take<'t> = &'t mut dyn FnMut(&Header, &mut dyn Read, &str) -> Result<()>;

/// An open file of named arrays.
pub(crate) trait NamedArrays {
    /// Returns the path, as messages name it.
    fn file(&self) -> &str;

    /// Lists the arrays in the order in which they were saved.
    fn saved(&self) -> Vec<String>;

    /// Returns type and shape of an array; none of one that is not there or cannot be read.
    fn header(&mut self, array: &str) -> Option<Header>;

    /// Opens one array and hands it to `take`, but none that is not there.
    fn stream(&mut self, array: &str, at: &str, take: Take) -> Result<()>;

    /// Reads an array of texts that cannot be read as one of numbers; none of any other.
    fn texts(&mut self, _array: &str, _at: &str, _cap: Cap) -> Result<Option<Texts>> {
        Ok(None)
    }

    /// Checks whether labels are counted from 1.
    fn counts_from_one(&self) -> bool {
        false
    }
}

/// Texts, one after the other in rows `[N]` or `[N, k]`.
pub(crate) struct Texts {
    pub shape: Vec<u64>,
    pub values: Vec<String>,
}

impl Texts {
    /// Takes the texts of a cell array of MATLAB, which lie column by column.
    #[cfg(any(feature = "hdf5", feature = "matlab"))]
    pub fn of_cells(texts: &[String], rows: u64, columns: u64) -> Self {
        let shape = if rows.min(columns) == 1 { vec![rows * columns] } else { vec![rows, columns] };
        Self { shape, values: crate::formats::npy::by_rows(texts, rows as usize, columns as usize) }
    }
}

/// An open file of named arrays, whatever its format.
pub(crate) type Archive = dyn NamedArrays;

impl Archive {
    /// Lists the arrays in counting order.
    pub fn arrays(&self) -> Vec<String> {
        let mut arrays = self.saved();
        arrays.sort_by(|a, b| natural(a, b));
        arrays.dedup();
        arrays
    }

    /// Lists the arrays that could be one recording: numbers along two axes or more.
    pub fn recordings(&mut self) -> Vec<String> {
        let is_one =
            |h: Header| h.kind.is_some() && h.shape.len() > 1 && h.shape.iter().any(|axis| *axis > 1);
        self.arrays().into_iter().filter(|name| self.header(name).is_some_and(is_one)).collect()
    }

    /// Opens one array and hands its header and the stream of its values to `read`.
    pub fn with<T>(
        &mut self,
        array: &str,
        option: &'static str,
        read: impl FnOnce(&Header, &mut dyn Read, &str) -> Result<T>,
    ) -> Result<T> {
        let (mut read, mut out, at) = (Some(read), None, self.at(array));
        self.stream(array, &at, &mut |header, stream, at| {
            out = read.take().map(|read| read(header, stream, at)).transpose()?;
            Ok(())
        })?;
        out.ok_or_else(|| {
            let held = self.described();
            Error::missing(self.file(), array, &held, option)
        })
    }

    /// Returns the name of an array in messages.
    pub fn at(&self, array: &str) -> String {
        format!("{}: {array}", self.file())
    }

    /// Returns the shape of an array as stored; empty of one that cannot be read.
    pub fn shape(&mut self, array: &str) -> Vec<u64> {
        self.header(array).map_or(vec![], |header| header.shape)
    }

    /// Returns the entries along the first axis, or of a row; none of an array that cannot be read.
    pub fn entries(&mut self, array: &str) -> Option<u64> {
        self.header(array)?.as_column().shape.first().copied()
    }

    /// Describes the content of the file: name, type and shape of each array.
    pub fn described(&mut self) -> Vec<String> {
        let arrays = self.arrays();
        let mut form = |name: &str| self.header(name).map_or("(damaged)".into(), |header| header.described());
        arrays.iter().map(|name| format!("{name} {}", form(name))).collect()
    }
}
