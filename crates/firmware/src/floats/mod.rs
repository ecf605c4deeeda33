//! Networks in 32-bit floats: their layers, from the runtime's steps to C.

pub(crate) mod in_place;
pub(crate) mod layer;
pub(crate) mod lower;
pub(crate) mod source;
