//! A network as an ONNX model.

mod emit;
mod front;
mod gate;
mod model;
mod sink;
mod value;

pub use front::{Front, FrontStep};
pub use gate::{DISTANCE, DISTANCES, GatePlace};
pub use model::{Export, IR_VERSION, OPSET, PROBABILITIES, QUANTITIES, TEMPERATURE, VALUES, to_bytes, write};
