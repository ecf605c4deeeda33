//! MATLAB files of version 5 to 7.

pub(crate) mod mat;
pub(crate) mod reader;
pub(crate) mod text;
