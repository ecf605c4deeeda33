//! Layouts: how files in folders, and arrays in a file, make a data set.

pub(crate) mod array_labels;
pub(crate) mod array_targets;
pub(crate) mod arrays;
pub(crate) mod class_folders;
pub(crate) mod files;
pub(crate) mod folder;
pub(crate) mod label_table;
#[cfg(feature = "parquet")]
pub(crate) mod lerobot;
#[cfg(feature = "parquet")]
pub(crate) mod lerobot_meta;
pub(crate) mod listing;
pub(crate) mod names_file;
#[cfg(not(all(
    feature = "hdf5",
    feature = "image",
    feature = "matlab",
    feature = "mcap",
    feature = "parquet"
)))]
pub(crate) mod not_built;
pub(crate) mod order;
pub(crate) mod readings;
pub(crate) mod resting;
pub(crate) mod roles;
pub(crate) mod sample;
pub(crate) mod split_part;
