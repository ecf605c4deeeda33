//! CPU loops behind safe functions.
//!
//! Everything here works on plain slices in channels-last order (positions × channels), on one image
//! or one range of rows, in the calling thread. Threads, buffers and the order of operations are the
//! engine's business. This is the one crate that may hold `unsafe`; each block says why it is sound.
//!
//! Sizes that do not fit the slices are programming errors of the caller and panic by slice bounds;
//! no function reads or writes outside its slices.

pub mod activation;
pub mod adaptive_pool;
pub mod batch_norm;
mod buffer;
pub mod conv;
mod depthwise;
pub mod dropout;
mod fold;
pub mod layout;
pub mod loss;
pub mod lstm;
pub mod matmul;
pub mod optim;
pub mod pointwise;
pub mod pool;
pub mod reduce;
pub mod simd;
mod tile;
mod view;
mod window;
mod winograd;

pub use buffer::Buffer;
pub use view::{Rectifier, View};
pub use window::Window3;
