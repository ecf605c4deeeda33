//! How little of the sensing and of a network suffices.
//!
//! [`shrink()`] takes a finished run and one of its networks or baselines and trains it again on less and less:
//! fewer channels or taxels, readings, bits, a shorter window, larger taxels, a narrower or shallower network. What
//! is left is chosen on inner folds of each training part, by the rule of [`taxel_judge::choose`]; the test
//! parts are asked once for each setting and choose nothing. All knees together become a smaller model.

mod axis;
mod combine;
mod curves;
mod desk;
mod error;
mod ladder;
mod options;
mod plan;
mod ranking;
mod sensors;
mod shrink;
mod small;

pub use axis::Axis;
pub use error::{Error, Result};
pub use options::Options;
pub use plan::Estimate;
pub use shrink::{Finished, shrink};
