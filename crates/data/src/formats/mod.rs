//! File formats: each file reads one of them into arrays or tables.

pub(crate) mod archive;
pub(crate) mod arff;
pub(crate) mod array;
pub(crate) mod bag;
pub(crate) mod case;
pub(crate) mod clock;
pub(crate) mod csv_file;
pub(crate) mod hdf5;
pub(crate) mod hdf5_text;
pub(crate) mod image_file;
pub(crate) mod mat;
pub(crate) mod mat_text;
pub(crate) mod npy;
pub(crate) mod npy_text;
pub(crate) mod npz;
pub(crate) mod parquet_file;
pub(crate) mod parquet_pages;
pub(crate) mod stored;
pub(crate) mod table;
pub(crate) mod text;
pub(crate) mod timed;
pub(crate) mod ucr;
