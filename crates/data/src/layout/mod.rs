//! Layouts: how files in folders, and arrays in a file, make a data set.

pub(crate) mod arrays;
pub(crate) mod folder;
pub(crate) mod label_table;
pub(crate) mod lerobot;
pub(crate) mod listing;
pub(crate) mod names_file;
pub(crate) mod order;
pub(crate) mod roles;
pub(crate) mod sample;
