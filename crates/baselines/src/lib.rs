//! Methods that cost almost nothing, and that a network has to beat.
//!
//! All take series `[n, channels, length]`. With one class each they give a score per class, the largest for the predicted
//! one: [`Method::fit`] learns from the training part, [`Fitted::scores`] predicts. With values they predict these:
//! [`Method::fit_values`].
//!
//! ```
//! use taxel_baselines::{Method, Series};
//!
//! let x = [0.0, 0.1, 0.9, 1.0];
//! let train = Series::new(&x, 1, 1)?;
//! let fitted = Method::NearestNeighbours { k: 1 }.fit(&train, &[0, 0, 1, 1], 2, 0, "doc")?;
//! let scores = fitted.scores(&Series::new(&[0.2, 0.8], 1, 1)?)?;
//! assert_eq!(scores, [1.0, 0.0, 0.0, 1.0]);
//! let forces = Method::Mean.fit_values(&train, &[1.0, 1.0, 3.0, 3.0], 1, 0, "doc")?;
//! assert_eq!(forces.scores(&Series::new(&[0.2], 1, 1)?)?, [2.0]);
//! # Ok::<(), taxel_baselines::Error>(())
//! ```
//!
//! # Reference
//! See each method: [`MiniRocket`], [`Ridge`], [`Svm`], [`ExtraTrees`].

mod equations;
mod error;
mod extra_trees;
mod fitted;
mod grow;
mod linear;
mod method;
mod minirocket;
mod nearest;
mod ridge;
mod rocket_values;
mod saved;
mod series;
mod softmax;
mod summary;
mod svm;
mod values;

pub use error::{Error, Result};
pub use extra_trees::ExtraTrees;
pub use fitted::{Fitted, Workspace};
pub use linear::{LinearFeatures, LinearModel};
pub use method::Method;
pub use minirocket::{Draws, MiniRocket};
pub use nearest::{Nearest, NearestValues};
pub use ridge::{ALPHAS, FeatureMatrix, Ridge};
pub use rocket_values::RocketValues;
pub use saved::Saved;
pub use series::Series;
pub use softmax::softmax;
pub use svm::{Svm, SvmKernel};
pub use taxel_kernels::rocket::{Dilated, RocketMemory};
pub use values::FittedValues;
