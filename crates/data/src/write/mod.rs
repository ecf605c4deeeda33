//! Data sets written to files.

pub(crate) mod archive;
#[cfg(feature = "mcap")]
pub(crate) mod bag;
pub(crate) mod convert;
pub(crate) mod save;
