//! A network as an ONNX model.

mod code;
mod emit;
mod front;
mod gate;
mod history;
mod model;
mod readings;
mod recurrent;
mod rocket;
mod sink;
mod value;

pub use code::{Code, CodeRow};
pub use front::{Front, FrontStep};
pub use gate::{DISTANCE, DISTANCES, GatePlace};
pub use model::{Export, IR_VERSION, OPSET, PROBABILITIES, QUANTITIES, TEMPERATURE, VALUES, to_bytes, write};
pub use readings::{READINGS_DISTANCE, ReadingsPlace, UNKNOWN_BEYOND};
pub use rocket::{RocketConv, RocketFeatures};
