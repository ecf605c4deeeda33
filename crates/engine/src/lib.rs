//! Graphs compiled for training on the CPU.
//!
//! [`Engine::new`] lays a graph out for a largest batch: buffers are allocated once, values lie
//! channels last, gradients are computed only where a parameter needs them. A training step is
//! [`Engine::forward`] in [`Mode::Train`], [`Engine::backward`] and [`Engine::sgdm`] or another optimiser:
//!
//! ```
//! use taxel_comparators::MlpConfig;
//! use taxel_engine::{Engine, Mode, Options, Sgdm};
//! use taxel_graph::{Architecture, Scheme, Weights};
//!
//! let graph = MlpConfig { classes: 2, in_features: 4, hidden: 8 }.graph()?;
//! let weights = Weights::init(&graph, Scheme::Pytorch, 0, "doc");
//! let mut engine = Engine::new(&graph, &weights, Options { batch: 2, threads: 1, ..Options::default() })?;
//! let x = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
//! let step = Sgdm { lr: 0.1, momentum: 0.9, weight_decay: 0.0 };
//! let mut losses = vec![];
//! for _ in 0..20 {
//!     engine.forward(&[&x], 2, Mode::Train)?;
//!     losses.push(engine.backward(&[0, 1])?);
//!     engine.sgdm(&step);
//! }
//! assert!(losses[19] < 0.5 * losses[0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod engine;
mod error;
mod head;
mod layers;
mod lifetimes;
mod norm;
mod optimizer;
mod part;
mod plan;
mod threads;

pub use engine::{Engine, Mode, Options};
pub use error::{Error, Result};
pub use optimizer::{OptimizerState, Sgdm};
pub use taxel_kernels::optim::Adam;
