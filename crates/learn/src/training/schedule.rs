//! How the learning rate changes over the epochs.

use serde::{Deserialize, Serialize};

use crate::problem::{Check, require};

/// Factor of [`Schedule::Steps`] where nothing else is said.
const FACTOR: f64 = 0.1;

/// The learning rate of each epoch as a multiple of the first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Schedule {
    /// The same rate in every epoch.
    Constant {},
    /// Multiplied by `factor` at each share of the epochs in `at`.
    Steps {
        /// Shares of the epochs, ascending in (0, 1), such as `[0.6, 0.85]`.
        at: Vec<f64>,
        /// `(0, 1]`. Default 0.1.
        #[serde(default = "factor")]
        factor: f64,
    },
    /// Half a cosine from the rate down to `floor` times the rate (PyTorch's `CosineAnnealingLR` over all
    /// epochs).
    Cosine {
        /// The last rate as a share of the first, `[0, 1)`. Default 0.
        #[serde(default)]
        floor: f64,
    },
}

impl Default for Schedule {
    fn default() -> Self {
        Schedule::Constant {}
    }
}

fn factor() -> f64 {
    FACTOR
}

impl Schedule {
    /// Steps down to a tenth at the shares `at` of the epochs.
    pub fn steps(at: &[f64]) -> Self {
        Schedule::Steps { at: at.to_vec(), factor: FACTOR }
    }

    /// Returns the learning rate in `epoch` (from 0) of `epochs`, for a first rate of `lr`.
    pub fn rate(&self, lr: f64, epoch: usize, epochs: usize) -> f64 {
        let done = epoch as f64 / epochs.max(1) as f64;
        match self {
            Schedule::Constant {} => lr,
            Schedule::Steps { at, factor } => {
                let passed = at.iter().filter(|&&share| epoch as f64 >= share * epochs as f64).count();
                lr * factor.powi(passed as i32)
            }
            Schedule::Cosine { floor } => {
                lr * (floor + (1.0 - floor) * (1.0 + (std::f64::consts::PI * done).cos()) / 2.0)
            }
        }
    }

    /// Checks all settings.
    ///
    /// # Errors
    /// Shares that are none, do not ascend or leave (0, 1), a factor or floor outside its range.
    pub fn check(&self) -> Check {
        match self {
            Schedule::Constant {} => Ok(()),
            Schedule::Steps { at, factor } => {
                let inside = at.iter().all(|share| *share > 0.0 && *share < 1.0);
                let ascending = at.windows(2).all(|pair| pair[0] < pair[1]);
                let reason = "must be shares of the epochs, ascending in (0, 1), such as [0.6, 0.85]";
                require(!at.is_empty() && inside && ascending, "at", format!("{at:?}"), reason)?;
                require(*factor > 0.0 && *factor <= 1.0, "factor", factor, "must be in (0, 1]")
            }
            Schedule::Cosine { floor } => {
                let reason = "must be a share of the first rate, in [0, 1)";
                require((0.0..1.0).contains(floor), "floor", floor, reason)
            }
        }
    }
}
