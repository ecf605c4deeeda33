//! File formats, and the list of all readers in the order in which they are tried.
//!
//! A new format is a file here and a line in [`READERS`].

use crate::layout::files::OnePerFile;
use crate::layout::folder::Folder;
use crate::reader::{Format, Reader};

pub(crate) mod archive;
pub(crate) mod bag;
pub(crate) mod clock;
pub(crate) mod csv_file;
pub(crate) mod csv_text;
#[cfg(feature = "hdf5")]
pub(crate) mod hdf5;
#[cfg(feature = "image")]
pub(crate) mod image_file;
pub(crate) mod json_columns;
pub(crate) mod json_lines;
pub(crate) mod json_numbers;
pub(crate) mod json_time_step;
#[cfg(feature = "matlab")]
pub(crate) mod mat;
pub(crate) mod names;
pub(crate) mod npy;
pub(crate) mod npy_file;
pub(crate) mod npy_text;
pub(crate) mod npz;
pub(crate) mod odd_lines;
#[cfg(feature = "parquet")]
pub(crate) mod parquet_cells;
#[cfg(feature = "parquet")]
pub(crate) mod parquet_file;
#[cfg(feature = "parquet")]
pub(crate) mod parquet_pages;
pub(crate) mod stamps;
pub(crate) mod stored;
pub(crate) mod table;
pub(crate) mod text;
pub(crate) mod timed;
pub(crate) mod ucr;

/// Every reader; the first that recognises a place reads it. Of files of one ending, sets come before single recordings.
pub(crate) const READERS: &[&dyn Reader] = &[
    &npy_file::NpyBatch,
    &ucr::ucr::Ucr,
    #[cfg(feature = "parquet")]
    &crate::layout::lerobot::LeRobot,
    &npz::NPZ,
    &table::table::TEXT,
    #[cfg(feature = "parquet")]
    &table::table::PARQUET,
    &OnePerFile(csv_file::Csv),
    &OnePerFile(npy_file::Npy),
    &OnePerFile(json_lines::JsonLines),
    #[cfg(feature = "matlab")]
    &mat::reader::MAT,
    #[cfg(feature = "hdf5")]
    &hdf5::reader::HDF5,
    #[cfg(feature = "mcap")]
    &OnePerFile(bag::bags::Bag),
    #[cfg(feature = "image")]
    &OnePerFile(image_file::ImageFile),
    #[cfg(not(all(
        feature = "hdf5",
        feature = "image",
        feature = "matlab",
        feature = "mcap",
        feature = "parquet"
    )))]
    &crate::layout::not_built::NotBuilt,
    &Folder,
];

/// Lists the formats that this build reads, in the order in which readers are tried: the table of `docs/data.md`.
pub fn formats() -> impl Iterator<Item = &'static Format> {
    READERS.iter().flat_map(|reader| reader.formats())
}
