//! One setting beside the whole.

use serde::{Deserialize, Serialize};

use super::primary::Primary;

/// A setting beside the whole, on the same samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contrast {
    /// Mean of the primary metric, in its unit.
    #[serde(rename = "accuracy", alias = "score")]
    pub score: f64,
    /// 95 % interval of it, where the test parts give one.
    #[serde(rename = "accuracy_interval", alias = "score_interval")]
    pub score_interval: Option<[f64; 2]>,
    /// Its score less that of the whole, in percentage points or in the metric's unit.
    pub difference: f64,
    /// 95 % interval of the difference, where the test gives one.
    pub interval: Option<[f64; 2]>,
    /// Two-sided p against the whole, Holm-corrected over its curve.
    pub p_holm: Option<f64>,
    /// Whether it is worse than the whole beyond doubt.
    pub worse: bool,
}

impl Contrast {
    /// Checks whether it does instead of the whole: not worse beyond doubt, and no loss above `margin` to be seen.
    pub fn suffices(&self, margin: f64, primary: &Primary) -> bool {
        !self.worse && primary.loss(self.difference) <= margin * (1.0 + 1e-9)
    }
}
