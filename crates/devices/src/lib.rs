//! Graphs executed by candle.
//!
//! [`Model`] runs a [`Graph`](taxel_graph::Graph) with candle tensors: on accelerators (cargo features
//! `cuda` and `metal`), and on the CPU as the slow, independent oracle of the engine. Only operations
//! whose gradients candle gets right on a CPU are used; convolution and pooling are written as gathers
//! (`gather.rs`), because candle 0.11's own conv1d, max-pool and average-pool gradients are wrong there.

mod activation;
mod error;
mod gather;
mod lstm;
mod model;
mod objective;

pub use candle_core::Device;
pub use error::{Error, Result};
pub use model::Model;
