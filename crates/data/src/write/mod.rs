//! Data sets written to files.

pub(crate) mod archive;
pub(crate) mod convert;
pub(crate) mod save;
