//! How little of the sensing and of a network suffices.
//!
//! [`shrink()`] takes a finished run and one of its networks or baselines and trains it again on less and less:
//! fewer channels or taxels, readings, bits, a shorter window, larger taxels, a narrower or shallower network. What
//! is left is chosen on inner folds of each training part, by the rule of [`taxel_judge::choose`]; the test
//! parts are predicted once for each setting and choose nothing. All knees together become a smaller model.
//!
//! ```no_run
//! use std::sync::atomic::AtomicBool;
//! use taxel_judge::Case;
//! use taxel_learn::{RunFolder, Silent};
//! use taxel_shrink::{Axis, ShrinkOptions, shrink};
//! use taxel_zoo::Registry;
//!
//! let (folder, registry) = (RunFolder::open("runs/glove".as_ref())?, Registry::built_in());
//! let (experiment, dataset) = taxel_trainer::open(&folder, &registry)?;
//! let case = Case::new(folder, dataset)?;
//! let options = ShrinkOptions { axes: vec![Axis::Sensors, Axis::Rate], ..ShrinkOptions::default() };
//! let finished = shrink(
//!     (&case, &experiment, &registry),
//!     "resnet8-lite-1d",
//!     "runs/glove-smaller".as_ref(),
//!     &options,
//!     &|estimate| println!("{} trainings", estimate.trainings),
//!     &Silent,
//!     &AtomicBool::new(false),
//! )?;
//! for curve in &finished.shrunk.curves {
//!     println!("{}", curve.words);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod axis;
mod cache;
mod chart;
mod combine;
mod curves;
mod error;
mod ladder;
mod options;
mod page;
mod plan;
mod ranking;
mod recordings;
mod sensors;
mod shrink;
mod shrunk;
mod small;
mod words;

pub use axis::Axis;
pub use error::{Error, Result};
pub use options::ShrinkOptions;
pub use page::shrunk_page;
pub use plan::Estimate;
pub use recordings::{curve_folds, learning_curve};
pub use shrink::{Finished, shrink};
pub use shrunk::{Combined, Curve, CurveStep, ModelSummary, Shrunk, SmallSpeed};
pub use words::{knee_words, shrunk_words};
