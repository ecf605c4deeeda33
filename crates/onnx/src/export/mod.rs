//! A network as an ONNX model.

mod emit;
mod front;
mod model;
mod sink;

pub use front::{Front, FrontStep};
pub use model::{Export, IR_VERSION, OPSET, PROBABILITIES, to_bytes, write};
