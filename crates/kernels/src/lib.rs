//! CPU loops behind safe functions.
//!
//! Everything here works on plain slices in channels-last order (positions × channels), on one image
//! or one range of rows, in the calling thread. Threads, buffers and the order of operations are the
//! engine's business. This is the one crate that may hold `unsafe`; each block says why it is sound.
//!
//! Slices that do not fit the sizes are programming errors of the caller and panic with a message that names
//! the slice; no function reads or writes outside its slices. Safe functions that lead into unchecked loops
//! assert all lengths that those rely on before the first round.

pub mod activation;
pub mod adaptive_pool;
pub mod batch_norm;
mod buffer;
pub mod conv;
pub mod deviation;
pub mod double;
pub mod dropout;
mod fold;
pub mod frozen;
pub mod layout;
mod lengths;
pub mod loss;
pub mod lstm;
pub mod matmul;
pub mod optim;
pub mod pointwise;
pub mod pool;
pub mod reduce;
pub mod rocket;
mod rows;
pub mod simd;
mod tile;
mod view;
mod window;

pub use buffer::Buffer;
pub use view::{Rectifier, View};
pub use window::{Window3, axes3};
