//! One file per operation: its forward and backward pass on one sample, or on the whole batch.
//!
//! A sample's values lie as positions × channels. A layer sees its inputs through their views; a layer
//! itself holds no state that changes, so samples run in parallel.

mod activation;
mod adaptive_pool;
mod batch_layer;
mod build;
mod channels;
mod conv;
mod dropout;
mod layer;
mod layer_norm;
mod linear;
mod pool;
mod recurrent;
mod scale;
mod simple;
mod streams;

pub(crate) use batch_layer::{Batch, BatchBackward};
pub(crate) use build::{build, build_batch};
pub(crate) use conv::{read_tensor, write_tensor};
pub(crate) use layer::{Backward, Inputs, Layer, Outputs, Scratch, view};
