//! Networks as ONNX: [`write()`] for other runtimes, [`read`] from other frameworks.
//!
//! ```
//! use taxel_graph::{Conv, Network, Scheme, Weights};
//! use taxel_onnx::Export;
//!
//! let net = Network::new("tiny");
//! let signal = net.input("signal", &[5, 50]);
//! let features = signal.conv_bn_relu("stem", Conv::new(8, 3).same()).global_average_pool();
//! let graph = net.finish(&[("logits", features.linear("fc", 3))])?;
//! let weights = Weights::init(&graph, Scheme::Pytorch, 0, "doc");
//!
//! let bytes = taxel_onnx::to_bytes(&Export::new(&graph, &weights))?;
//! let read = taxel_onnx::from_bytes(bytes, "tiny", None)?;
//! assert_eq!((read.graph, read.weights), (graph, weights));
//! # Ok::<(), taxel_onnx::Cause>(())
//! ```
//!
//! Files are of opset 17, IR version 8, with a batch axis of any size. The table in `docs/onnx.md` says which operation
//! becomes which, and which ones of other frameworks are read.

mod bounds;
mod error;
mod export;
mod import;
mod proto;

pub use error::{Cause, Error, Result};
pub use export::{
    Code, CodeRow, DISTANCE, DISTANCES, Export, Front, FrontStep, GatePlace, IR_VERSION, OPSET,
    PROBABILITIES, QUANTITIES, READINGS_DISTANCE, ReadingsPlace, RocketConv, RocketFeatures, TEMPERATURE,
    UNKNOWN_BEYOND, VALUES, to_bytes, write,
};
pub use import::{Imported, from_bytes, read};
