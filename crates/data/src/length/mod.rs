//! Recordings of any length, and the rules that bring them to one.

pub(crate) mod cut;
pub(crate) mod length;
pub(crate) mod lengths;
pub(crate) mod one_length;
pub(crate) mod ragged;
