//! Random changes of training samples.

#[expect(clippy::module_inception, reason = "the settings, which its folder is named after")]
mod augment;
mod readings;
mod warp;

pub use augment::{Augment, Key};
pub use readings::ReadingsChange;
pub use warp::Warp;
