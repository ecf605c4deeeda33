//! Where the rows of a table come from: text, or files of Parquet.

#[cfg(feature = "parquet")]
use crate::formats::parquet_file::ParquetFile;
use crate::formats::table::options::Clock;
use crate::formats::table::separators::Separators;

/// The rows of a table as they lie on disk.
pub(crate) enum RowSource {
    Csv {
        text: String,
        separators: Separators,
    },
    /// Of equal columns, one after the other.
    #[cfg(feature = "parquet")]
    Parquet(Vec<ParquetFile>),
}

impl RowSource {
    /// Checks whether decimals are written with commas.
    pub fn has_decimal_commas(&self) -> bool {
        matches!(self, Self::Csv { separators, .. } if separators.has_comma)
    }

    /// Checks whether a column holds numbers of more than 32 bits.
    pub fn is_wide(&self, at: usize) -> bool {
        match (self, at) {
            (Self::Csv { .. }, _) => true,
            #[cfg(feature = "parquet")]
            (Self::Parquet(files), at) => files.iter().any(|file| file.is_wide(at)),
        }
    }

    /// Returns the unit of the column `name`, where its type says that it holds time stamps.
    pub fn clock(&self, name: &str) -> Option<Clock> {
        match (self, name) {
            (Self::Csv { .. }, _) => None,
            #[cfg(feature = "parquet")]
            (Self::Parquet(files), name) => files.iter().find_map(|file| file.clock(name)),
        }
    }

    /// Returns the name of the format of the values.
    pub fn dtype(&self) -> &'static str {
        match self {
            Self::Csv { .. } => "csv",
            #[cfg(feature = "parquet")]
            Self::Parquet(_) => "parquet",
        }
    }

    /// Estimates the number of rows, at most as many as its bytes can hold.
    pub fn likely_rows(&self, channels: usize) -> usize {
        let (rows, values) = match self {
            // A value takes two bytes at least: a digit and a separator.
            Self::Csv { text, .. } => {
                (text.bytes().filter(|byte| *byte == b'\n').count() + 1, text.len() / 2)
            }
            #[cfg(feature = "parquet")]
            Self::Parquet(files) => files.iter().fold((0, 0), |(rows, values), file| {
                (rows + file.rows, usize::saturating_add(values, file.bytes))
            }),
        };
        rows.min(values / channels.max(1))
    }
}
