//! One series of the UCR and UEA archives, as written.

use crate::{Error, Result};

/// Class name and channels.
pub(crate) struct Case {
    pub class: String,
    pub channels: Vec<Vec<f32>>,
}

/// Reads a number of a text file; `column` counts from 1.
pub(crate) fn number(text: &str, file: &str, line: usize, column: usize) -> Result<f32> {
    text.trim().parse().map_err(|_| Error::CsvNumber {
        file: file.into(),
        line: line as u64,
        column,
        text: text.chars().take(40).collect(),
        hint: if text.trim() == "?" { "; series with missing values are not supported" } else { "" },
    })
}
