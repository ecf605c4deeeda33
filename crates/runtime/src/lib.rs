//! Networks frozen for prediction.
//!
//! [`Frozen`] is a graph with its weights, changed into the form that predicts fastest: batch norms are folded into the
//! convolutions before them, rectifiers and sums happen before outputs are stored, weights lie in the order in which they
//! are read, and values lie where their readers want them, inside margins and among the channels of a
//! concatenation. It never changes: threads share one, each with a [`Workspace`] of its own, and no prediction allocates.
//!
//! ```
//! use taxel_reference_networks::MlpConfig;
//! use taxel_graph::{Architecture, Scheme, Weights};
//! use taxel_runtime::Frozen;
//!
//! let graph = MlpConfig { classes: 2, in_features: 4, hidden: 8 }.graph()?;
//! let weights = Weights::init(&graph, Scheme::Pytorch, 0, "doc");
//! let frozen = Frozen::new(&graph, &weights)?;
//! let mut workspace = frozen.workspace();
//! let logits = frozen.predict(&mut workspace, &[&[1.0, 0.0, 0.0, 0.5]])?;
//! assert_eq!(logits.len(), 2);
//! # Ok::<(), taxel_runtime::Error>(())
//! ```
//!
//! [`Frozen::half`] is the same with products of bf16, where the processor has them. [`Frozen::quantized`] is the same in eight bits, which an [`Observer`] has prepared with samples like those that will
//! be asked about. A [`Blueprint`] is the same network as a list of steps with their places, for those who write it down in
//! another language.
//!
//! Logits differ from those of `taxel-engine` in the last bits: norms that are folded in are rounded elsewhere.

mod bands;
mod blueprint;
mod byte_kernel;
mod dense;
mod error;
mod frozen;
mod lower;
mod memory;
mod merge;
mod observer;
mod pair;
mod places;
mod program;
mod quantize;
mod ranges;
mod step;
mod weights;
mod winograd;

pub use blueprint::{
    Blueprint, PlannedConv, PlannedFloatConv, PlannedFloatLinear, PlannedLstm, PlannedOp, PlannedStep,
    has_fused_products,
};
pub use error::{Error, Result};
pub use frozen::{Frozen, Workspace};
pub use observer::Observer;
pub use ranges::Ranges;
