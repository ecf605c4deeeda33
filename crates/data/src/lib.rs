//! Recordings on disk: reading, checking, cards, splits, augmentation.
//!
//! [`load`] turns a `.npz`, a folder with `data.npz`, or a folder with one sub-folder per class
//! into a [`Dataset`]; [`check`] reads the same layouts tolerantly and returns a [`Card`] that
//! says what is in them and what is wrong with them; [`stratified_k_fold`] and [`group_k_fold`]
//! cut the samples into [`Fold`]s that no duplicate and no group straddles; [`Augment`] reflects,
//! moves, scales and turns training images.
//!
//! Every message names the file, the array and the sample, the value, and the way out.

mod array;
mod arrays;
mod augment;
mod card;
mod card_text;
mod csv_file;
mod dataset;
mod duplicates;
mod error;
mod folder;
mod image_file;
mod labels;
mod load;
mod mat;
mod npy;
mod npz;
mod options;
mod raw;
mod shortcut;
mod split;
mod ucr;
mod validate;
mod values;
mod write;

pub use array::read_npy;
pub use augment::{Augment, Key, Warp};
pub use card::{Card, ChannelRange, ClassCount, Contradiction, GroupSummary};
pub use dataset::{Axes, Dataset, RowHash};
pub use duplicates::duplicate_sets;
pub use error::{Error, Result};
pub use load::{check, check_with, load};
pub use options::{Drop, Limits, Options};
pub use shortcut::Shortcut;
pub use split::{
    Fold, Shares, few_per_class, group_k_fold, hold_back, random_group_split, random_split, stratified_k_fold,
};
pub use taxel_files::{PART, write_whole};
pub use write::{Npz, npy_bytes};
