//! Graphs executed by candle.
//!
//! [`Model`] runs a [`Graph`](taxel_graph::Graph) with candle tensors: on accelerators (cargo features
//! `cuda` and `metal`), and on the CPU as the slow, independent oracle of the engine. Only operations
//! whose gradients candle gets right on a CPU are used; convolution and pooling are written as gathers
//! (`gather.rs`), because candle 0.11's own conv1d, max-pool and average-pool gradients are wrong there.
//!
//! ```
//! use candle_core::Device;
//! use taxel_devices::Model;
//! use taxel_graph::{Network, Scheme, Weights};
//!
//! let net = Network::new("own");
//! let logits = net.input("signal", &[2, 10]).flatten().linear("fc", 3);
//! let graph = net.finish(&[("logits", logits)])?;
//! let weights = Weights::init(&graph, Scheme::Pytorch, 0, "own");
//!
//! // Four samples of two channels and ten readings.
//! let signal = vec![0.5; 4 * 2 * 10];
//! let outputs = Model::new(&graph, &weights, &Device::Cpu)?.forward(&[&signal], 4, false)?;
//! assert_eq!((outputs[0].0.as_str(), outputs[0].1.len()), ("logits", 4 * 3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod activation;
mod error;
mod gather;
mod model;
mod objective;
mod recurrent;

pub use candle_core::Device;
pub use error::{Error, Result};
pub use model::Model;
