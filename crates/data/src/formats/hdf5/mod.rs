//! HDF5, of MATLAB's version 7.3 too.

pub(crate) mod hdf5;
pub(crate) mod reader;
pub(crate) mod text;
