//! The experiment that a data set starts with, where nobody wrote one.

mod budget;
mod families;
#[expect(clippy::module_inception, reason = "the experiment itself, which its folder is named after")]
mod start;

pub use start::Start;
