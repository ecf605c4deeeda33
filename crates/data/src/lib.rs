//! Recordings on disk: reading, checking, cards, splits, augmentation.
//!
//! [`load`] turns a `.npz`, a CSV table, a folder with `data.npz`, or a folder with one sub-folder per class
//! into a [`Dataset`]; [`check`] reads the same layouts tolerantly and returns a [`Card`] of their content
//! and their problems; [`stratified_k_fold`] and [`group_k_fold`]
//! cut the samples into [`Fold`]s without cutting duplicates or groups; [`Augment`] changes training
//! samples at random.
//!
//! [`Dataset::new`] takes arrays that are in memory already. Either way the facts stay with the samples: their axes, shape
//! and unit ([`SampleSpec`]), whether they were simulated or recorded ([`Source`]), the meaning of their labels ([`Labels`]).
//!
//! ```
//! use ndarray::Array3;
//! use taxel_data::{Dataset, Layout, stratified_k_fold};
//!
//! // Six grasps of 5 channels and 50 time steps each, of two objects.
//! let grasps = Array3::from_shape_fn((6, 5, 50), |(i, channel, t)| (i * channel + t) as f32);
//! let objects = ["pear", "apple", "pear", "apple", "pear", "apple"];
//! let data = Dataset::new("glove", Layout::Series, grasps.into_dyn(), &objects)?
//!     .with_groups(&[1, 1, 2, 2, 3, 3])?
//!     .with_unit("N")
//!     .with_rate(100.0)?
//!     .with_full_scale(100.0)?;
//! assert_eq!((data.output_names(), data.strata()[0]), (vec!["apple".to_string(), "pear".into()], 1));
//! assert_eq!(data.source.to_string(), "real: glove");
//! assert_eq!((data.spec.shape.as_slice(), data.spec.rate), ([5, 50].as_slice(), Some(100.0)));
//! let folds = stratified_k_fold(&data.strata(), 3, 0, 0, data.units.as_deref())?;
//! assert_eq!(data.select(&folds[0].test).class_counts(), [1, 1]);
//! # Ok::<(), taxel_data::Error>(())
//! ```
//!
//! Every message names the file, the array and the sample, the value, and how to fix it.

mod augment;
mod check;
mod compare;
mod dataset;
mod ending;
mod error;
mod formats;
mod layout;
mod length;
mod load;
mod options;
mod reader;
mod recordings;
mod split;
mod tare;
mod targets;
mod unit;
mod write;

pub use augment::{Augment, Key, ReadingsChange, Warp};
pub use check::beginning::{Beginning, EarlyClass};
pub use check::card::{Card, ClassCount, Contradiction, GroupSummary};
pub use check::drift::Drift;
pub use check::duplicates::duplicate_sets;
pub use check::quantities::QuantitySummary;
pub use check::shortcut::{Carrier, Shortcut};
pub use check::values::ChannelRange;
pub use compare::{FactComparison, FactDifference};
pub use dataset::dataset::Dataset;
pub use dataset::digest::{RowHash, digest_of, hash_row, hash_words};
pub use dataset::facts::Facts;
pub use dataset::labels::{Attribute, Labels};
pub use dataset::sample_spec::SampleSpec;
pub use dataset::source::{Source, SourceKind};
pub use dataset::target_steps::TargetSteps;
pub use dataset::targets::{Quantity, Targets, Task, Values};
pub use error::{Class, Error, Result};
#[cfg(feature = "mcap")]
pub use formats::bag::messages::{BagMessages, bag_messages};
pub use formats::bag::path::is_bag;
pub use formats::clock::interpolate;
pub use formats::formats;
pub use formats::table::column_kind::numbers_columns;
pub use formats::table::column_name::ColumnName;
pub use formats::table::options::{Clock, NotATable, TableForm, TableOptions};
pub use formats::table::time_text::seconds as seconds_of_date;
pub use length::length::{CropPart, Length, Longer, NotALength, Padding};
pub use length::lengths::Lengths;
pub use load::{Survey, check, check_with, exists, load, read_npy, survey};
pub use options::{Drop, Limits, ReadOptions};
pub use reader::Format;
pub use recordings::{
    Recording, RecordingFacts, Recordings, are_bags, are_images, recordings, whole_recordings,
};
pub use split::{
    Fold, Shares, chronological_split, few_per_class, group_k_fold, hold_back, random_group_split,
    random_split, stratified_k_fold,
};
pub use tare::{NotATare, Tare};
pub use targets::event::{Event, NotAnEvent};
pub use targets::options::{TargetNames, TargetOf, TaskKind};
pub use taxel_base::Layout;
pub use taxel_base::files::{PART, write_whole};
pub use unit::UnitFactor;
pub use write::archive::{Npz, npy_bytes};
#[cfg(feature = "mcap")]
pub use write::bag::{BAG_TOPIC, bag_bytes};
pub use write::convert::{Converted, convert};
