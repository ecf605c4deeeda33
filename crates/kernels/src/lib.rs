//! CPU loops behind safe functions.
//!
//! Everything here works on plain slices in channels-last order (positions × channels), on one image
//! or one range of rows, in the calling thread. Threads, buffers and the order of operations are the
//! engine's business. This is the one crate that may hold `unsafe`; each block says why it is sound.
//!
//! Slices that do not fit the sizes are programming errors of the caller and panic with a message that names
//! the slice; no function reads or writes outside its slices. Safe functions that lead into unchecked loops
//! assert all lengths that those rely on before the first round.
//!
//! ```
//! use taxel_kernels::matmul::{Matrix, matmul};
//!
//! // Two readings of three taxels, times weights of two outputs: [2, 3] x [3, 2].
//! let readings = [1.0, 0.0, 2.0, 0.0, 3.0, 1.0];
//! let weights = [1.0, -1.0, 0.5, 2.0, 0.0, 1.0];
//! let mut out = [0.0; 4];
//! matmul(&mut out, 2, Matrix::new(&readings, 2, 3), Matrix::new(&weights, 3, 2), false);
//! assert_eq!(out, [1.0, 1.0, 1.5, 7.0]);
//! ```

pub mod activation;
pub mod adaptive_pool;
mod baselines;
pub mod batch_norm;
mod buffer;
pub mod conv;
pub mod deviation;
pub mod dropout;
mod fold;
pub mod frozen;
pub mod half;
pub mod layer_norm;
pub mod layout;
mod lengths;
pub mod loss;
pub mod matmul;
pub mod optim;
pub mod pointwise;
pub mod pool;
mod recurrent;
pub mod reduce;
mod rows;
pub mod simd;
mod tile;
mod view;
mod window;

pub use baselines::{double, rocket};
pub use buffer::Buffer;
pub use recurrent::{gru, lstm};
pub use view::{AffineView, Rectifier};
pub use window::{Window3, axes3};
