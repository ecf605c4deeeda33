//! Everything between a command and the terminal: results, messages, tables, signals, panics.

mod boundary;
pub mod interrupt;
pub mod messages;
#[cfg(feature = "lab")]
pub mod progress;
#[cfg(feature = "lab")]
pub mod signals;
pub mod tables;

pub use boundary::guarded;
