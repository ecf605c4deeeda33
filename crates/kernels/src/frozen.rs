//! Loops for prediction, one sample at a time: weights lie in the order in which they are read,
//! values where their readers want them.
//!
//! All that a network computes between two stored values is one call: a convolution adds its bias and an addend and cuts
//! its outputs off before it stores them, inside the margins that the next convolution reads, among the channels that
//! a concatenation joins ([`ImagePlace`]).

pub mod bytes;
mod conv;
mod depthwise;
mod gru;
pub mod half;
mod linear;
mod lstm;
mod place;
mod pool;
mod rows;

pub use conv::{Conv, margins};
pub use depthwise::Depthwise;
pub use gru::Gru;
pub use linear::Linear;
pub use lstm::Lstm;
pub use place::{ImagePlace, Route};
pub use pool::{Pool, Pooling, Reach, parts, windows};
pub use rows::{add, copy, map};
