//! Fitted arrays that come back from a file.

use std::collections::BTreeMap;

use crate::{Error, Result};

/// Named arrays, as [`Fitted::tensors`](crate::Fitted::tensors) gives them.
#[derive(Debug, Clone, Default)]
pub struct Saved<'a> {
    arrays: BTreeMap<String, &'a [f32]>,
}

impl<'a> Saved<'a> {
    /// Adds an array.
    pub fn insert(&mut self, name: &str, values: &'a [f32]) {
        self.arrays.insert(name.into(), values);
    }

    pub(crate) fn get(&self, name: &str) -> Result<&'a [f32]> {
        let missing = || Error::Saved { tensor: name.into(), reason: "is not there" };
        self.arrays.get(name).copied().ok_or_else(missing)
    }

    pub(crate) fn sized(&self, name: &str, len: usize) -> Result<&'a [f32]> {
        let values = self.get(name)?;
        if values.len() == len {
            Ok(values)
        } else {
            Err(Error::Saved { tensor: name.into(), reason: "has another size" })
        }
    }

    pub(crate) fn one(&self, name: &str) -> Result<f32> {
        Ok(self.sized(name, 1)?[0])
    }

    /// Returns whole rows of `width`.
    pub(crate) fn rows(&self, name: &str, width: usize) -> Result<&'a [f32]> {
        let values = self.get(name)?;
        if values.len().is_multiple_of(width.max(1)) {
            Ok(values)
        } else {
            Err(Error::Saved { tensor: name.into(), reason: "has another size" })
        }
    }

    /// Returns whole rows of `width` finite numbers.
    pub(crate) fn finite_rows(&self, name: &str, width: usize) -> Result<&'a [f32]> {
        let values = self.rows(name, width)?;
        if values.iter().all(|value| value.is_finite()) {
            Ok(values)
        } else {
            Err(Error::Saved { tensor: name.into(), reason: "is not finite" })
        }
    }
}
