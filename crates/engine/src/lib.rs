//! Graphs compiled for training on the CPU.
//!
//! [`Engine::new`] lays a graph out for a largest batch: buffers are allocated once, values lie
//! channels last, gradients are computed only where a parameter needs them. A training step is
//! [`Engine::forward`] in [`Mode::Train`], [`Engine::backward`] and [`Engine::sgdm`] or another optimiser:
//!
//! ```
//! use taxel_reference_networks::MlpConfig;
//! use taxel_engine::{Engine, EngineOptions, Mode, Sgdm};
//! use taxel_graph::{Architecture, Scheme, Weights};
//!
//! let graph = MlpConfig { classes: 2, in_features: 4, hidden: 8 }.graph()?;
//! let weights = Weights::init(&graph, Scheme::Pytorch, 0, "doc");
//! let mut engine = Engine::new(&graph, &weights, EngineOptions { batch: 2, threads: 1, ..EngineOptions::default() })?;
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
//!
//! A network for prediction only is an [`Evaluator`], which never changes: threads share one by reference, each
//! with a [`Workspace`] of its own, which has no memory for gradients:
//!
//! ```
//! use taxel_reference_networks::MlpConfig;
//! use taxel_engine::{EngineOptions, Evaluator};
//! use taxel_graph::{Architecture, Scheme, Weights};
//!
//! let graph = MlpConfig { classes: 2, in_features: 4, hidden: 8 }.graph()?;
//! let weights = Weights::init(&graph, Scheme::Pytorch, 0, "doc");
//! let evaluator = Evaluator::new(&graph, &weights, EngineOptions { batch: 2, ..EngineOptions::default() })?;
//! let x = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
//! let caller = || -> taxel_engine::Result<Vec<f32>> {
//!     let mut workspace = evaluator.workspace();
//!     Ok(evaluator.predict(&mut workspace, &[&x], 2)?.to_vec())
//! };
//! let [one, other] = std::thread::scope(|scope| {
//!     [scope.spawn(caller), scope.spawn(caller)].map(|thread| thread.join().expect("a thread ends"))
//! });
//! assert_eq!(one?, other?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod backward;
mod compiled;
mod engine;
mod error;
mod evaluator;
mod forward;
mod gradients;
mod head;
mod layers;
mod lifetimes;
mod norm;
mod optimizer;
mod options;
mod part;
mod part_gradients;
mod plan;
mod state;
mod threads;
mod workspace;

pub use engine::{Engine, Mode};
pub use error::{Error, Result};
pub use evaluator::Evaluator;
pub use optimizer::{OptimizerState, Sgdm};
pub use options::{Decay, EngineOptions, FrozenStatistics, Precision};
pub use taxel_kernels::optim::Adam;
pub use workspace::Workspace;

/// Checks whether this processor computes in `precision`.
///
/// # Errors
/// The reason why not.
pub fn supports(precision: Precision) -> Result<()> {
    let refuse = |reason| Err(Error::Precision { reason });
    match precision {
        Precision::F32 => Ok(()),
        Precision::Bf16 => taxel_kernels::half::supported().or_else(refuse),
    }
}

/// Returns the width of the vectors that kernels compute with on this processor: `AVX-512`, `AVX2` or `portable`.
pub fn vectors() -> &'static str {
    taxel_kernels::simd::level().name()
}
